"""ROS 2's diagnostic_aggregator with the package's groups; where it is installed."""

import signal
from pathlib import Path
from typing import Any

import pytest
from harness import Peer, Processes
from monitored import paced
from ros import program

CONFIGURATION = Path(__file__).parents[2] / "config" / "diagnostics_aggregator.yaml"
PROGRAM = program("diagnostic_aggregator", "aggregator_node")
OK, WARN, ERROR, STALE = range(4)

pytestmark = [
    pytest.mark.ros,
    pytest.mark.skipif(PROGRAM is None, reason="diagnostic_aggregator is not installed"),
]


class Aggregated:
    """An aggregator, and its last report as level by name, without the bench's own name."""

    def __init__(self, processes: Processes, peer: Peer) -> None:
        from diagnostic_msgs.msg import DiagnosticArray

        self._peer = peer
        self.levels: dict[str, int] = {}
        peer.node.create_subscription(DiagnosticArray, "/diagnostics_agg", self._hear, 10)
        start = "import os, sys; os.execv(sys.argv[1], sys.argv[1:])"
        processes.start("-c", start, str(PROGRAM), "--ros-args", "--params-file", str(CONFIGURATION))

    def _hear(self, message: Any) -> None:
        self.levels = {each.name.removeprefix("/seat bench").lstrip("/"): each.level[0] for each in message.status}

    def driven_until(self, what: str, **levels: int) -> None:
        """Drive at 900 r/min until groups have these levels; `all` stands for the bench."""
        paced(self._peer, lambda: 0.02, lambda: self._peer.drive(900.0), lambda: self.shows(**levels), what)

    def shows(self, **levels: int) -> bool:
        """Return whether groups have these levels."""
        return all(self.levels.get("" if name == "all" else name) == level for name, level in levels.items())


@pytest.fixture
def bench(processes: Processes, peer: Peer) -> Aggregated:
    """An aggregator and one monitor, and both are OK."""
    made = Aggregated(processes, peer)
    processes.node("monitor")
    made.driven_until("a bench that is OK, also without a recorder", all=OK, recorder=OK, warning=OK)
    return made


def test_silent_inputs_are_stale_and_not_an_error_of_theirs(bench: Aggregated, peer: Peer) -> None:
    assert set(bench.levels) - {name for name in bench.levels if "gear_monitor" in name} == {
        *("", "inputs", "model", "qos", "recorder", "warning")
    }, "nothing is left over"
    peer.wait(lambda: bench.shows(inputs=STALE, warning=STALE, model=OK, qos=OK, all=ERROR), "the silence")


def test_monitors_of_several_namespaces_share_the_groups_and_one_that_dies_shows(
    bench: Aggregated, processes: Processes
) -> None:
    remapped = (part for topic in ("motor/speed", "load/torque") for part in ("-r", f"{topic}:=/{topic}"))
    left = processes.node("monitor", "-r", "__ns:=/left", *remapped)
    other = "inputs/left gear_monitor: input"
    bench.driven_until("both", **{other: OK, "inputs/gear_monitor: input": OK, "inputs": OK, "all": OK})
    processes.end(left, signal.SIGKILL)
    bench.driven_until("the dead one", **{other: STALE, "inputs/gear_monitor: input": OK, "inputs": ERROR})


def test_a_recorder_that_came_and_died_shows(bench: Aggregated, processes: Processes, tmp_path: Path) -> None:
    recorder = processes.node("recorder", output=tmp_path / "run")
    bench.driven_until("the recorder", **{"recorder/bench_recorder: recording": OK, "recorder": OK})
    processes.end(recorder, signal.SIGKILL)
    bench.driven_until("its death", recorder=STALE, all=ERROR)
