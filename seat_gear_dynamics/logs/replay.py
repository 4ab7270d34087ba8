"""Replaying a log: its inputs through the same core again, compared with the outputs it holds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.series import JointSeries
from seat_gear_dynamics.sensing import RejectedSampleError, Session
from seat_gear_dynamics.sensing.virtual_sensor import SENSOR_STATE_NAMES

ORIGIN_NAMES = ("origin/s", "origin/ns")
"""In a message of the model's state, behind SENSOR_STATE_NAMES: the stamp of t = 0, whole seconds and ns."""

_STATISTICS = ("mean", "min", "max", "rms")
_MESHES = ("s1_s2", "s3_s4")


@dataclass(frozen=True)
class Replay:
    """How a replay went."""

    samples: int
    """Inputs fed."""
    messages: int
    """Logged force messages that were compared."""
    equal: int
    """Of these, bit for bit equal in all eight statistics."""
    first_difference: str | None
    """The first that was not: stamp, name, logged and replayed value; None when all are equal."""
    begins: str
    """What the replay began from: `first input`, or `model state` where the log begins amid a run."""


@dataclass(frozen=True)
class _Start:
    """Where a replay begins: a state to set (None for rest), the stamps behind which it applies, and t = 0."""

    state: NDArray[np.float64] | None
    after_ns: int
    origin_ns: int


def replay(path: Path | str, train: GearTrain, *, max_gap: float = 0.5) -> Replay:
    """Feed what the monitor was fed (`gear_monitor/input`) to a new session and compare the force statistics.

    A log that begins before the monitor's first sample is replayed from there; one that begins amid a run (a
    snapshot, a file of a split log) from the first of the monitor's own states (`gear_monitor/model_state`) whose
    later inputs are all there, and only forces behind it are compared. Equal bit for bit on the same build, when
    `train` and `max_gap` are what the monitor ran with and nothing reset it or stepped its clock back. Raises LogError
    where the log has no such inputs or outputs.
    """
    bag = Bag(path)
    inputs, outputs = bag.joint(topics.MODEL_INPUT.name), bag.joint(topics.MESH_FORCE.name)
    start = _start(bag, inputs)
    session = Session(train, max_gap=max_gap)
    if start.state is not None:
        session.resume(start.state)
    rows = np.flatnonzero(inputs.stamp_ns > start.after_ns).tolist()
    compared = np.flatnonzero(outputs.stamp_ns > start.after_ns).tolist()
    fed = equal = 0
    first: str | None = None
    for row in compared:
        stamp = int(outputs.stamp_ns[row])
        while fed < len(rows) and inputs.stamp_ns[rows[fed]] <= stamp:
            _feed(session, inputs, rows[fed], start.origin_ns)
            fed += 1
        difference = _difference(session, outputs, row)
        if difference is None:
            equal += 1
        elif first is None:
            first = f"stamp {stamp} ns: {difference}"
    return Replay(fed, len(compared), equal, first, "first input" if start.state is None else "model state")


def _start(bag: Bag, inputs: JointSeries) -> _Start:
    if not len(inputs.stamp_ns):
        return _Start(None, -1, 0)
    begin = int(inputs.stamp_ns[0])
    for stamp, origin, state in _states(bag):
        if origin == begin:
            break
        if stamp >= begin:  # an older one was latched: inputs between it and the first may be missing
            return _Start(state, stamp, origin)
    return _Start(None, -1, begin)


def _states(bag: Bag) -> list[tuple[int, int, NDArray[np.float64]]]:
    """Return stamp, stamp of t = 0 and state of every message of the model's state; none in logs without them."""
    try:
        series = bag.joint(topics.MODEL_STATE.name)
    except LogError:
        return []
    missing = [name for name in (*SENSOR_STATE_NAMES, *ORIGIN_NAMES) if name not in series.position]
    if missing:
        return []  # of a version that keeps other things: nothing here can go on from it
    columns = np.column_stack([series.position[name] for name in SENSOR_STATE_NAMES])
    seconds, nanoseconds = (series.position[name] for name in ORIGIN_NAMES)
    sound = np.isfinite(columns).all(axis=1) & np.isfinite(seconds + nanoseconds)
    return [
        (int(series.stamp_ns[row]), int(seconds[row]) * 1_000_000_000 + int(nanoseconds[row]), columns[row])
        for row in np.flatnonzero(sound).tolist()
    ]


def _feed(session: Session, inputs: JointSeries, row: int, origin: int) -> None:
    t = (int(inputs.stamp_ns[row]) - origin) * 1e-9
    try:
        session.feed(t, float(inputs.velocity["s1"][row]), float(inputs.effort["s1"][row]))
    except RejectedSampleError:
        return  # counted by the sensor; the monitor publishes only what it accepted, so this log is not the monitor's


def _difference(session: Session, outputs: JointSeries, row: int) -> str | None:
    for mesh, window in zip(_MESHES, session.take_windows(), strict=True):
        for statistic in _STATISTICS:
            name = f"{mesh}/{statistic}"
            logged, found = float(outputs.effort[name][row]), float(getattr(window, statistic))
            if logged != found and not (np.isnan(logged) and np.isnan(found)):
                return f"{name} is {logged!r} N in the log and {found!r} N replayed"
    return None
