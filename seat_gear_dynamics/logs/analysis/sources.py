"""Which topics of a bag carry speed and load, and in what units: ours by default, any that a user names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.analysis.message_bytes import JointDecoder, float64
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.schemas import Decoder

SPEED_UNITS = {"rad/s": 1.0, "r/min": RPM, "rpm": RPM, "Hz": 60 * RPM, "deg/s": RPM / 6}
"""Unit of a speed topic → rad/s; Hz are revolutions a second."""
LOAD_UNITS = {"N·m": 1.0, "Nm": 1.0, "N*m": 1.0, "mN·m": 1e-3, "mNm": 1e-3, "kN·m": 1e3, "kNm": 1e3}
"""Unit of a load topic → N·m."""


@dataclass(frozen=True)
class Source:
    """Where speed of s1 and load T4 stand in a bag.

    Without topics: what the monitor was fed, else `motor/speed` and `load/torque`, else `joint_states`. A topic of
    JointState gives the velocity (speed) or the effort (load) of `joint`, of its first joint where that is None.
    Any other type has to hold one number called `data`, as Float64 and Float32 do.
    """

    speed_topic: str | None = None
    load_topic: str | None = None
    joint: str | None = None
    speed_unit: str = "rad/s"
    load_unit: str = "N·m"

    def __post_init__(self) -> None:
        for what, unit, known in (("speed", self.speed_unit, SPEED_UNITS), ("load", self.load_unit, LOAD_UNITS)):
            if unit not in known:
                raise LogError(f"The unit of the {what} is {unit!r}, expected one of {', '.join(known)}.")

    @property
    def chosen(self) -> bool:
        """Whether a user named a topic."""
        return self.speed_topic is not None or self.load_topic is not None


class Measured(NamedTuple):
    """What one message says: stamp (ns; None without one), speed (rad/s) and load (N·m), None what it does not say."""

    stamp_ns: int | None
    speed: float | None
    load: float | None


Read = Callable[[bytes], Measured]
_NOTHING = Measured(None, None, None)


def readers(bag: Bag, source: Source) -> dict[str, Read]:
    """Return absolute topic → function that reads its messages; raises `LogError` where the bag has no speed or load.

    Limits: a message that carries no number of the joint gives nothing, it is not an error.
    """
    speed, load = _topics(bag, source)
    return {name: _reader(bag, name, source, name == speed, name == load) for name in dict.fromkeys((speed, load))}


def _topics(bag: Bag, source: Source) -> tuple[str, str]:
    joint = bag.resolve(topics.JOINT_STATES.name) if holds(bag, topics.JOINT_STATES.name) else None
    if not source.chosen and holds(bag, topics.MODEL_INPUT.name):
        return (bag.resolve(topics.MODEL_INPUT.name),) * 2
    if not source.chosen and joint and not holds(bag, topics.MOTOR_SPEED.name):
        return joint, joint
    speed = bag.resolve(source.speed_topic or topics.MOTOR_SPEED.name)
    if source.load_topic is None and bag.topics[speed].type == topics.JOINT_STATE:
        return speed, speed
    return speed, bag.resolve(source.load_topic or topics.LOAD_TORQUE.name)


def holds(bag: Bag, topic: str) -> bool:
    """Return whether the bag has messages of exactly one topic that `topic` stands for."""
    try:
        return bag.topics[bag.resolve(topic)].count > 0
    except LogError:
        return False


def _reader(bag: Bag, name: str, source: Source, is_speed: bool, is_load: bool) -> Read:
    factors = SPEED_UNITS[source.speed_unit], LOAD_UNITS[source.load_unit]
    kind = bag.topics[name].type
    if kind == topics.JOINT_STATE:
        return _joint_reader(source.joint, is_speed, is_load, factors)
    if is_speed and is_load:
        raise LogError(f"The topic {name} is {kind}, one number; expected different topics for speed and load.")
    number = float64 if kind == topics.FLOAT64 else _number(name, kind)
    if is_speed:
        return lambda data: Measured(None, number(data) * factors[0], None)
    return lambda data: Measured(None, None, number(data) * factors[1])


def _joint_reader(joint: str | None, is_speed: bool, is_load: bool, factors: tuple[float, float]) -> Read:
    decoder = JointDecoder()

    def read(data: bytes) -> Measured:
        found = decoder.decode(data)
        if joint is not None and joint not in found.names:
            return _NOTHING
        index = 0 if joint is None else found.names.index(joint)
        speed = found.velocity[index] * factors[0] if is_speed and index < len(found.velocity) else None
        load = found.effort[index] * factors[1] if is_load and index < len(found.effort) else None
        return Measured(found.stamp_ns or None, speed, load)

    return read


def _number(name: str, kind: str) -> Callable[[bytes], float]:
    decoder = Decoder({})

    def number(data: bytes) -> float:
        message = decoder.decode(data, kind)
        if not hasattr(message, "data"):
            raise LogError(f"The topic {name} is {kind}, expected JointState or a type with one number called data.")
        return float(message.data)

    return number
