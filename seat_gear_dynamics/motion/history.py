"""The time history of a motion: deflection, its rate and force of both meshes, step by step."""

from dataclasses import dataclass
from math import inf, nextafter, pi

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion.march import Inputs, March
from seat_gear_dynamics.motion.system import System
from seat_gear_dynamics.plotting import Plottable

Array = NDArray[np.float64]


@dataclass(frozen=True)
class History(Plottable, figure="motion:plot_history", table="motions:history_table"):
    """A motion at a steady drive, at every step of the march."""

    tau: Array
    """Dimensionless time from the start of the record, shape (n,)."""
    delta: Array
    """δ/b_c of P12 and P34, shape (n, 2)."""
    rate: Array
    """Its rate per unit of τ, shape (n, 2)."""
    force: Array
    """Mesh force, N, shape (n, 2)."""
    contact: Array
    """1 where teeth touch, 0 where they do not, shape (n, 2)."""
    section: Array
    """δ/b_c and rate of P12 at mesh phase 0, shape (sampled, 2), over a longer stretch than the record."""


def history(
    system: System, *, transient: int = 600, periods: int = 12, sampled: int = 1000, state: Array | None = None
) -> History:
    """Run `system` in for `transient` mesh periods, record `periods` step by step and `sampled` by their section.

    Starts at static deflection, or at `state` (24,) with mesh phase 0. Raises ValueError at zero frequency and
    DivergedError where the solution blows up.
    """
    point = system.operating_point
    if point.frequency == 0:
        raise ValueError("The frequency is 0, where there is no mesh period to record; give a speed other than 0.")
    march, inputs = March(system.train, load=point.load), Inputs(point.frequency, point.load)
    if state is not None:
        march.state = state
    period = 2 * pi / abs(point.frequency)
    begin = transient * period
    march.advance((0.0, inputs), (begin * (1 - 1e-9), inputs))
    rows, times = [], []
    begin = march.tau
    while march.tau < begin + periods * period:
        times.append(march.tau - begin)
        rows.append(march.meshes(point.frequency))
        march.advance((march.tau, inputs), (nextafter(march.tau, inf), inputs))
    sections: list[Array] = []
    march.advance((march.tau, inputs), (march.tau + sampled * period, inputs), sections.append)
    values = np.array(rows)
    return History(
        np.array(times),
        values[:, :, 0],
        values[:, :, 1],
        values[:, :, 2] * march.force_unit,
        values[:, :, 3],
        np.concatenate(sections)[:, 1:3],
    )
