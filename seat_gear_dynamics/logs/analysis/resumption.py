"""Where the replay of a log begins: at the monitor's first sample, or amid a run from a state that it published."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.message_bytes import JointDecoder
from seat_gear_dynamics.logs.analysis.sources import holds
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.sensing.virtual_sensor import SENSOR_STATE_NAMES

Array = NDArray[np.float64]


class Resumption(NamedTuple):
    """A state to set (None: start at rest with the first input), the stamp behind which it holds, that of t = 0."""

    state: Array | None
    after_ns: int
    origin_ns: int


def resumption(bag: Bag) -> Resumption:
    """Return where to begin, the first state whose later inputs are all in the log."""
    decoder, inputs = JointDecoder(), bag.messages(topics.MODEL_INPUT.name)
    first = next((decoder.decode(message.data).stamp_ns for message in inputs), 0)
    for stamp, origin, state in _states(bag):
        if origin == first:
            break
        if stamp >= first:  # an older one was latched: inputs between it and the first may be missing
            return Resumption(state, stamp, origin)
    return Resumption(None, -1, first)


def _states(bag: Bag) -> Iterator[tuple[int, int, Array]]:
    if not holds(bag, topics.MODEL_STATE.name):
        return
    decoder = JointDecoder()
    for message in bag.messages(topics.MODEL_STATE.name):
        joint = decoder.decode(message.data)
        values = dict(zip(joint.names, joint.position, strict=False))
        if not all(np.isfinite(values.get(name, np.nan)) for name in (*SENSOR_STATE_NAMES, *topics.ORIGIN_NAMES)):
            continue  # of a version that keeps other things, or damaged: nothing here can go on from it
        seconds, nanoseconds = (int(values[name]) for name in topics.ORIGIN_NAMES)
        yield joint.stamp_ns, seconds * 1_000_000_000 + nanoseconds, np.array([values[n] for n in SENSOR_STATE_NAMES])
