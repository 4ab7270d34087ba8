"""Inputs as they come, over the wire: each case has its level, its text and its count, and none ends the monitor."""

import math
import random
import re
import signal
from collections.abc import Callable
from typing import Any

import pytest
from harness import Peer, Processes
from monitored import Health, Managed, paced

from seat_gear_dynamics.gears.units import RPM

OK, WARN, ERROR, STALE = range(4)


@pytest.fixture
def health(peer: Peer) -> Health:
    return Health(peer)


@pytest.mark.parametrize(
    ("speed", "load", "reason", "words"),
    [
        (math.nan, 600.0, "not finite", "the speed is nan"),
        (-math.inf, 600.0, "not finite", "the speed is -inf"),
        (900 * RPM, math.nan, "not finite", "the load is nan"),
        (1e300, 600.0, "absurd", r"speed is 1e\+300 rad/s, expected at most"),
        (900 * RPM, -1e9, "absurd", r"the load is -1e\+09 N·m, expected at most"),
        (900.0, 600.0, "implausible", r"900 rad/s, 4\.1 times the highest covered"),
    ],
    ids=["NaN speed", "infinite speed", "NaN load", "absurd speed", "absurd load", "r/min sent as rad/s"],
)
def test_a_publisher_of_nothing_but_nonsense_is_stale_not_ok(
    processes: Processes, peer: Peer, health: Health, speed: float, load: float, reason: str, words: str
) -> None:
    from std_msgs.msg import Float64

    monitor = processes.node("monitor", load_timeout=0.5)
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(900.0, lambda: peer.level() == OK, "OK at 900 r/min")

    def send() -> None:
        peer.publish("load/torque", Float64(data=load))
        peer.publish("motor/speed", Float64(data=speed))

    paced(peer, lambda: 0.01, send, lambda: peer.level() == STALE and health.says(words, ERROR), "the error")
    assert re.search("that can be used", peer.text())
    assert health.value(f"refused, {reason}") > 10
    refused = len([line for line in processes.words(monitor).splitlines() if "refused" in line])
    assert refused <= 2 + len(peer.messages["/diagnostics"]) / 5, "the log is not flooded: a line in five seconds"
    peer.drive_until(1800.0, lambda: peer.level() == ERROR, "the alarm after the nonsense")
    assert monitor.poll() is None


def joint(stamp_ns: int, rpm: float, load: float = 600.0) -> Any:
    from sensor_msgs.msg import JointState

    message = JointState(name=["seat_height"], velocity=[rpm * RPM], effort=[load])
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
    return message


@pytest.fixture
def stamped(processes: Processes, peer: Peer) -> Callable[[int], None]:
    """A monitor on joint states, and a way to send one with a stamp in ms."""
    processes.node("monitor", input="joint_states")
    peer.wait_for_subscriber("joint_states")
    return lambda ms: peer.publish("joint_states", joint(ms * 10**6, 900.0))


def test_stamps_twice_late_and_not_filled_in_are_refused_and_a_step_back_starts_anew(
    peer: Peer, health: Health, stamped: Callable[[int], None]
) -> None:
    fed = peer.messages["gear_monitor/input"]
    now = 1_000_000

    def send() -> None:  # each stamp twice, and between them one that is late
        nonlocal now
        now += 10
        for ms in (now, now, now - 5):
            stamped(ms)

    paced(peer, lambda: 0.01, send, lambda: health.value("refused, late") > 50, "the late ones")
    assert health.value("refused, duplicate") > 50
    assert health.says("it came twice or too late", WARN)
    assert peer.level() == OK, "good samples among them are enough"
    stamps = [each.header.stamp.sec * 10**9 + each.header.stamp.nanosec for each in fed]
    assert stamps == sorted(set(stamps))

    health.forget()
    paced(peer, lambda: 0.01, lambda: stamped(0), lambda: health.value("refused, no stamp") > 10, "stamps of zero")
    assert health.says("no speed that can be used .* fill in header.stamp", ERROR)
    paced(
        peer, lambda: 0.01, lambda: stamped(0), lambda: health.says("no load that can be used .*stamp", ERROR), "both"
    )

    health.forget()
    now -= 900_000  # a quarter of an hour
    paced(peer, lambda: 0.01, send, lambda: health.value("restarts, clock stepped back", "solver") == 1, "the restart")
    paced(peer, lambda: 0.01, send, lambda: peer.level() == OK, "OK again")


def test_joint_states_that_lack_the_joint_are_an_error_that_names_what_came(
    processes: Processes, peer: Peer, health: Health
) -> None:
    from sensor_msgs.msg import JointState

    monitor = processes.node("monitor", input="joint_states")
    peer.wait_for_subscriber("joint_states")
    now = 1_000_000

    def states(names: list[str], speeds: list[float], loads: list[float]) -> Callable[[], None]:
        def send() -> None:
            nonlocal now
            now += 10
            message = JointState(name=names, velocity=speeds, effort=loads)
            message.header.stamp.sec, rest = divmod(now, 1000)
            message.header.stamp.nanosec = rest * 10**6
            peer.publish("joint_states", message)

        return send

    foreign = states(["lumbar", "recliner"], [1.0, 2.0], [3.0, 4.0])
    wanted = r"no velocity and effort of joint 'seat_height' among \['lumbar', 'recliner'\]"
    paced(peer, lambda: 0.01, foreign, lambda: health.says(f"no speed that can be used.*{wanted}", ERROR), "the names")
    paced(peer, lambda: 0.01, foreign, lambda: bool(re.search(wanted, peer.text())), "the names in the warning")
    assert peer.level() == STALE
    assert health.value("refused, joint not named") > 10
    assert not peer.messages["gear_monitor/input"]

    health.forget()
    names, speeds = ["lumbar", "seat_height"], [1.0, 900 * RPM]
    bare = states(names, speeds, [])
    wanted = wanted.replace("recliner", "seat_height")
    paced(peer, lambda: 0.01, bare, lambda: health.says(f"no load that can be used.*{wanted}", ERROR), "no effort")
    assert not peer.messages["gear_monitor/input"]

    whole, fed = states(names, speeds, [3.0, 600.0]), peer.messages["gear_monitor/input"]
    paced(peer, lambda: 0.01, whole, lambda: bool(fed) and peer.level() == OK, "OK")
    assert (fed[-1].velocity[0], fed[-1].effort[0]) == (900 * RPM, 600.0), "those of the joint, not of the first"
    assert monitor.poll() is None


def test_a_publisher_that_goes_and_comes_back(processes: Processes, peer: Peer, health: Health) -> None:
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Float64

    processes.node("monitor")
    peer.wait_for_subscriber("motor/speed")
    own = peer._publishers.pop("motor/speed")

    def speed(publisher: Any) -> Callable[[], None]:
        def send() -> None:
            peer.publish("load/torque", Float64(data=600.0))
            publisher.publish(Float64(data=900 * RPM))

        return send

    paced(peer, lambda: 0.01, speed(own), lambda: peer.level() == OK, "OK")
    peer.node.destroy_publisher(own)
    peer.wait(lambda: peer.level() == STALE and "no speed for more than 0.5 s" in peer.text(), "STALE")
    peer.wait(lambda: health.says("no speed for more", STALE), "the input's STALE")
    peer.wait(lambda: health.value("speed publishers") == 0, "the count of publishers")

    again = peer.node.create_publisher(Float64, "motor/speed", QoSProfile(depth=10))
    paced(peer, lambda: 0.01, speed(again), lambda: peer.level() == OK, "OK again")
    paced(peer, lambda: 0.01, speed(again), lambda: health.value("restarts, gap", "solver") >= 1, "the gap")
    assert health.value("speed publishers") == 1


def test_two_publishers_on_one_topic_are_named(processes: Processes, peer: Peer, health: Health) -> None:
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Float64

    processes.node("monitor")
    peer.wait_for_subscriber("motor/speed")
    second = peer.node.create_publisher(Float64, "motor/speed", QoSProfile(depth=10))

    def send() -> None:
        peer.drive(900.0)
        second.publish(Float64(data=900 * RPM))

    paced(
        peer,
        lambda: 0.01,
        send,
        lambda: health.says("2 publishers on motor/speed: their values are mixed", WARN),
        "both publishers",
    )
    assert health.value("speed publishers") == 2
    peer.node.destroy_publisher(second)
    health.forget()
    peer.drive_until(900.0, lambda: health.says("speed: ", OK), "one publisher again")


def test_one_sample_a_second_says_what_to_change_and_works_once_that_is_done(
    processes: Processes, peer: Peer, health: Health
) -> None:
    processes.node("monitor")
    peer.wait_for_subscriber("motor/speed")
    second = lambda: 1.0  # noqa: E731
    drive = lambda: peer.drive(900.0)  # noqa: E731
    paced(
        peer,
        second,
        drive,
        lambda: health.says(r"speed.* comes with gaps of up to .* s, 0\.5 s is allowed"),
        "the advice",
    )
    assert peer.level() is not None
    assert Managed(peer).set(input_timeout=60.0, load_timeout=60.0).successful
    restarts = health.value("restarts, gap", "solver")
    health.forget()
    # Six samples: what was sent while the parameters changed is behind.
    fed = len(peer.messages["gear_monitor/input"])
    paced(peer, second, drive, lambda: len(peer.messages["gear_monitor/input"]) > fed + 5, "six samples")
    assert peer.level() == OK
    assert health.value("restarts, gap", "solver") <= restarts + 1
    assert "gaps" not in health.statuses("input")[-1].message


def test_two_thousand_samples_a_second(processes: Processes, peer: Peer, health: Health) -> None:
    monitor = processes.node("monitor")
    peer.wait_for_subscriber("motor/speed")
    paced(peer, lambda: 0.0005, lambda: peer.drive(900.0), lambda: health.value("samples accepted") > 1500, "samples")
    assert peer.level() == OK, peer.text()
    trips = peer.messages["gear_monitor/in_forbidden_band"]
    paced(peer, lambda: 0.0005, lambda: peer.drive(1800.0), lambda: trips[-1].data, "the trip")
    assert monitor.poll() is None


def test_jitter_and_bursts_restart_nothing(processes: Processes, peer: Peer, health: Health) -> None:
    processes.node("monitor", input_timeout=5.0)
    peer.wait_for_subscriber("motor/speed")
    chance = random.Random(4)

    def send() -> None:
        for _ in range(chance.choice((1, 1, 1, 5))):
            peer.drive(900.0)

    paced(peer, lambda: chance.expovariate(100.0), send, lambda: health.value("samples accepted") > 600, "samples")
    assert peer.level() == OK
    assert health.value("restarts, gap", "solver") == 0
    assert health.value("refused, late") == 0


def test_a_monitor_that_was_held_up_calls_no_input_silent_that_waits_in_its_queue(
    processes: Processes, peer: Peer
) -> None:
    monitor = processes.node("monitor")
    peer.wait_for_subscriber("motor/speed")
    peer.drive_until(900.0, lambda: peer.level() == OK, "OK at 900 r/min")
    heard, sent = len(peer.warnings()), 0

    def send() -> None:
        nonlocal sent
        sent += 1
        peer.drive(900.0)

    monitor.send_signal(signal.SIGSTOP)
    paced(peer, lambda: 0.01, send, lambda: sent > 100, "a second of samples, twice the timeout")
    monitor.send_signal(signal.SIGCONT)
    paced(peer, lambda: 0.01, send, lambda: len(peer.warnings()) > heard + 10, "a second of warnings")
    said = [(each.level[0], each.message) for each in peer.warnings()[heard:]]
    assert {level for level, _ in said} == {OK}, said


def test_the_steps_of_a_hall_sensor_are_no_alarm_and_no_chatter(
    processes: Processes, peer: Peer, health: Health
) -> None:
    processes.node("monitor", horizon=0.0)
    peer.wait_for_subscriber("motor/speed")
    chance = random.Random(5)

    def send() -> None:  # steps of 20 r/min around 900: 449 below the band, far beyond the margin of 40
        peer.drive(20.0 * round((900.0 + chance.uniform(-10, 10)) / 20.0))

    paced(peer, lambda: 0.02, send, lambda: peer.level() == OK, "OK")
    heard = len(peer.warnings())
    paced(peer, lambda: 0.02, send, lambda: len(peer.warnings()) > heard + 40, "two seconds")
    levels = [each.level[0] for each in peer.warnings()[heard:]]
    assert ERROR not in levels
    assert not any(each.data for each in peer.messages["gear_monitor/in_forbidden_band"])
    assert health.value("refused, implausible") == 0


def test_a_subscriber_that_asks_for_what_is_not_offered_is_named(
    processes: Processes, peer: Peer, health: Health
) -> None:
    from diagnostic_msgs.msg import DiagnosticStatus
    from rclpy.qos import DurabilityPolicy, QoSProfile

    processes.node("monitor")
    peer.wait(lambda: bool(peer.warnings()), "the monitor")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    peer.node.create_subscription(DiagnosticStatus, "gear_monitor/chaos_warning", lambda message: None, latched)
    wanted = "gear_monitor/chaos_warning: an endpoint's QoS does not fit: durability"
    peer.wait(lambda: health.says(wanted, WARN, "qos"), "the event")


def test_a_deadline_asked_of_the_inputs_is_watched(processes: Processes, peer: Peer, health: Health) -> None:
    from rclpy.duration import Duration
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Float64

    processes.node("monitor", input_deadline=0.2, input_timeout=30.0)
    wanted = "motor/speed: an endpoint's QoS does not fit: deadline"
    peer.wait(lambda: health.says(wanted, WARN, "qos"), "the publisher without a deadline")
    offered = QoSProfile(depth=10, deadline=Duration(nanoseconds=100_000_000))
    speed = peer.node.create_publisher(Float64, "motor/speed", offered)
    peer.wait(lambda: speed.get_subscription_count() > 0, "the match")
    send = lambda: speed.publish(Float64(data=900 * RPM))  # noqa: E731
    paced(peer, lambda: 0.1, send, lambda: health.value("speed messages") > 0, "the first speeds")
    peer.wait(lambda: health.says("motor/speed: missed its deadline", WARN, "qos"), "the deadline missed")
