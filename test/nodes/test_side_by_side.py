"""Several nodes: two monitors beside each other, one with other names, and all of a bench in one process."""

from pathlib import Path

from harness import Peer, Processes
from monitored import Managed, paced

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.reader import Bag

OK, WARN, ERROR, STALE = range(4)


def reported(peer: Peer) -> set[str]:
    """Return the names in the diagnostics so far."""
    return {status.name for array in peer.messages["/diagnostics"] for status in array.status}


def test_two_monitors_in_two_namespaces_do_not_hear_each_other(processes: Processes, peer: Peer) -> None:
    from diagnostic_msgs.msg import DiagnosticStatus
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Float64

    heard: dict[str, list[int]] = {"left": [], "right": []}
    names: set[str] = set()
    senders = {}
    for side, levels in heard.items():
        processes.node("monitor", "-r", f"__ns:=/{side}")

        def hear(message: DiagnosticStatus, levels: list[int] = levels) -> None:
            levels.append(message.level[0])
            names.add(message.name)

        peer.node.create_subscription(
            DiagnosticStatus, f"/{side}/gear_monitor/chaos_warning", hear, QoSProfile(depth=50)
        )
        senders[side] = [
            peer.node.create_publisher(Float64, f"/{side}/{topic}", QoSProfile(depth=10))
            for topic in ("load/torque", "motor/speed")
        ]
    rpm = {"left": 900.0, "right": 1800.0}

    def send() -> None:
        for side, (load, speed) in senders.items():
            load.publish(Float64(data=600.0))
            speed.publish(Float64(data=rpm[side] * RPM))

    paced(
        peer, lambda: 0.01, send, lambda: heard["left"][-1:] == [OK] and heard["right"][-1:] == [ERROR], "both levels"
    )
    assert ERROR not in heard["left"]
    assert names == {"left/gear_monitor: chaos warning", "right/gear_monitor: chaos warning"}
    parts = {"left/gear_monitor: input", "right/gear_monitor: input"}
    paced(peer, lambda: 0.01, send, lambda: parts <= reported(peer), "the health of both")
    assert Managed(peer, "/left/gear_monitor").change("deactivate"), "each is led by itself"
    assert Managed(peer, "/right/gear_monitor").state() == "active"


def test_a_monitor_of_another_name_with_remapped_inputs_works(processes: Processes, peer: Peer) -> None:
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Float64

    remapped = ("__node:=second", "motor/speed:=/drive/speed", "load/torque:=/drive/load")
    processes.node("monitor", *[word for rule in remapped for word in ("-r", rule)])
    load, speed = (
        peer.node.create_publisher(Float64, topic, QoSProfile(depth=10)) for topic in ("/drive/load", "/drive/speed")
    )

    def send() -> None:
        load.publish(Float64(data=600.0))
        speed.publish(Float64(data=1800 * RPM))

    paced(peer, lambda: 0.01, send, lambda: peer.level() == ERROR, "the alarm from remapped inputs")
    assert peer.warnings()[-1].name == "second: chaos warning"
    assert Managed(peer, "/second").state() == "active"


def test_a_whole_bench_in_one_process(processes: Processes, peer: Peer, tmp_path: Path) -> None:
    log = tmp_path / "run"
    rules = (
        "bench_recorder:output:=" + str(log),
        "bench_simulator:profile:=dwell-in-band",
        "gear_monitor:publish_rate:=20.0",
    )
    flags = [word for rule in rules for word in ("-p", rule)]
    bench = processes.start("-m", "seat_gear_dynamics.nodes.compose", "--ros-args", *flags)
    forces = peer.messages["gear_monitor/mesh_force"]
    peer.wait(lambda: len(forces) > 50, "forces")
    peer.wait(lambda: {"bench_recorder: recording", "gear_monitor: solver"} <= reported(peer), "both nodes' health")
    assert Managed(peer).get("publish_rate").double_value == 20.0
    assert processes.end(bench) == 0, processes.words(bench)
    assert "Traceback" not in processes.words(bench)
    bag = Bag(log)
    assert bag.closed
    assert bag.topics["/gear_monitor/mesh_force"].count > 20


def test_a_component_that_is_none_is_named(processes: Processes) -> None:
    started = processes.start("-m", "seat_gear_dynamics.nodes.compose", "monitor", "toaster")
    assert started.wait(60) == 2
    assert "'toaster' is no component; expected some of simulator, monitor, recorder" in processes.words(started)
