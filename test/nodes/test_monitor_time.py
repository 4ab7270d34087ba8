"""The monitor on simulated time: it waits for it, stands while it stands, and starts over when it steps back."""

from collections.abc import Callable
from typing import Any

import pytest
from harness import Peer, Processes
from monitored import Health, paced

from seat_gear_dynamics.gears.units import RPM

OK, WARN, ERROR, STALE = range(4)


class Simulation:
    """Publishes /clock and drives the monitor, a hundredth of a simulated second at a time."""

    def __init__(self, peer: Peer) -> None:
        from rclpy.qos import QoSProfile
        from rosgraph_msgs.msg import Clock

        self._peer, self._kind = peer, Clock
        self._clock = peer.node.create_publisher(Clock, "/clock", QoSProfile(depth=10))
        self.now_ms = 50_000

    def tell(self) -> None:
        """Publish the time as it is."""
        message: Any = self._kind()
        message.clock.sec, rest = divmod(self.now_ms, 1000)
        message.clock.nanosec = rest * 10**6
        self._clock.publish(message)

    def until(self, rpm: float, reached: Callable[[], bool], what: str, *, standing: bool = False) -> None:
        """Drive at a speed until `reached`, time going on or standing."""

        def step() -> None:
            self.now_ms += 0 if standing else 10
            self.tell()
            self._peer.drive(rpm)

        paced(self._peer, lambda: 0.01, step, reached, what)


@pytest.fixture
def simulation(processes: Processes, peer: Peer) -> Simulation:
    processes.node("monitor", use_sim_time="true")
    peer.wait_for_subscriber("motor/speed")
    return Simulation(peer)


def stamps(peer: Peer) -> list[int]:
    fed = peer.messages["gear_monitor/input"]
    return [each.header.stamp.sec * 1000 + each.header.stamp.nanosec // 10**6 for each in fed]


@pytest.mark.parametrize("source", ["topics", "joint_states"])
def test_what_comes_before_any_clock_is_refused_counted_once_it_runs_and_no_gap(
    processes: Processes, peer: Peer, source: str
) -> None:
    from sensor_msgs.msg import JointState

    monitor = processes.node("monitor", use_sim_time="true", input=source)
    peer.wait_for_subscriber("motor/speed" if source == "topics" else "joint_states")
    simulation, health = Simulation(peer), Health(peer)
    state = JointState(name=["seat_height"], velocity=[900 * RPM], effort=[600.0])
    state.header.stamp.sec = 50

    def drive() -> None:
        if source == "topics":
            peer.drive(900.0)
        else:
            peer.publish("joint_states", state)

    wanted = "input refused: use_sim_time is set and nothing came on /clock yet"
    paced(peer, lambda: 0.01, drive, lambda: wanted in processes.words(monitor), "the line in the log")
    assert not peer.messages["gear_monitor/input"]
    assert not peer.messages["/diagnostics"], "its timers stand"

    def tell() -> None:
        simulation.now_ms += 10
        simulation.tell()

    paced(peer, lambda: 0.01, tell, lambda: health.value("refused, no clock") > 0, "the count")
    # Had it been heard at the time 0, there would be a gap of the 50 s at which the clock begins.
    assert max(health.value("speed longest gap (s)"), health.value("load longest gap (s)")) < 50


def test_a_pause_stands_and_goes_on_and_a_step_back_starts_over(peer: Peer, simulation: Simulation) -> None:
    health = Health(peer)
    fed = peer.messages["gear_monitor/input"]
    # Without /clock there is no time that a sample could have.
    sent = 0

    def drive() -> None:
        nonlocal sent
        sent += 1
        peer.drive(900.0)

    paced(peer, lambda: 0.01, drive, lambda: sent > 20, "samples before any clock")
    assert not fed
    simulation.until(900.0, lambda: peer.level() == OK and len(fed) > 100, "OK in simulated time")
    assert all(50_000 <= stamp <= simulation.now_ms for stamp in stamps(peer))

    # A pause: the clock stands. What comes at the same time is refused, and nothing grows stale.
    simulation.until(900.0, lambda: fed[-1].header.stamp.sec * 1000 + 999 >= simulation.now_ms - 20, "the last one")
    count = len(fed)
    repeated = 0

    def again() -> None:
        nonlocal repeated
        repeated += 1
        simulation.tell()
        peer.drive(900.0)

    paced(peer, lambda: 0.01, again, lambda: repeated > 100, "a second's standing")
    assert len(fed) <= count + 2, "at most what was under way"
    assert peer.level() == OK
    simulation.until(900.0, lambda: len(fed) > count + 50, "samples after the pause")
    assert peer.level() == OK
    assert health.value("restarts, gap", "solver") == 0

    # Twenty seconds back: all that was timed is forgotten, and the model starts anew from the first sample.
    health.forget()
    before = len(fed)
    simulation.now_ms -= 20_000
    simulation.until(1800.0, lambda: peer.level() == ERROR, "the alarm after the step back")
    simulation.until(1800.0, lambda: health.value("clock stepped back") == 1, "its count")
    later = stamps(peer)[before:]
    assert later[0] < stamps(peer)[before - 1]
    assert later == sorted(set(later))
