"""How small differences travel: propagators from section to section, and what a turned frame of them grows by."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, pi

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seat_gear_dynamics.motion.integrators.event_locating import EventLocating
from seat_gear_dynamics.motion.integrators.integrate import Method, integrate_time
from seat_gear_dynamics.motion.integrators.trajectory import ContactChanges
from seat_gear_dynamics.motion.system import System

Array = NDArray[np.float64]

_LONGEST_STRETCH = 2.0  # τ between two turns of the frame; exponents spread by about 1 a unit: e² from first to last


@dataclass(frozen=True)
class Growth:
    """One stretch of a motion, and what a frame of directions grew by over it."""

    tau: float
    """Its end, τ."""
    state: Array
    """At its end, (24,)."""
    logarithms: Array
    """Logarithmic growth of each direction, those before it left out, (vectors,)."""
    contact_share: Array
    """Share of the time that each mesh was in contact, (2,)."""


@dataclass(frozen=True)
class Propagation:
    """One stretch of a motion, and what became of small differences over it."""

    tau: float
    """Its end, τ."""
    state: Array
    """At its end, (24,)."""
    propagator: Array
    """∂(state at the end)/∂(state at the start), (24, 24), jumps at changes of contact in it."""
    contact_share: Array
    """Share of the time that each mesh was in contact, (2,)."""
    changes: ContactChanges


def propagators(
    system: System,
    state: ArrayLike,
    *,
    count: int,
    start: float = 0.0,
    interval: float | None = None,
    method: Method | None = None,
) -> Iterator[Propagation]:
    """Yield `count` stretches of `interval` (units of τ; None is a mesh period of P12) from `state` at τ = `start`.

    The product of the propagators, latest on the left, is the propagator over all. Over one period of a periodic motion
    it is the monodromy matrix; P34 and the shafts repeat after more periods than one. `method` None is
    `EventLocating()`; with any other the jumps are missing that damping in contact only gives. Raises ValueError at
    frequency 0 without an interval, and what `integrate_time` raises.
    """
    length = mesh_period(system) if interval is None else interval
    now = np.asarray(state, dtype=float)
    for n in range(count):
        begin, end = start + n * length, start + (n + 1) * length
        run = integrate_time(
            system, (begin, end), now, method=method or EventLocating(), tangent=np.eye(24), every_step=False
        )
        now = run.state
        yield Propagation(end, now, run.tangent, run.contact_share(), run.changes)


def growths(
    system: System,
    state: ArrayLike,
    *,
    count: int,
    start: float = 0.0,
    vectors: int = 24,
    interval: float | None = None,
    method: Method | None = None,
) -> Iterator[Growth]:
    """Yield the growth of `vectors` directions over each of `count` stretches, as of `propagators`.

    A frame of orthonormal directions, at first those of the leading coordinates, travels along, and is made
    orthonormal again by QR at least every 2 units of τ (Benettin et al. 1980; Shimada & Nagashima 1979). Means of the
    growths over many stretches, the first ones left out while the frame turns, divided by the interval are the Lyapunov
    exponents per unit of τ in falling order. Raises as `propagators`, and ValueError for a number of vectors
    that is not from 1 to 24. Limits: pairs apart have each their own exponents, of which this gives the union.
    """
    if not 1 <= vectors <= 24:
        raise ValueError(f"Asked for the growth of {vectors} vectors, expected 1 to 24.")
    length = mesh_period(system) if interval is None else interval
    parts = ceil(length / _LONGEST_STRETCH)
    now, frame = np.asarray(state, dtype=float), np.eye(24, vectors)
    for n in range(count):
        grown, share = np.zeros(vectors), np.zeros(2)
        for part in range(parts):
            marks = (start + (n + part / parts) * length, start + (n + (part + 1) / parts) * length)
            run = integrate_time(system, marks, now, method=method or EventLocating(), tangent=frame, every_step=False)
            frame, upper = np.linalg.qr(run.tangent)
            grown += np.log(np.abs(np.diag(upper)))
            share += run.contact_share() / parts
            now = run.state
        yield Growth(start + (n + 1) * length, now, grown, share)


def mesh_period(system: System) -> float:
    """Return the mesh period of P12 in units of τ; raises ValueError at frequency 0, where there is none."""
    frequency = abs(system.operating_point.frequency)
    if frequency == 0:
        raise ValueError("The frequency is 0, where there is no mesh period; give an interval in units of tau.")
    return 2 * pi / frequency
