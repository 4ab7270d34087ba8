"""What is asked of lanes and what they answer, as plain arrays over the lanes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LanePoints:
    """Operating points of one train, one a lane: arrays of shape (n,), or numbers that hold for all lanes."""

    frequency: ArrayLike
    """Omega of P12, signed, not 0."""
    load: ArrayLike
    """T4, N·m."""
    damping_ratio: ArrayLike | None = None
    """xi of both meshes; None: the train's own."""
    backlash: ArrayLike | None = None
    """b of both meshes, m; None: the train's own."""
    state: ArrayLike | None = None
    """Initial states at mesh phase 0, (n, 24) in the order of STATE_NAMES; None: rest at static deflection.

    Motion across the line of action is left out: it dies away by itself and changes nothing else.
    """


@dataclass(frozen=True, eq=False)
class LaneResponse:
    """The motions of n lanes at steady drives, after their run-in."""

    section: Array
    """Stroboscopic Poincaré section of P12 at mesh phase 0, (n, periods, 2): δ/b_c and its rate per τ."""
    growth: Array
    """Logarithmic growth of the tangent over each sampled period, (n, periods): P12's, or the train's if coupled.

    NaN where no tangent was asked for. Motion across the line of action has no share in it, as it has in
    `motion.integrate`: where a support is so little damped that this motion dies away slowest of all, exponents of
    calm motions are lower here, and tell more about the mesh.
    """
    windows: Array
    """Dimensionless force statistics over the sampled periods, (n, meshes, 6) in the order of kernel.WINDOW_COLUMNS.

    NaN where no statistics were asked for.
    """
    state: Array
    """Final state at mesh phase 0, (n, 24), at rest across the line of action.

    Where P34 was left out it is as it started.
    """
    diverged: NDArray[np.bool_]
    """Lanes whose solution left every bound, (n,); all else is NaN for them. P34 has no say where it was left out."""


@dataclass(frozen=True, eq=False)
class CheckedPoints:
    """Points as arrays of floats of one length."""

    frequency: Array
    load: Array
    damping_ratio: Array | None
    backlash: Array | None
    state: Array | None


def checked(points: LanePoints) -> CheckedPoints:
    """Return `points` as arrays of one length; raise ValueError, a sentence, where they are impossible.

    States may hold anything: a state that is no number is a diverged motion, not an error.
    """
    named: dict[str, ArrayLike | None] = {
        "frequency": points.frequency,
        "load": points.load,
        "damping ratio": points.damping_ratio,
        "backlash": points.backlash,
    }
    given = {name: np.atleast_1d(np.array(value, dtype=float)) for name, value in named.items() if value is not None}
    state = None if points.state is None else np.array(points.state, dtype=float)
    _check_shapes(given, state)
    for name, values in given.items():
        _check_values(name, values)
    count = {"count": np.zeros(0 if state is None else len(state))} if state is not None else {}
    arrays = dict(zip([*given, *count], np.broadcast_arrays(*given.values(), *count.values()), strict=True))
    frequency, load = np.array(arrays["frequency"]), np.array(arrays["load"])
    return CheckedPoints(frequency, load, arrays.get("damping ratio"), arrays.get("backlash"), state)


def _check_shapes(given: dict[str, Array], state: Array | None) -> None:
    lengths = {name: len(values) for name, values in given.items() if values.shape != (1,)}
    if any(values.ndim != 1 for values in given.values()):
        shapes = ", ".join(f"{name} {values.shape}" for name, values in given.items())
        raise ValueError(f"Points have the shapes {shapes}; expected numbers or arrays with one axis, over lanes.")
    if state is not None:
        if state.ndim != 2 or state.shape[1] != 24:
            raise ValueError(f"The initial states have shape {state.shape}, expected (lanes, 24).")
        lengths["state"] = len(state)
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise ValueError(f"Points have different numbers of lanes: {found}; give all the same number, or one value.")


def _check_values(name: str, values: Array) -> None:
    if not np.isfinite(values).all():
        bad = int(np.flatnonzero(~np.isfinite(values))[0])
        raise ValueError(f"The {name} of lane {bad} is {float(values[bad])!r}, expected a finite number.")
    if name == "frequency" and (values == 0).any():
        bad = int(np.flatnonzero(values == 0)[0])
        raise ValueError(f"The frequency of lane {bad} is 0, where there is no mesh period to sample; give another.")
    if name in ("damping ratio", "backlash") and (values < 0).any():
        bad = int(np.flatnonzero(values < 0)[0])
        raise ValueError(f"The {name} of lane {bad} is {float(values[bad])!r}, expected at least 0.")
