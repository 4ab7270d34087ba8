"""Bench and monitor as different hosts: two networks, and between them a cable that loses, delays and is pulled out."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from subprocess import Popen
from time import monotonic, sleep, time_ns
from typing import Any

import pytest
from harness import PATIENCE, Processes
from network import ADDRESSES, Network, Quality

from seat_gear_dynamics.logs.reader import Bag

OK, WARN, ERROR, STALE = range(4)
BENCH, MONITOR = range(2)  # the hosts

PEERS_ONLY = f"""<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast></General><Discovery>
<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>8</MaxAutoParticipantIndex>
<Peers>{"".join(f'<Peer address="{address}"/>' for address in ADDRESSES)}</Peers></Discovery></Domain></CycloneDDS>"""

FAR_BENCH = """
import json, os, sys
from math import pi
from time import sleep, time_ns
sys.path.insert(0, sys.argv[1])
import plain_dds_bench as plain

orders, domain = sys.argv[2], int(sys.argv[3])
own = None if "CYCLONEDDS_URI" in os.environ else plain.Domain(domain, plain.CONFIGURATION)
participant = plain.DomainParticipant(domain)
qos = plain.Qos(
    plain.Policy.DataRepresentation(use_cdrv0_representation=True),
    plain.Policy.Reliability.Reliable(plain.duration(seconds=5)),
    plain.Policy.History.KeepLast(10000),
)
written = qos + plain.Qos(plain.Policy.WriterDataLifecycle(autodispose=False))

def topic(name, kind):
    return plain.Topic(participant, "rt/" + name, kind, qos)

speed = plain.DataWriter(participant, topic("motor/speed", plain.Float64), written)
load = plain.DataWriter(participant, topic("load/torque", plain.Float64), written)
heard = {
    name: plain.DataReader(participant, topic("gear_monitor/" + name, kind), qos)
    for name, kind in (("chaos_warning", plain.DiagnosticStatus), ("mesh_force", plain.JointState))
}
got = {name: [] for name in heard}
sent = []
matched = False
while True:
    with open(orders) as file:
        order = json.load(file)
    if order["do"] == "end":
        break
    # Two readers of each input: the monitor and the recorder.
    if not matched and len(speed.get_matched_subscriptions()) == len(load.get_matched_subscriptions()) == 2:
        matched = True
        print(json.dumps({"matched": True}), flush=True)
    if order["do"] == "drive" and matched:
        stamp = time_ns() + round(order["skew"] * 1e9)
        load.write(plain.Float64(600.0), stamp)
        speed.write(plain.Float64(order["rpm"] * 2 * pi / 60), stamp)
        sent.append(stamp)
    for name, reader in heard.items():
        for sample in reader.take(1000):
            if isinstance(sample, plain.InvalidSample):
                continue
            got[name].append(sample.sample_info.source_timestamp)
            if name == "chaos_warning":
                print(json.dumps({"level": sample.level, "text": sample.message}), flush=True)
            elif len(got[name]) == 1:
                print(json.dumps({"forces": True}), flush=True)
    sleep(0.02)
for writer in (speed, load):
    writer.wait_for_acks(20 * 10**9)  # a writer that leaves repeats nothing that the line has just lost
print(json.dumps({"sent": sent, **got}), flush=True)
"""


class FarBench:
    """The bench on its own host: told what to play through a file, heard through what it prints."""

    def __init__(
        self, processes: Processes, network: Network, folder: Path, domain_id: int, *others: Popen[bytes]
    ) -> None:
        self._processes, self._orders = processes, folder / "orders.json"
        self.order("listen")
        here = str(Path(__file__).parent)
        self._process = processes.start(
            *network.on(BENCH, "-c", FAR_BENCH, here, str(self._orders), str(domain_id)),
        )
        self._needed = (self._process, *others)

    def order(self, do: str, rpm: float = 0.0, skew: float = 0.0) -> None:
        """Have it "listen", "drive" with clocks `skew` s apart, or "end"."""
        draft = self._orders.with_suffix(".draft")
        draft.write_text(json.dumps({"do": do, "rpm": rpm, "skew": skew}))
        draft.rename(self._orders)

    def said(self) -> list[dict[str, Any]]:
        """Return what it has printed, whole lines only."""
        words = self._processes.words(self._process)
        return [json.loads(line) for line in words[: words.rfind("\n") + 1].splitlines() if line.startswith("{")]

    def wait(self, reached: Callable[[list[dict[str, Any]]], bool], what: str) -> None:
        """Wait until what it printed from now on shows something."""
        begin, known = monotonic(), len(self.said())
        while not reached(self.said()[known:]):
            for process in self._needed:
                assert process.poll() is None, self._processes.words(process)
            assert monotonic() - begin < PATIENCE, f"waited {PATIENCE} s for {what}; last was {self.said()[-1:]}"
            sleep(0.05)

    def wait_for_level(self, level: int, in_text: str = "") -> None:
        """Wait for a warning of a level that comes from now on."""
        self.wait(lambda said: any(s.get("level") == level and in_text in s["text"] for s in said), f"level {level}")

    def end(self) -> dict[str, list[int]]:
        """End it; returns the source timestamps, ns, of all it sent and got."""
        self.order("end")
        assert self._process.wait(PATIENCE) == 0, self._processes.words(self._process)
        summary: dict[str, list[int]] = self.said()[-1]
        return summary


class Site:
    """The bench on one host, monitor and recorder on the other."""

    def __init__(self, processes: Processes, network: Network, folder: Path, domain_id: int) -> None:
        self.network, self._processes, self._log = network, processes, folder / "log"
        self.recorder = self._node("recorder", f"output:={self._log}")
        self.monitor = self._node("monitor")
        self.bench = FarBench(processes, network, folder, domain_id, self.monitor, self.recorder)

    def _node(self, name: str, *parameters: str) -> Popen[bytes]:
        flags = [word for parameter in parameters for word in ("-p", parameter)]
        module = f"seat_gear_dynamics.nodes.{name}"
        return self._processes.start(*self.network.on(MONITOR, "-m", module, "--ros-args", *flags))

    def start(self) -> None:
        """Wait until bench, monitor and recorder have found each other."""
        self.bench.wait(lambda said: {"matched": True} in self.bench.said(), "the hosts to find each other")

    def end(self) -> tuple[Bag, dict[str, list[int]]]:
        """End all, the monitor first; returns the recorder's log and the bench's summary."""
        assert self._processes.end(self.monitor) == 0
        summary = self.bench.end()
        assert self._processes.end(self.recorder) == 0
        return Bag(self._log), summary


CUT = 3.0  # s; a second until all is stale, then two reports, one each second
BAD_LINE = Quality(loss=0.05, delay=0.02, jitter=0.005)


@pytest.fixture(autouse=True)
def _beyond_this_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let nodes on rclpy look for others on the network, whatever the shell says."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    monkeypatch.delenv("ROS_LOCALHOST_ONLY", raising=False)


def stamps(bag: Bag, topic: str, since: int = 0) -> list[int]:
    """Return when the messages of a topic were written, by their writer's clock, ns."""
    return [m.publish_time_ns for m in bag.messages(topic) if m.publish_time_ns >= since]


def reports(bag: Bag, part: str) -> list[tuple[int, int, str, dict[str, str]]]:
    """Return when, with which level, text and values a part of the monitor reported."""
    found = []
    for message in bag.decoded("/diagnostics"):
        for status in message.message.status:
            if status.name == f"gear_monitor: {part}":
                values = {value.key: value.value for value in status.values}
                found.append((message.publish_time_ns, int(status.level), status.message, values))
    return found


@pytest.mark.parametrize("uri", ["", PEERS_ONLY], ids=["multicast", "peers"])
def test_over_a_line_that_loses_and_delays_reliable_topics_are_complete_and_levels_right(
    processes: Processes, tmp_path: Path, domain_id: int, uri: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if uri:
        monkeypatch.setenv("CYCLONEDDS_URI", uri)
    with Network(seed=1) as network:
        site = Site(processes, network, tmp_path, domain_id)
        site.start()
        network.set(BAD_LINE)
        site.bench.order("drive", 900.0)
        site.bench.wait_for_level(OK)
        site.bench.wait(lambda said: sum("level" in s for s in said) > 30, "three seconds of warnings")
        site.bench.order("drive", 1800.0)
        site.bench.wait_for_level(ERROR)
        site.bench.order("listen")
        site.bench.wait_for_level(STALE)
        lost = network.set(BAD_LINE)["lost"]
        bag, summary = site.end()
    assert lost > 20, "the line has to lose frames for this test to say something"
    # The bench keeps all it wrote: what the line loses is repeated until the recorder has it.
    assert sorted(stamps(bag, "motor/speed")) == summary["sent"]
    assert sorted(stamps(bag, "load/torque")) == summary["sent"]
    # Ten warnings are kept by their writer, one second of them.
    warned = summary["chaos_warning"]
    assert set(stamps(bag, "gear_monitor/chaos_warning", since=warned[0])) == set(warned)
    # Ten forces are a fifth of a second: one may be overwritten before its repetition, but repeated they are.
    forced = summary["mesh_force"]
    written = stamps(bag, "gear_monitor/mesh_force", since=forced[0])
    assert len(set(written) - set(forced)) < BAD_LINE.loss * len(written)
    assert forced == sorted(set(forced)), "in order, and none twice"


def test_a_pulled_cable_is_stale_with_an_honest_age_and_is_recovered_from(
    processes: Processes, tmp_path: Path, domain_id: int
) -> None:
    with Network(seed=2) as network:
        site = Site(processes, network, tmp_path, domain_id)
        site.start()
        network.set(BAD_LINE)
        site.bench.order("drive", 900.0)
        site.bench.wait_for_level(OK)
        network.set(replace(BAD_LINE, cut=True))
        pulled = time_ns()
        sleep(CUT)  # its length is what is tested: nothing crosses it that could be waited for
        cut = network.set(BAD_LINE)["cut"]
        mended = time_ns()
        # The ten warnings that their writer kept arrive late, STALE among them; then live ones.
        site.bench.wait_for_level(STALE, "no speed for more than 0.5 s")
        site.bench.wait_for_level(OK)
        bag, summary = site.end()
    assert cut > 100
    assert sorted(stamps(bag, "motor/speed")) == summary["sent"], "what was sent into the cut arrives after it"
    arrivals = [m.log_time_ns for m in bag.messages("motor/speed")]
    assert not [at for at in arrivals if pulled + 5 * 10**8 < at < mended]
    silent = [(at, level, values) for at, level, _, values in reports(bag, "input") if pulled + 10**9 < at < mended]
    assert silent
    for at, level, values in silent:
        since = (at - max(arrival for arrival in arrivals if arrival < at)) * 1e-9
        assert level == STALE
        # Half of input_timeout: an age that is further off could change the verdict.
        assert float(values["speed age (s)"]) == pytest.approx(since, abs=0.25)
    levels = [(m.publish_time_ns, int(m.message.level)) for m in bag.decoded("gear_monitor/chaos_warning")]
    assert {level for at, level in levels if pulled + 10**9 < at < mended} == {STALE}
    assert levels[-1][1] == OK
    # Of the warnings written into the cut, their writer keeps the last ten for the far side.
    missed = set(stamps(bag, "gear_monitor/chaos_warning", since=summary["chaos_warning"][0]))
    missed -= set(summary["chaos_warning"])
    assert all(pulled - 10**9 < at < mended for at in missed)


@pytest.mark.parametrize("skew", [-30.0, 30.0])
def test_clocks_that_disagree_shift_stamps_alone_and_a_clock_that_steps_restarts_the_model(
    processes: Processes, tmp_path: Path, domain_id: int, skew: float
) -> None:
    with Network() as network:
        site = Site(processes, network, tmp_path, domain_id)
        site.start()
        for now in (skew, 0.0):
            site.bench.order("drive", 900.0, now)
            site.bench.wait_for_level(OK)
            site.bench.wait(lambda said: sum("level" in s for s in said) > 20, "two seconds of warnings")
        bag, summary = site.end()
    assert sorted(stamps(bag, "motor/speed")) == sorted(summary["sent"])
    # Forces carry the bench's time of the sample, whatever the monitor's clock says.
    assert set(bag.joint("gear_monitor/mesh_force").stamp_ns) <= set(summary["sent"])
    said = reports(bag, "input")
    assert any(level == WARN and "clock" in text and "differ" in text for _, level, text, _ in said)
    ages = [float(values["speed age (s)"]) for _, level, _, values in said if level != STALE]
    assert ages
    assert max(ages) <= 0.5, "ages count from arrival: a skew does not enter them"
    last = reports(bag, "solver")[-1][3]
    step = "gap" if skew < 0 else "clock stepped back"
    assert [int(last[f"restarts, {kind}"]) for kind in (step, "diverged")] == [1, 0]
