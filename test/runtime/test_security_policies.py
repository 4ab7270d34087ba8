"""The security policy against the code: each node may do what it does, and nothing more."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from programs import ROOT, MakeNode, Run, SpinUntil

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.runtime.node import Node

POLICY = ROOT / "config" / "security" / "seat_gear.policy.xml"
NODES = {"gear_monitor": "monitor", "bench_recorder": "recorder", "bench_simulator": "simulator"}

PROGRAM = """
import runpy, sys
runpy.run_module("seat_gear_dynamics.nodes." + sys.argv[1], run_name="__main__", alter_sys=True)
"""

Rights = dict[str, set[str]]


def granted() -> dict[str, Rights]:
    """Return, per node, "publish", "subscribe", "reply" and "request" with absolute names, as sros2 reads them."""
    found: dict[str, Rights] = {}
    for enclave in ElementTree.parse(POLICY).getroot().iter("enclave"):
        (profile,) = enclave.iter("profile")
        node, namespace = profile.attrib["node"], profile.attrib["ns"]
        assert enclave.attrib["path"] == f"/seat_gear/{node}"
        rights: Rights = {kind: set() for kind in ("publish", "subscribe", "reply", "request")}
        for group in profile:
            (kind,) = group.attrib
            assert group.attrib[kind] == "ALLOW"
            for entry in group:
                name = (entry.text or "").replace("~/", f"{node}/")
                rights[kind].add(name if name.startswith("/") else f"{namespace}{name}")
        found[node] = rights
    return found


@pytest.fixture(scope="module")
def policy() -> dict[str, Rights]:
    return granted()


def contract(direction: str) -> set[str]:
    return {topic.absolute() for topic in topics.TOPICS if topic.direction == direction}


def test_it_has_the_three_nodes_and_an_operator_and_no_wildcard_of_theirs(policy: dict[str, Rights]) -> None:
    assert set(policy) == {*NODES, "operator"}
    patterns = {name for rights in policy.values() for names in rights.values() for name in names if "*" in name}
    assert patterns == {"/_ros2cli_*"}, "the ros2 commands' own nodes"
    assert not any("*" in name for node in NODES for names in policy[node].values() for name in names)


def test_the_rights_to_the_contracts_topics_follow_the_contract(policy: dict[str, Rights]) -> None:
    spoken = contract("out")
    ours = {
        node: {kind: rights[kind] & (spoken | contract("in")) for kind in ("publish", "subscribe")}
        for node, rights in policy.items()
    }
    everything = spoken | contract("in")
    diagnostics = {topics.DIAGNOSTICS.name}
    assert ours["gear_monitor"] == {"publish": spoken, "subscribe": contract("in")}
    assert ours["bench_simulator"] == {"publish": contract("in"), "subscribe": set()}
    assert ours["bench_recorder"] == {"publish": diagnostics, "subscribe": everything}
    assert ours["operator"] == {"publish": set(), "subscribe": everything}


def test_only_the_operator_may_call_and_only_what_there_is(policy: dict[str, Rights]) -> None:
    offered = set().union(*(policy[node]["reply"] for node in NODES))
    for node in NODES:
        assert policy[node]["request"] == set()
    called = policy["operator"]["request"]
    assert called < offered
    assert not {name for name in called if "parameter" in name or "state" in name}
    own = {name.rsplit("/", 1)[1] for name in called}
    assert own == {"reset", "start", "stop", "pause", "resume", "split", "snapshot"}


@pytest.fixture
def looker(make_node: MakeNode, run: Run, tmp_path: Path) -> Node:
    """A node beside the three, as processes of their own."""
    for name, more in (("recorder", f"output:={tmp_path / 'log'}"), ("simulator", "seed:=1"), ("monitor", "")):
        run(PROGRAM, name, *(("--ros-args", "-p", more) if more else ()))
    return make_node("looker")


def test_each_node_has_every_right_it_uses_and_no_other(
    looker: Node, spin_until: SpinUntil, policy: dict[str, Rights]
) -> None:
    def seen(node: str) -> Rights:
        publishers = looker.get_publisher_names_and_types_by_node(node, "/")
        subscriptions = looker.get_subscriber_names_and_types_by_node(node, "/")
        services = looker.get_service_names_and_types_by_node(node, "/")
        clients = looker.get_client_names_and_types_by_node(node, "/")
        kinds = {"publish": publishers, "subscribe": subscriptions, "reply": services, "request": clients}
        return {kind: {name for name, _ in entries} for kind, entries in kinds.items()}

    expected: dict[str, Rights] = {}
    for node in NODES:
        expected[node] = {kind: set(names) for kind, names in policy[node].items()}
        # rclpy's own service, which the bundled runtime does not have.
        expected[node]["reply"].remove(f"/{node}/get_type_description")
    # The input of the other setting, input:=joint_states.
    expected["gear_monitor"]["subscribe"].remove(topics.JOINT_STATES.absolute())

    spin_until(lambda: set(NODES) <= set(looker.get_node_names()))
    spin_until(lambda: seen("gear_monitor") == expected["gear_monitor"])
    assert {node: seen(node) for node in NODES} == expected
