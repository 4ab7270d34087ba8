"""What DDS tells of the inputs, as /diagnostics tells it on: liveliness lost, deadlines missed, messages lost."""

import re
import signal
from collections.abc import Callable
from typing import Any

import pytest
from harness import Peer, Processes
from monitored import Health, paced
from ros import ON_CYCLONE, REAL_RCLPY

from seat_gear_dynamics.gears.units import RPM

OK, WARN, ERROR, STALE = range(4)

# A bench that promises to show life every 0.5 s, and does as long as its process runs.
BENCH = """
import seat_gear_dynamics.nodes
import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64
rclpy.init()
node = Node("bench")
lease = QoSProfile(depth=10, liveliness_lease_duration=Duration(nanoseconds=500_000_000))
speed = node.create_publisher(Float64, "motor/speed", lease)
node.create_timer(0.02, lambda: speed.publish(Float64(data=90.0)))
rclpy.spin(node)
"""

# A monitor whose topics are ordered by the time of writing. ROS 2 orders by arrival, where Cyclone DDS calls nothing
# lost (see docs/runtime.md); ordered so, it refuses and counts what is older than the last.
ORDERED_MONITOR = """
from seat_gear_dynamics.runtime import provide_rclpy
provide_rclpy()
from cyclonedds.core import Policy, Qos
from seat_gear_dynamics.runtime.wire import qos
made = qos.dds_qos
qos.dds_qos = lambda *given: made(*given) + Qos(Policy.DestinationOrder.BySourceTimestamp)
from seat_gear_dynamics.nodes.monitor import main
raise SystemExit(main())
"""

tells_liveliness = pytest.mark.skipif(
    not ON_CYCLONE, reason="Fast DDS tells liveliness to those alone who ask for a lease themselves"
)


@pytest.fixture
def health(peer: Peer) -> Health:
    return Health(peer)


def publisher(peer: Peer, **policies: Any) -> tuple[Any, Callable[[], None]]:
    """Return a publisher of the speed with these policies, and what sends 900 r/min with it."""
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Float64

    made = peer.node.create_publisher(Float64, "motor/speed", QoSProfile(depth=10, **policies))
    return made, lambda: made.publish(Float64(data=900 * RPM))


@tells_liveliness
def test_a_publisher_that_hangs_loses_its_liveliness_and_finds_it_again(
    processes: Processes, peer: Peer, health: Health
) -> None:
    from rclpy.duration import Duration
    from rclpy.qos import LivelinessPolicy

    monitor = processes.node("monitor")
    key, lease = "motor/speed, a publisher lost its liveliness", Duration(nanoseconds=300_000_000)
    _, send = publisher(peer, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC, liveliness_lease_duration=lease)
    paced(peer, lambda: 0.05, send, lambda: heard(health), "speeds")
    peer.wait(lambda: health.says("motor/speed: a publisher lost its liveliness", WARN, "qos"), "the event")
    assert health.value(key, "qos") >= 1
    health.forget()
    peer.wait(lambda: health.says("no event", OK, "qos"), "a report without another event")
    assert health.value(key, "qos") >= 1, "what was counted stays"

    # It comes back, and that is no loss. A test held up for longer than the lease has lost it once more, so the
    # second silence only has to count on.
    paced(peer, lambda: 0.05, send, lambda: health.value("speed age (s)") < 0.3, "speeds again")
    before = health.value(key, "qos")
    peer.wait(lambda: health.value(key, "qos") > before, "the second loss")
    assert monitor.poll() is None


def heard(health: Health) -> bool:
    """Return whether the monitor has heard a speed."""
    return health.value("speed messages") > 0


@tells_liveliness
def test_the_process_of_a_publisher_is_killed(processes: Processes, peer: Peer, health: Health) -> None:
    processes.node("monitor")
    bench = processes.start("-c", BENCH)
    peer.wait(lambda: heard(health), "speeds of the bench")
    assert health.value("motor/speed, a publisher lost its liveliness", "qos") != 1
    health.forget()
    processes.end(bench, signal.SIGKILL)
    peer.wait(lambda: health.says("motor/speed: a publisher lost its liveliness", WARN, "qos"), "the event")
    peer.wait(lambda: health.says("no speed for more than 0.5 s", STALE), "the input's STALE")


def test_each_report_says_how_many_deadlines_were_missed_since_the_last(
    processes: Processes, peer: Peer, health: Health
) -> None:
    from rclpy.duration import Duration

    processes.node("monitor", input_deadline=0.2, input_timeout=30.0)
    _, send = publisher(peer, deadline=Duration(nanoseconds=100_000_000))
    paced(peer, lambda: 0.05, send, lambda: heard(health), "speeds")

    def fresh() -> list[int]:  # of each report
        found = (re.search(r"motor/speed: missed its deadline \((\d+) new\)", each.message) for each in reports())
        return [int(match[1]) for match in found if match]

    def reports() -> list[Any]:
        return health.statuses("qos")

    peer.wait(lambda: len(fresh()) >= 3, "three reports of a publisher that stopped")
    assert health.value("motor/speed, missed its deadline", "qos") == sum(fresh())
    assert {each.level[0] for each in reports() if "missed" in each.message} == {WARN}


@pytest.mark.skipif(REAL_RCLPY, reason="rclpy's Cyclone DDS orders by arrival, and then calls no message lost")
def test_messages_that_dds_calls_lost_are_told_and_counted(
    processes: Processes, peer: Peer, health: Health, domain_id: int
) -> None:
    from cyclonedds.core import Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.topic import Topic

    from seat_gear_dynamics.runtime.wire.types import topic_struct

    monitor = processes.start("-c", ORDERED_MONITOR)
    ordered = Qos(Policy.DestinationOrder.BySourceTimestamp, Policy.Reliability.Reliable(10**9))
    participant = DomainParticipant(domain_id)
    topic = Topic(participant, "rt/motor/speed", topic_struct("std_msgs/msg/Float64"))
    writer = DataWriter(participant, topic, qos=ordered)
    peer.wait(lambda: bool(writer.get_matched_subscriptions()), "the match")
    for seconds in (20, 10, 15, 30):  # the second and the third are older than what came before them
        writer.write(topic.data_type(data=900 * RPM), seconds * 10**9)
    peer.wait(lambda: health.says(r"motor/speed: lost messages \([12] new\)", WARN, "qos"), "the event")
    peer.wait(lambda: health.value("motor/speed, lost messages", "qos") == 2, "the count")
    assert health.value("speed messages") == 2
    assert monitor.poll() is None
