"""Basins of attraction: which motion each initial state of P12 leads to, at one operating point."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seat_gear_dynamics.motion import STATE_NAMES, System
from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.regimes.attractors import TOLERANCE, Attractor, Labels, attractors
from seat_gear_dynamics.regimes.bands import binomial_error
from seat_gear_dynamics.regimes.points import increasing

Array = NDArray[np.float64]

_U1, _U1_RATE = STATE_NAMES.index("u1"), STATE_NAMES.index("u1'")


@dataclass(frozen=True)
class Share:
    """How much of the plane leads somewhere, and the standard error of that."""

    value: float
    error: float


@dataclass(frozen=True, eq=False)
class Basins(Plottable, figure="basins:draw_basins", table="regimes:basins_table"):
    """The plane of initial (δ, δ′) of P12, coloured by the motion that each start settles on."""

    deflections: Array
    """Initial δ/b_c, (m,)."""
    rates: Array
    """Initial rate of δ/b_c per τ, (n,)."""
    labels: Labels
    """Index into `attractors`, or `attractors.LOST` where the motion diverged, (n, m): a row per rate."""
    attractors: tuple[Attractor, ...]

    def share(self, label: int) -> Share:
        """Return the share of the plane that leads to attractor `label` (or is LOST).

        The standard error is the binomial one, as if the cells were drawn at random (Menck et al. 2013); on a regular
        grid it overstates the error of a basin with a smooth edge. Limit: a share is one of this plane, not of
        the space of all initial states.
        """
        value = float((self.labels == label).mean())
        return Share(value, binomial_error(value, self.labels.size))


def plane_starts(system: System, deflections: ArrayLike, rates: ArrayLike) -> Array:
    """Return the initial states over the plane of δ/b_c (m,) and its rate per τ (n,), shape (n·m, 24), row by row.

    Each starts from rest at static deflection and mesh phase 0. What δ and its rate lack is put on u1 and its rate
    alone: s1 is turned, no other gear moves. That fixes where the plane lies in the space of states.
    """
    first = np.asarray(deflections, dtype=float)
    second = np.asarray(rates, dtype=float)
    rest = system.static_state()
    delta, rate = (float(each[0]) for each in system.deflections(0.0, rest))
    starts = np.tile(rest, (len(second), len(first), 1))
    starts[:, :, _U1] += first[None, :] - delta
    starts[:, :, _U1_RATE] += second[:, None] - rate
    return starts.reshape(-1, len(rest))


def basins(
    system: System,
    deflections: ArrayLike,
    rates: ArrayLike,
    *,
    transient: int = 400,
    periods: int = 96,
    tolerance: float = TOLERANCE,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Basins:
    """Return the basins of `system` over a plane of initial δ/b_c and rate of P12, both strictly increasing.

    Starts as `plane_starts` has them; motions told apart as `attractors` does it, with its limits: sections count as
    sets, so the two phases of a period-2 motion are one motion and one basin. Raises ValueError for grids that do not
    increase.
    """
    plane = tuple(
        increasing(name, values, least=-np.inf, unit=unit)
        for name, values, unit in (("deflections", deflections, "b_c"), ("rates", rates, "b_c per τ"))
    )
    found, labels = attractors(
        system,
        plane_starts(system, *plane),
        transient=transient,
        periods=periods,
        tolerance=tolerance,
        workers=workers,
        progress=progress,
    )
    return Basins(plane[0], plane[1], labels.reshape(len(plane[1]), len(plane[0])), found)
