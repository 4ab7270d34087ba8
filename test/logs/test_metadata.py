"""Topics, schemas and metadata.yaml against the files of rosbag2 itself."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.logs import metadata
from seat_gear_dynamics.logs.container import scan
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.metadata import FileRecord, TopicRecord
from seat_gear_dynamics.logs.schemas import Decoder, schema
from seat_gear_dynamics.logs.topics import DIAGNOSTICS, IN_FORBIDDEN_BAND, MOTOR_SPEED, TOPICS, Qos

START, DURATION = 1795336238823342335, 63320725425


def test_the_text_is_rosbag2s_own_to_the_byte(third_party: Path) -> None:
    topics = [
        TopicRecord(name, type, schema(type).hash, (Qos(),))
        for name, type in (
            ("/motor/speed", "std_msgs/msg/Float64"),
            ("/load/torque", "std_msgs/msg/Float64"),
            ("/joint_states", "sensor_msgs/msg/JointState"),
        )
    ]
    counts = {topic.name: 12619 for topic in topics}
    files = [FileRecord("third_party_bench_0.mcap", START, START + DURATION, counts)]
    assert metadata.document(topics, files, {}).strip() == (third_party / "metadata.yaml").read_text().strip()
    empty, full = (record.metadata["serialized_metadata"] for record in scan(*third_party.glob("*.mcap")).metadata)
    assert metadata.serialized(topics, files, {}) == full
    assert metadata.serialized([], [FileRecord("third_party_bench_0.mcap", None, None, {})], {}) == empty


def test_the_channel_text_is_rosbag2s_own(third_party: Path) -> None:
    channel = next(iter(scan(*third_party.glob("*.mcap")).channels.values()))
    assert set(channel.metadata) == {"offered_qos_profiles", "topic_type_hash"}
    assert channel.metadata["offered_qos_profiles"] == metadata.offered_qos([Qos()])


def test_files_add_up() -> None:
    topics = [
        TopicRecord("/a", "std_msgs/msg/Bool", "h", ()),
        TopicRecord("/b", "std_msgs/msg/Bool", "h", ()),
    ]
    files = [
        FileRecord("x_0.mcap", 100, 300, {"/a": 2, "/b": 1}),
        FileRecord("x_1.mcap", 250, 900, {"/b": 4}),
        FileRecord("x_2.mcap", None, None, {}),
    ]
    info = yaml.safe_load(metadata.document(topics, files, {}))["rosbag2_bagfile_information"]
    assert info["starting_time"]["nanoseconds_since_epoch"] == 100
    assert info["duration"]["nanoseconds"] == 800
    assert info["message_count"] == 7
    assert [t["message_count"] for t in info["topics_with_message_count"]] == [2, 5]
    assert [f["message_count"] for f in info["files"]] == [3, 4, 0]
    assert info["files"][1]["duration"]["nanoseconds"] == 650
    assert info["files"][2]["starting_time"]["nanoseconds_since_epoch"] == 2**63 - 1


leaves = st.one_of(st.text(), st.integers(), st.booleans(), st.none())
trees = st.recursive(
    leaves,
    lambda node: st.one_of(
        st.lists(node, min_size=1, max_size=3),
        st.dictionaries(st.text(min_size=1), node, min_size=1, max_size=3),
    ),
    max_leaves=12,
)


@given(st.dictionaries(st.text(min_size=1), trees, min_size=1, max_size=3))
def test_whatever_is_emitted_any_yaml_parser_reads_back(tree: dict[str, object]) -> None:
    assert yaml.safe_load(metadata.to_yaml(tree)) == tree  # type: ignore[arg-type]


def test_every_declared_topic_has_a_schema_and_a_hash() -> None:
    for topic in TOPICS:
        found = schema(topic.type)
        assert re.fullmatch(r"RIHS01_[0-9a-f]{64}", found.hash)
        assert found.text
    assert len({topic.name for topic in TOPICS}) == 11


def test_schemas_equal_those_of_another_program(third_party: Path) -> None:
    def code(text: str) -> list[str]:
        lines = (line.split("#")[0].split() for line in text.splitlines() if not line.startswith("==="))
        return [" ".join(words).replace("/msg/", "/") for words in lines if words]

    for theirs in scan(*third_party.glob("*.mcap")).schemas.values():
        assert code(schema(theirs.name).text) == code(theirs.data.decode())


@pytest.mark.parametrize("name", ["std_msgs/msg/Flot64", "nonsense", "", "acme_msgs/msg/Gear"])
def test_an_unknown_type_is_a_sentence(name: str) -> None:
    with pytest.raises(LogError, match=r"is not among .* expected a full name"):
        schema(name)


def test_names_resolve_like_a_nodes() -> None:
    assert MOTOR_SPEED.absolute() == "/motor/speed"
    assert MOTOR_SPEED.absolute("/bench1") == "/bench1/motor/speed"
    assert DIAGNOSTICS.absolute("/bench1") == "/diagnostics"
    assert IN_FORBIDDEN_BAND.qos == Qos(durability="transient_local", history="keep_last", depth=1)


def test_a_foreign_type_is_decoded_from_its_own_text() -> None:
    decoder = Decoder({"acme_msgs/msg/Gear": "uint8 teeth\nfloat64 module\n"})
    message = decoder.decode(b"\0\1\0\0\x1f" + bytes(7) + b"\0\0\0\0\0\0\xf8\x3f", "acme_msgs/msg/Gear")
    assert (message.teeth, message.module) == (31, 1.5)
    with pytest.raises(LogError, match="cannot be decoded"):
        Decoder({}).decode(b"", "acme_msgs/msg/Gear")
    with pytest.raises(LogError, match="cannot be decoded"):
        Decoder({"acme_msgs/msg/Gear": "float64 [\n"}).decode(b"", "acme_msgs/msg/Gear")


@pytest.mark.parametrize("data", [b"", b"\0\1", b"\0\1\0\0", b"\0\1\0\0" + b"\xff" * 40])
def test_senseless_bytes_are_a_sentence(data: bytes) -> None:
    with pytest.raises(LogError, match="do not hold a message"):
        Decoder({}).decode(data, "sensor_msgs/msg/JointState")
