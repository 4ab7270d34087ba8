"""Command lines, parameter files, names and domain ids."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from programs import MakeNode

from seat_gear_dynamics.runtime import arguments, exceptions, names
from seat_gear_dynamics.runtime.context import Context
from seat_gear_dynamics.runtime.node import Node
from seat_gear_dynamics.runtime.parameter_files import read_parameter_file
from seat_gear_dynamics.runtime.wire import domain as wire_domain


def node_with(domain_id: int, *words: str, name: str = "gear_monitor", **options: Any) -> Node:
    context = Context()
    context.init(["program", *words], domain_id=domain_id)
    return Node(name, context=context, start_parameter_services=False, **options)


def finish(node: Node) -> None:
    node.destroy_node()
    node.context.try_shutdown()


@pytest.mark.parametrize(
    ("words", "full_name", "topic"),
    [
        ([], "/gear_monitor", "/motor/speed"),
        (["-r", "__ns:=/bench"], "/bench/gear_monitor", "/bench/motor/speed"),
        (["-r", "__node:=other"], "/other", "/motor/speed"),
        (["--remap", "gear_monitor:__node:=other", "-r", "__ns:=/a/b"], "/a/b/other", "/a/b/motor/speed"),
        (["-r", "nobody:__node:=other"], "/gear_monitor", "/motor/speed"),
        (["-r", "motor/speed:=/spindle"], "/gear_monitor", "/spindle"),
        (["-r", "/motor/speed:=spindle", "-r", "__ns:=/b"], "/b/gear_monitor", "/b/motor/speed"),
        (["-r", "gear_monitor:motor/speed:=~/speed"], "/gear_monitor", "/gear_monitor/speed"),
        (["-r", "rosservice://motor/speed:=x"], "/gear_monitor", "/motor/speed"),
        (["-r", "rostopic://motor/speed:=x"], "/gear_monitor", "/x"),
    ],
)
def test_remapping(domain_id: int, words: list[str], full_name: str, topic: str) -> None:
    node = node_with(domain_id, "--ros-args", *words, "--", "--own", "1")
    assert node.get_fully_qualified_name() == full_name
    assert node.resolve_topic_name("motor/speed") == topic
    finish(node)


def test_own_arguments_of_a_node_come_first(domain_id: int) -> None:
    node = node_with(domain_id, "--ros-args", "-r", "x:=far", cli_args=["-r", "x:=near", "-p", "a:=2"])
    assert node.resolve_topic_name("x") == "/near"
    assert node.declare_parameter("a", 1).value == 2
    finish(node)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("-7", -7),
        ("0x10", 16),
        ("1.5", 1.5),
        ("1e-3", 1e-3),
        (".inf", float("inf")),
        ("true", True),
        ("off", False),
        ("'1'", "1"),
        ("text", "text"),
        ("", ""),
        ("[1, 2]", [1, 2]),
        ("[1.0, 2.5]", [1.0, 2.5]),
        ("[a, b]", ["a", "b"]),
    ],
)
def test_parameter_values_as_ros_reads_them(text: str, value: Any) -> None:
    found = arguments.parse(["--ros-args", "-p", f"name:={text}"]).parameters_for("/node")
    assert found == {"name": value}
    assert type(found["name"]) is type(value)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--wrong"], "Found unknown ROS arguments: '--wrong'"),
        (["-r"], "its value is missing"),
        (["-r", "a"], "is not a remapping rule"),
        (["-r", "/*:=x"], "wildcards"),
        (["-r", "/n/one:x:=y"], "is not a remapping rule. Invalid topic name"),
        (["-p", "/n/one:a:=1"], "is not a parameter"),
        (["-p", "/**:a:=1"], "is not a parameter"),
        (["-p", "a"], "is not a parameter"),
        (["-p", "a:=[1, 2.0]"], "different types"),
        (["-p", "a:=[1"], "not valid YAML"),
        (["--params-file", "/no/such/file.yaml"], "cannot be read"),
    ],
)
def test_wrong_arguments_are_sentences(words: list[str], says: str) -> None:
    with pytest.raises(RuntimeError) as caught:
        arguments.parse(["program", "--ros-args", *words])
    assert says in str(caught.value)


FILE = """
/**:
  ros__parameters:
    everywhere: 1
    limits: {low: 0.5, high: 2.0}
gear_monitor:
  ros__parameters: {only_here: text}
bench:
  gear_monitor:
    ros__parameters: {in_bench: true}
/*/gear_monitor:
  ros__parameters: {one_level: [1, 2]}
"""


@pytest.mark.parametrize(
    ("node", "expected"),
    [
        ("/gear_monitor", {"everywhere": 1, "limits.low": 0.5, "limits.high": 2.0, "only_here": "text"}),
        (
            "/bench/gear_monitor",
            {"everywhere": 1, "limits.low": 0.5, "limits.high": 2.0, "in_bench": True, "one_level": [1, 2]},
        ),
        ("/other", {"everywhere": 1, "limits.low": 0.5, "limits.high": 2.0}),
    ],
)
def test_parameter_file(tmp_path: Path, node: str, expected: dict[str, Any]) -> None:
    path = tmp_path / "parameters.yaml"
    path.write_text(FILE)
    found = arguments.parse(["--ros-args", "--params-file", str(path)])
    assert found.parameters_for(node) == expected


def test_later_values_win(tmp_path: Path) -> None:
    path = tmp_path / "parameters.yaml"
    path.write_text(FILE)
    found = arguments.parse(["--ros-args", "-p", "everywhere:=0", "--params-file", str(path), "-p", "one:=2"])
    assert found.parameters_for("/n")["everywhere"] == 1
    assert arguments.parse(["--ros-args", "-p", "n:a:=1", "-p", "a:=2"]).parameters_for("/n") == {"a": 2}


@pytest.mark.parametrize("text", ["a: [", "a: 3", "ros__parameters: {a: 1}", "a: {ros__parameters: 3}"])
def test_wrong_parameter_files_are_sentences(tmp_path: Path, text: str) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text(text)
    with pytest.raises(RuntimeError, match=r"wrong\.yaml"):
        read_parameter_file(path)


def test_other_arguments_are_left_alone() -> None:
    words = ["p", "--system", "x", "--ros-args", "-r", "a:=b", "--", "rest"]
    assert arguments.without_ros_arguments(words) == ["p", "--system", "x", "rest"]


@pytest.mark.parametrize(
    ("topic", "full"),
    [("x", "/ns/x"), ("/x", "/x"), ("~/x", "/ns/node/x"), ("~", "/ns/node"), ("a/b", "/ns/a/b")],
)
def test_names_expand(topic: str, full: str) -> None:
    assert names.expand_topic_name(topic, "node", "/ns") == full
    assert names.ros_topic(names.dds_topic(full)) == full


@pytest.mark.parametrize("topic", ["", "a b", "a//b", "1a", "a/", "~x", "a/2b", "/"])
def test_wrong_topics_are_refused(make_node: MakeNode, topic: str) -> None:
    with pytest.raises(exceptions.InvalidTopicNameException):
        make_node().resolve_topic_name(topic)


@pytest.mark.parametrize("name", ["", "a b", "1a", "a/b", "x" * 256])
def test_wrong_node_names_are_refused(make_node: MakeNode, name: str) -> None:
    with pytest.raises(exceptions.InvalidNodeNameException):
        make_node(name)


def test_wrong_namespace_is_refused(make_node: MakeNode) -> None:
    with pytest.raises(exceptions.InvalidNamespaceException):
        make_node(namespace="a//b")


@pytest.mark.parametrize(("text", "domain"), [("", 0), ("7", 7), (" 232 ", 232)])
def test_domain_id(text: str, domain: int) -> None:
    assert wire_domain.domain_id_from({"ROS_DOMAIN_ID": text}) == domain
    assert wire_domain.domain_id_from({}) == 0


@pytest.mark.parametrize("text", ["233", "-1", "x", "1.5"])
def test_wrong_domain_id_is_a_sentence(text: str) -> None:
    with pytest.raises(RuntimeError, match="expected a whole number from 0 to 232"):
        wire_domain.domain_id_from({"ROS_DOMAIN_ID": text})
