"""A bench of nothing but cyclonedds: ramps the speed into a band and prints what the monitor says, as JSON.

Knows no ROS and nothing of this project: only the names and types that a DDS program sees on the wire.
"""

import json
import sys
from dataclasses import dataclass
from math import pi
from time import monotonic, sleep
from typing import Any

from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import byte, float64, int32, sequence, uint32
from cyclonedds.internal import InvalidSample
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

CONFIGURATION = """<CycloneDDS><Domain><General><Interfaces>
<NetworkInterface autodetermine="true"/><NetworkInterface name="lo" multicast="false"/>
</Interfaces></General><Discovery>
<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers>
</Discovery></Domain></CycloneDDS>"""


@dataclass
class Float64(IdlStruct, typename="std_msgs.msg.dds_.Float64_"):
    data: float64


@dataclass
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    stamp: Time
    frame_id: str


@dataclass
class JointState(IdlStruct, typename="sensor_msgs.msg.dds_.JointState_"):
    header: Header
    name: sequence[str]  # type: ignore[type-arg]
    position: sequence[float64]  # type: ignore[type-arg]
    velocity: sequence[float64]  # type: ignore[type-arg]
    effort: sequence[float64]  # type: ignore[type-arg]


@dataclass
class KeyValue(IdlStruct, typename="diagnostic_msgs.msg.dds_.KeyValue_"):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs.msg.dds_.DiagnosticStatus_"):
    level: byte
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]  # type: ignore[type-arg]


def main(domain: int) -> None:
    kept = Domain(domain, CONFIGURATION)
    participant = DomainParticipant(domain)
    qos = Qos(
        Policy.DataRepresentation(use_cdrv0_representation=True),
        Policy.Reliability.Reliable(duration(milliseconds=100)),
        Policy.History.KeepLast(100),
    )
    written = qos + Qos(Policy.WriterDataLifecycle(autodispose=False))
    speed = DataWriter(participant, Topic(participant, "rt/motor/speed", Float64, qos), written)
    load = DataWriter(participant, Topic(participant, "rt/load/torque", Float64, qos), written)
    forces = DataReader(participant, Topic(participant, "rt/gear_monitor/mesh_force", JointState, qos), qos)
    warnings = DataReader(participant, Topic(participant, "rt/gear_monitor/chaos_warning", DiagnosticStatus, qos), qos)
    begin = monotonic()
    while not speed.get_matched_subscriptions() or not load.get_matched_subscriptions():
        if monotonic() - begin > 60:
            sys.exit("no monitor was found within 60 s")
        sleep(0.01)
    heard: list[tuple[float, int]] = []
    names: list[str] = []
    smallest, largest = float("inf"), float("-inf")
    begin = monotonic()
    tick = 0
    while (t := monotonic() - begin) < 6.0:
        rpm = min(1200.0 + 50.0 * t, 1354.0)  # 1349 r/min is reached after 3 s
        load.write(Float64(600.0))
        speed.write(Float64(rpm * 2 * pi / 60))
        statuses = [s for s in warnings.take(100) if not isinstance(s, InvalidSample)]
        heard += [(rpm, status.level) for status in statuses]
        taken: list[Any] = forces.take(100)
        for message in taken:
            if not isinstance(message, InvalidSample):
                names = list(message.name)
                smallest, largest = min(smallest, *message.effort), max(largest, *message.effort)
        tick += 1
        sleep(max(0.0, begin + 0.01 * tick - monotonic()))
    print(json.dumps({"warnings": heard, "names": names, "smallest": smallest, "largest": largest}))
    del kept


if __name__ == "__main__":
    main(int(sys.argv[1]))
