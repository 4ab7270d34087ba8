"""Replaying a log: its inputs through the same core again, compared with the outputs it holds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.series import JointSeries
from seat_gear_dynamics.sensing import RejectedSampleError, Session

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


def replay(path: Path | str, train: GearTrain, *, max_gap: float = 0.5) -> Replay:
    """Feed what the monitor was fed (`gear_monitor/input`) to a new session and compare the force statistics.

    Equal bit for bit on the same build, when the log begins before the monitor's first sample and `train` and `max_gap`
    are what the monitor ran with. Raises LogError where the log has no such inputs or outputs.
    """
    bag = Bag(path)
    inputs, outputs = bag.joint(topics.MODEL_INPUT.name), bag.joint(topics.MESH_FORCE.name)
    session = Session(train, max_gap=max_gap)
    origin = int(inputs.stamp_ns[0]) if len(inputs.stamp_ns) else 0
    fed = equal = 0
    first: str | None = None
    for row, stamp in enumerate(outputs.stamp_ns.tolist()):
        while fed < len(inputs.stamp_ns) and inputs.stamp_ns[fed] <= stamp:
            _feed(session, inputs, fed, origin)
            fed += 1
        difference = _difference(session, outputs, row)
        if difference is None:
            equal += 1
        elif first is None:
            first = f"stamp {stamp} ns: {difference}"
    return Replay(fed, len(outputs.stamp_ns), equal, first)


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
