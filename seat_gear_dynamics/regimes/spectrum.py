"""The whole Lyapunov spectrum of a map or a flow, and what a tangent does where a force jumps."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seat_gear_dynamics.regimes.exponent import SHORTEST_GROWTH, largest_exponent

Array = NDArray[np.float64]
Advance = Callable[[Array], Array]

_GRAZING = 1e-9  # below this share of its largest possible value the speed of a crossing is rounding


class CrossingError(ArithmeticError):
    """A switching surface is not crossed from one side to the other; the text says how it is met."""


@dataclass(frozen=True)
class Spectrum:
    """The k largest Lyapunov exponents, largest first up to their errors."""

    values: Array
    """Exponents per unit of the interval's time, (k,)."""
    errors: Array
    """Their standard errors, from block means as for `largest_exponent`, (k,)."""
    growth: Array
    """Logarithmic growth along each direction over each interval, (count, k)."""

    @property
    def sum(self) -> float:
        """Sum of the exponents; with all of them it is the mean rate at which volume grows."""
        return float(self.values.sum())


def spectrum(advance: Advance, tangent: Array, count: int, *, interval: float = 1.0, discard: int = 0) -> Spectrum:
    """Return the Lyapunov spectrum, by orthonormalising tangents after every interval.

    Source: Benettin, Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 9-30; Shimada & Nagashima 1979, Prog. Theor.
    Phys. 61, 1605-1616; orthonormalised by QR.

    `advance` takes tangents (d, k) as columns through the next interval of the motion and returns them (d, k): it holds
    the state, as `along_map` and `along_flow` do, or as an integrator with contact changes and `saltation` does.
    `tangent` (d, k), k <= d, is where they start; `count` intervals of length `interval` are measured after `discard`
    that are not. Exponents are per unit of `interval`; count >= 16.

    Raises ValueError for arguments of other shapes or sizes, and ArithmeticError where tangents stop being finite or a
    direction collapses, which says so of an exponent of minus infinity (as of a map of lower rank than k). Limits: over
    an interval tangents must not grow or shrink by more than about 1e15 against each other; errors do not cover a
    transient; exponents closer than their errors may come in either order.
    """
    _check(tangent, count, discard, interval)
    frame, growth = np.linalg.qr(np.asarray(tangent, dtype=float))[0], np.empty((count, tangent.shape[1]))
    for step in range(-discard, count):
        frame, stretch = np.linalg.qr(_finite(advance(frame), frame.shape, step + discard))
        sizes = np.abs(np.diag(stretch))
        if not sizes.all():
            lost = int(np.argmin(sizes))
            raise ArithmeticError(
                f"In interval {step + discard} tangent {lost} collapsed: its exponent is minus infinity. Ask for fewer."
            )
        if step >= 0:
            growth[step] = np.log(sizes)
    exponents = [largest_exponent(column, interval) for column in growth.T]
    return Spectrum(np.array([e.value for e in exponents]), np.array([e.error for e in exponents]), growth)


def _check(tangent: Array, count: int, discard: int, interval: float) -> None:
    if tangent.ndim != 2 or not 0 < tangent.shape[1] <= tangent.shape[0]:
        raise ValueError(f"The tangents have shape {tangent.shape}; expected (d, k) with k from 1 to d.")
    if np.linalg.matrix_rank(tangent) < tangent.shape[1]:
        raise ValueError(
            f"The {tangent.shape[1]} tangents are not independent; expected as many directions as columns."
        )
    if count < SHORTEST_GROWTH or discard < 0:
        raise ValueError(
            f"Asked for {count} intervals after {discard}; expected at least {SHORTEST_GROWTH} after at least 0."
        )
    if not 0 < interval < float("inf"):
        raise ValueError(f"The interval is {interval!r}; expected a finite length above 0.")


def _finite(tangent: Array, shape: tuple[int, ...], step: int) -> Array:
    if tangent.shape != shape:
        raise ValueError(f"Interval {step} returned tangents of shape {tangent.shape}; expected {shape}.")
    if not np.isfinite(tangent).all():
        raise ArithmeticError(f"In interval {step} the tangents stopped being finite: the motion diverged.")
    return tangent


def along_map(image: Callable[[Array], Array], jacobian: Callable[[Array], Array], start: ArrayLike) -> Advance:
    """Return the `advance` of a map x → image(x) with Jacobian (d, d) `jacobian(x)`, from `start` (d,) on."""
    state = np.array(start, dtype=float)

    def advance(tangent: Array) -> Array:
        nonlocal state
        moved = jacobian(state) @ tangent
        state = image(state)
        return np.asarray(moved)

    return advance


def along_flow(
    rates: Callable[[float, Array], Array],
    jacobian: Callable[[float, Array], Array],
    start: ArrayLike,
    *,
    interval: float,
    steps: int,
    begin: float = 0.0,
) -> Advance:
    """Return the `advance` of a smooth flow x' = rates(t, x) with Jacobian (d, d) `jacobian(t, x)` over one interval.

    State and tangents go through `steps` classical Runge-Kutta steps together, from `start` (d,) at time `begin` on.
    Raises ValueError for less than one step or an interval that is not above 0. Limits: a fixed step, whose size is the
    caller's to choose; rates must be smooth along the way: where they jump, cut the interval there and use `saltation`.
    """
    if steps < 1 or not 0 < interval < float("inf"):
        raise ValueError(f"Asked for {steps} steps in an interval of {interval!r}; expected at least 1 and above 0.")
    state, time, h = np.array(start, dtype=float), begin, interval / steps

    def slope(t: float, x: Array, z: Array) -> tuple[Array, Array]:
        return rates(t, x), jacobian(t, x) @ z

    def advance(tangent: Array) -> Array:
        nonlocal state, time
        x, z = state, tangent
        for step in range(steps):
            t = time + step * h
            k1, j1 = slope(t, x, z)
            k2, j2 = slope(t + h / 2, x + h / 2 * k1, z + h / 2 * j1)
            k3, j3 = slope(t + h / 2, x + h / 2 * k2, z + h / 2 * j2)
            k4, j4 = slope(t + h, x + h * k3, z + h * j3)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            z = z + h / 6 * (j1 + 2 * j2 + 2 * j3 + j4)
        state, time = x, time + interval
        return z

    return advance


def saltation(
    before: ArrayLike, after: ArrayLike, normal: ArrayLike, normal_rate: float = 0.0, *, reset: ArrayLike | None = None
) -> Array:
    """Return the saltation matrix S (d, d): a tangent z before a switching surface h(t, x) = 0 is S·z behind it.

        S = R + (f⁺ − R·f⁻)·nᵀ / (nᵀ·f⁻ + h_t)

    `before` and `after` (d,) are the rates f⁻ and f⁺ of x on either side, at the crossing; `normal` (d,) is n = ∂h/∂x
    there and `normal_rate` h_t = ∂h/∂t; lengths and signs of h do not matter. R is the identity for a force that jumps
    while the state does not, or `reset` (d, d), the Jacobian of an impact law that does not depend on time. Leine &
    Nijmeijer 2004, Dynamics and Bifurcations of Non-Smooth Mechanical Systems; di Bernardo, Budd, Champneys & Kowalczyk
    2008, Piecewise-smooth Dynamical Systems.

    Raises CrossingError for a grazing contact, where h has no speed and S no limit, and, without a reset, where the
    motion does not come out on the other side: it slides, which S does not describe. Rates that do not jump need no
    correction: S is then the identity, for grazing too. Raises ValueError for shapes that do not fit or values that are
    not finite. Limits: first order; near grazing S grows without bound and the tangent with it, and its validity
    shrinks to neighbours closer than the square of the crossing's speed.
    """
    f, g, n = (np.asarray(v, dtype=float) for v in (before, after, normal))
    _check_crossing(f, g, n, normal_rate)
    jacobian = np.eye(len(f)) if reset is None else np.asarray(reset, dtype=float)
    if jacobian.shape != (len(f), len(f)):
        raise ValueError(f"The reset has shape {jacobian.shape}; expected {(len(f), len(f))}.")
    jump = g - jacobian @ f
    if not jump.any():
        return jacobian
    speed, behind = float(n @ f + normal_rate), float(n @ g + normal_rate)
    if abs(speed) <= _GRAZING * (np.linalg.norm(n) * np.linalg.norm(f) + abs(normal_rate)):
        raise CrossingError(
            f"The surface is grazed: its speed is {speed:.3g} where the rate jumps; expected a crossing."
        )
    if reset is None and speed * behind <= 0:
        raise CrossingError(f"The surface is met with speed {speed:.3g} but left with {behind:.3g}: the motion slides.")
    return np.asarray(jacobian + np.outer(jump, n) / speed)


def _check_crossing(before: Array, after: Array, normal: Array, normal_rate: float) -> None:
    if before.ndim != 1 or not before.shape == after.shape == normal.shape:
        raise ValueError(
            f"Rates and normal have shapes {before.shape}, {after.shape} and {normal.shape}; expected one shape (d,)."
        )
    if not (np.isfinite([before, after, normal]).all() and np.isfinite(normal_rate)):
        raise ValueError("Rates or normal of a crossing are not finite; expected finite numbers.")
    if not normal.any():
        raise ValueError("The normal of a crossing is zero; expected the gradient of the switching function.")
