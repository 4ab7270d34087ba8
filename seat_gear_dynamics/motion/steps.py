"""The compiled march: classical Runge-Kutta (20)-(21), step locked to the mesh period, state and tangent together.

(20) as printed lacks its factor 1/6 (an erratum): y + h/6·(k1 + 2·k2 + 2·k3 + k4) is the method, and is used.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seat_gear_dynamics.motion import kernel, stages, vectors
from seat_gear_dynamics.motion.kernel import (
    BEYOND,
    DIVERGED,
    FINISHED,
    RENORMALISE,
    SECTIONS_FULL,
    Equations,
    Grid,
    Segment,
    look_up,
    plan,
    record,
    renormalise,
)
from seat_gear_dynamics.motion.revision import revision
from seat_gear_dynamics.motion.stages import (
    accelerations,
    closing,
    contact_of,
    counted,
    excitation_of,
    gathered,
    laid_down,
    mechanics_of,
    moved,
    note_tally,
    push_of,
    tally_of,
    weighted,
)
from seat_gear_dynamics.motion.vectors import align_stack, lane

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@njit(error_model="numpy", nogil=True)
def _march(
    y: Array,
    z: Array,
    clock: Array,
    place: Index,
    growth: Array,
    window: Array,
    sections: Array,
    recorded: Index,
    eq: Equations,
    grid: Grid,
    segment: Segment,
) -> int:
    align_stack()
    row, finest = np.empty((2, 3)), grid.levels - 1
    period = grid.base << finest
    m, tally, code = mechanics_of(eq), tally_of(window), FINISHED
    q, v = gathered(y, z, 0), gathered(y, z, 12)
    while clock[0] < segment.end:
        if recorded[0] >= sections.shape[0]:
            code = SECTIONS_FULL
            break
        since = clock[0] - segment.tau
        frequency = segment.frequency + segment.frequency_slope * since
        push = push_of(m.drive, segment.load + segment.load_slope * since)
        level, h, rate, moved_by = plan(frequency, clock, place, grid)
        half = 2 * (place[0] >> (finest - level))
        toward = 0 if rate == 0.0 else (1 if moved_by > 0 else -1)
        look_up(row, grid, level, half)
        x = excitation_of(row, rate)
        found = contact_of(q, v, x, m)
        if not abs(lane(found.delta, 0)) + abs(lane(found.delta, 1)) < BEYOND:
            code = DIVERGED
            break
        tally = counted(tally, found, h)
        a1 = accelerations(q, v, push, x, found, m)
        look_up(row, grid, level, half + toward)
        x = excitation_of(row, rate)
        q2, v2 = moved(q, 0.5 * h, v), moved(v, 0.5 * h, a1)
        a2 = accelerations(q2, v2, push, x, contact_of(q2, v2, x, m), m)
        q3, v3 = moved(q, 0.5 * h, v2), moved(v, 0.5 * h, a2)
        a3 = accelerations(q3, v3, push, x, contact_of(q3, v3, x, m), m)
        look_up(row, grid, level, half + 2 * toward)
        x = excitation_of(row, rate)
        q4, v4 = moved(q, h, v3), moved(v, h, a3)
        a4 = accelerations(q4, v4, push, x, contact_of(q4, v4, x, m), m)
        q, v = moved(q, h / 6, weighted(v, v2, v3, v4)), moved(v, h / 6, weighted(a1, a2, a3, a4))
        clock[0] += h
        place[0] = (place[0] + moved_by) % grid.cycle
        place[1] += 1
        at_section = moved_by != 0 and place[0] % period == 0
        if at_section or place[1] >= RENORMALISE:
            place[1] = 0
            laid_down(q, y, z, 0)
            laid_down(v, y, z, 12)
            renormalise(z, growth, eq.coupled)
            q, v = gathered(y, z, 0), gathered(y, z, 12)
        if at_section:
            look_up(row, grid, level, 2 * (place[0] >> (finest - level)))
            x = excitation_of(row, rate)
            delta, speed = closing(m.direction, q, x.error), closing(m.direction, v, x.rate)
            record(sections, recorded, clock[0], lane(delta, 0), lane(speed, 0), growth)
    laid_down(q, y, z, 0)
    laid_down(v, y, z, 12)
    note_tally(tally, window)
    return code


def _entry(revision: int) -> Any:
    @njit(cache=True, error_model="numpy", nogil=True)
    def march(
        y: Array,
        z: Array,
        clock: Array,
        place: Index,
        growth: Array,
        window: Array,
        sections: Array,
        recorded: Index,
        eq: Equations,
        grid: Grid,
        segment: Segment,
    ) -> int:
        """Advance by whole steps while a step starts before `segment.end`; return a result code.

        In and out: y, z (24,) state and tangent; clock (2,) = τ and the creep's unspent phase in finest steps; place
        (2,) = finest step of the common cycle and steps since the tangent was rescaled; growth (2,) logarithmic growth
        since the last section; window (2, 6); sections (n, 5) with recorded[0] rows used. Frequency and load are held
        over a step at their value at its start, so that a step depends on no input later than that: the result is
        independent of how the time axis is cut into calls.
        """
        _ = revision
        return int(_march(y, z, clock, place, growth, window, sections, recorded, eq, grid, segment))

    return march


march = _entry(revision(kernel, stages, vectors))
