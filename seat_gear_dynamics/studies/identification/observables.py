"""What a dwell says whatever its phase: mean, spread, quantiles, amplitudes at mesh orders, and how sure they are."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LOW, HIGH = 0.05, 0.95
"""Quantiles in place of the extremes, which depend on how long one looks and on the sensor's noise."""
STATISTICS = ("mean", "spread", "low", "high")
MOST_ORDERS = 3
"""Mesh orders told where the sampling rate allows."""
_FITTED_ORDERS = 10  # those that are not told would else leak into those that are
PARTS = 10
"""Parts of a dwell, of which each is left out once to see how firm a statistic is."""
_SAMPLES_A_PART = 5
_BLOCK_PERIODS = 8  # short enough that 1 % of error in the speed turns a line by a twelfth of a period
_RATE_OVER_LINE = 2.2  # samples per period of the highest order: above Nyquist's 2 by a filter's slope


@dataclass(frozen=True, eq=False)
class Dwell:
    """A stretch of steady speed and load with what a sensor showed, in SI units."""

    speed: float
    """Mean, rad/s of s1, signed, not 0."""
    load: float
    """Mean of T4, N·m."""
    time: Array
    """s, increasing, (n,)."""
    angle: Array
    """Angle of s1 at `time` from any start, rad, (n,)."""
    value: Array
    """What the sensor showed, (n,)."""


@dataclass(frozen=True, eq=False)
class Observed:
    """The observables of one dwell."""

    names: tuple[str, ...]
    """STATISTICS, then `order 1`, `order 2`, … as far as the sampling rate reaches."""
    value: Array
    """In the sensor's unit, (m,)."""
    covariance: Array
    """Of `value`, by leaving out parts of the dwell, (m, m)."""
    parts: Array
    """`value` with each part left out, (PARTS, m)."""
    regular: float
    """Share of the variance that lies in the mesh orders and their halves, 0 to 1; NaN where sampling is too slow."""

    @property
    def standard_error(self) -> Array:
        """Of each observable, (m,)."""
        return np.sqrt(np.diag(self.covariance))


def names_for(orders: int) -> tuple[str, ...]:
    """Return the observables' names with `orders` mesh orders."""
    return (*STATISTICS, *(f"order {k}" for k in range(1, orders + 1)))


def observe(dwell: Dwell, teeth: int, *, noise: float = 0.0, most_orders: int = MOST_ORDERS) -> Observed:
    """Return the observables of `dwell`; s1 has `teeth` teeth, the sensor white noise of deviation `noise`.

    Amplitudes are fitted by least squares to blocks of 8 mesh periods at the measured angle (order tracking; Fyfe &
    Munck 1997), their powers averaged over the blocks and freed of what the noise adds (each of the two coefficients
    has the variance 2σ²/n), so no phase has to be known and none has to last. The covariance is the delete-one-part
    jackknife's (Künsch 1989, block form). Raises ValueError for a dwell of fewer than 50 samples, of another number
    of times than values, with a value that is not finite, or at standstill. Limits: below 2.2 samples per period of
    an order that order is left out; what lies beyond the tenth, or beyond half the sampling rate, leaks a little;
    statistics of few hundred samples whose rate is a whole ratio of the mesh frequency see few phases.
    """
    _check(dwell)
    phase = dwell.angle * teeth / (2 * np.pi)
    reach = _reach(phase)
    orders = min(most_orders, reach)
    part = np.arange(len(phase)) * PARTS // len(phase)
    powers = _Powers(phase, dwell.value, part, orders, reach, noise)
    everything = np.ones(PARTS, dtype=bool)
    value = _values(dwell.value, powers, everything)
    without = [np.arange(PARTS) != left_out for left_out in range(PARTS)]
    parts = np.array([_values(dwell.value[kept[part]], powers, kept) for kept in without])
    apart = parts - parts.mean(axis=0)
    covariance = (PARTS - 1) / PARTS * apart.T @ apart
    return Observed(names_for(orders), value, covariance, parts, powers.regular)


def statistics(value: Array) -> Array:
    """Return mean, standard deviation, low and high quantile along the last axis, shape (..., 4)."""
    low, high = np.quantile(value, (LOW, HIGH), axis=-1)
    return np.stack([value.mean(axis=-1), value.std(axis=-1), low, high], axis=-1)


def whitened(observed: Observed, floor: float) -> Array:
    """Return W with WᵀW the inverse covariance of a dwell's observables, (m, m).

    `floor` times the largest observable is added to every standard error, in quadrature; correlations, which
    come from few parts, are shrunk towards none as if as many parts as observables had shown none.
    """
    deviation = observed.standard_error
    extra = floor * float(np.abs(observed.value).max())
    shrink = len(observed.parts) / (len(observed.parts) + len(observed.value))
    covariance = shrink * observed.covariance
    covariance[np.diag_indices_from(covariance)] = deviation**2 + extra**2
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


def _check(dwell: Dwell) -> None:
    lengths = {len(dwell.time), len(dwell.angle), len(dwell.value)}
    if lengths != {len(dwell.value)} or len(dwell.value) < PARTS * _SAMPLES_A_PART:
        raise ValueError(
            f"The dwell at {dwell.speed:.4g} rad/s has {len(dwell.time)} times and {len(dwell.value)} samples, "
            f"expected as many and at least {PARTS * _SAMPLES_A_PART}; stay longer or sample faster."
        )
    if not np.isfinite(dwell.value).all():
        bad = int(np.flatnonzero(~np.isfinite(dwell.value))[0])
        raise ValueError(
            f"Sample {bad} of the dwell at {dwell.speed:.4g} rad/s is {dwell.value[bad]!r}, expected a finite number; "
            f"leave such samples out."
        )
    if not dwell.speed or dwell.angle[0] == dwell.angle[-1]:
        raise ValueError("The shaft stands still in a dwell, where no tooth meshes; give dwells at speed.")


def _reach(phase: Array) -> int:
    """Return how many mesh orders the sampling resolves, in a record long enough for blocks in every part."""
    periods = abs(float(phase[-1] - phase[0]))
    if periods < PARTS * _BLOCK_PERIODS:
        return 0
    return int(min(_FITTED_ORDERS, len(phase) / periods // _RATE_OVER_LINE))


class _Powers:
    """The power of each mesh order in each part of a dwell."""

    def __init__(
        self, phase: Array, value: Array, part: NDArray[np.int64], orders: int, reach: int, noise: float
    ) -> None:
        self.orders = orders
        self._power, self._blocks = np.zeros((PARTS, orders)), np.zeros(PARTS)
        explained = total = 0.0
        for which in range(PARTS if orders else 0):
            own = part == which
            for rows in _blocks(phase[own]):
                lines, left, variance = _lines(phase[own][rows], value[own][rows], reach)
                self._power[which] += lines[:orders] - 4 * noise**2 / len(rows)
                self._blocks[which] += 1
                explained, total = explained + variance - left, total + variance
        self.regular = explained / total if total > 0 else float("nan")

    def amplitudes(self, kept: NDArray[np.bool_]) -> Array:
        """Return the amplitudes over the parts that are `kept`, (orders,)."""
        if not self.orders:
            return np.zeros(0)
        mean = self._power[kept].sum(axis=0) / self._blocks[kept].sum()
        return np.asarray(np.sqrt(np.maximum(mean, 0.0)))


def _blocks(phase: Array) -> Sequence[NDArray[np.int64]]:
    """Return the rows of whole blocks of periods."""
    which = (np.abs(phase - phase[0]) // _BLOCK_PERIODS).astype(np.int64)
    return [np.flatnonzero(which == k) for k in range(max(1, int(which[-1])))]


def _lines(phase: Array, value: Array, orders: int) -> tuple[Array, float, float]:
    """Return the power of each order, and the residual and the whole variance of a block."""
    halves = np.arange(1, 2 * orders + 1) / 2
    angle = 2 * np.pi * np.outer(phase, halves)
    design = np.column_stack([np.ones(len(phase)), np.cos(angle), np.sin(angle)])
    found = np.linalg.lstsq(design, value, rcond=None)[0]
    left = value - design @ found
    freedom = max(len(value) - design.shape[1], 1)
    unexplained = float(left @ left) / freedom
    cosine, sine = found[2 : 1 + 2 * orders : 2], found[2 + 2 * orders :: 2]
    return cosine**2 + sine**2, unexplained, float(value.var(ddof=1))


def _values(value: Array, powers: _Powers, kept: NDArray[np.bool_]) -> Array:
    return np.concatenate([statistics(value), powers.amplitudes(kept)])
