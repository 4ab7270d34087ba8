"""Recovery of whole bags: what is kept, named and claimed, and what is refused."""

from __future__ import annotations

import errno
import os
import shutil
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from mcap.reader import make_reader
from mcap.writer import Writer
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

from seat_gear_dynamics.logs.container import scan
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag, BagMessage
from seat_gear_dynamics.logs.recovery import recover
from seat_gear_dynamics.logs.recovery.rebuild import RebuiltFile
from seat_gear_dynamics.logs.recovery.tally import Tally
from seat_gear_dynamics.logs.recovery.verify import verify

SmallLog = Callable[..., Path]
THIRD_PARTY = Path(__file__).resolve().parents[3] / "bags" / "third_party_bench"
ALL = ("seat_gear_dynamics", "mcap", "rosbags")


def messages(path: Path) -> list[BagMessage]:
    return list(Bag(path).messages())


def harm(path: Path, *places: int) -> None:
    data = bytearray(path.read_bytes())
    for place in places:
        data[place] ^= 0x55
    path.write_bytes(data)


def inside(path: Path, number: int) -> int:
    """Return an offset in the data of a chunk."""
    block = scan(path).blocks[number]
    return block.offset + block.length - 20


def information(bag: Path) -> dict[str, Any]:
    text = (bag / "metadata.yaml").read_text()
    found: dict[str, Any] = yaml.safe_load(text)["rosbag2_bagfile_information"]
    return found


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_a_sound_log_comes_out_as_it_was(small_log: SmallLog, compression: str) -> None:
    log = small_log(compression=compression, max_duration_s=0.25)
    before = {path: path.read_bytes() for path in log.iterdir()}
    result = recover(log, version="1.2.3")
    assert result.output == log.with_name("log_recovered")
    assert messages(result.output) == messages(log)
    assert {path: path.read_bytes() for path in log.iterdir()} == before
    assert [topic.lost for topic in result.topics.values()] == [0, 0]
    assert (result.verified_by, result.notes, result.messages) == (ALL, (), 120)
    assert [file.recovered_as for file in result.files] == [f"log_recovered_{i}.mcap" for i in range(3)]
    old, new = information(log), information(result.output)
    custom = {"recovered_from": "log", "recovery": "0 damaged stretches left out"}
    assert new.pop("custom_data") == (old["custom_data"] or {}) | custom
    assert new["relative_file_paths"] == [name.replace("log_", "log_recovered_") for name in old["relative_file_paths"]]
    for key in ("message_count", "duration", "starting_time", "topics_with_message_count", "ros_distro", "version"):
        assert new[key] == old[key], key
    assert Bag(result.output).metadata == Bag(log).metadata
    assert sorted(path.name for path in log.parent.iterdir()) == ["log", "log_recovered"]


def test_chunks_are_copied_and_sequence_numbers_stay(small_log: SmallLog) -> None:
    log = small_log(compression="zstd")
    output = recover(log).output

    def sequences(path: Path) -> list[tuple[str, int]]:
        with open(path, "rb") as file:
            reader = make_reader(file, validate_crcs=True)
            return [(c.topic, m.sequence) for _, c, m in reader.iter_messages(log_time_order=False)]

    assert sequences(output / "log_recovered_0.mcap") == sequences(log / "log_0.mcap")
    old, new = (log / "log_0.mcap").read_bytes(), (output / "log_recovered_0.mcap").read_bytes()
    for block in scan(log / "log_0.mcap").blocks:
        assert old[block.offset : block.offset + block.length] in new


def test_a_damaged_chunk_is_lost_alone_and_counted(small_log: SmallLog) -> None:
    log = small_log()
    path = log / "log_0.mcap"
    lost = scan(path).blocks[2].messages((1, 2))
    whole = messages(log)
    harm(path, inside(path, 2))
    result = recover(log)
    assert messages(result.output) == [m for m in whole if m.data not in [row.data for row in lost]]
    assert sum(topic.lost or 0 for topic in result.topics.values()) == len(lost) > 0
    assert all(topic.exact for topic in result.topics.values())
    assert [stretch.reason for stretch in result.files[0].lost] == ["the chunk's checksum is wrong"]
    assert information(result.output)["message_count"] == len(whole) - len(lost)
    assert information(result.output)["custom_data"]["recovery"] == "1 damaged stretches left out"


def test_losses_are_told_from_metadata_yaml_where_the_summary_is_gone(small_log: SmallLog) -> None:
    log = small_log()
    path = log / "log_0.mcap"
    block = scan(path).blocks[-2]
    path.write_bytes(path.read_bytes()[: block.offset + 50])
    result = recover(log)
    kept = len(messages(result.output))
    assert 0 < kept < 120
    assert sum(topic.lost or 0 for topic in result.topics.values()) == 120 - kept
    assert not any(topic.exact for topic in result.topics.values())
    assert "≥" in "\n".join(result.lines())
    (log / "metadata.yaml").unlink()
    result = recover(log, log.with_name("second"))
    assert [topic.lost for topic in result.topics.values()] == [None, None]
    assert result.notes == ("metadata.yaml is missing.",)


# A text that is small as YAML, whose aliases unfold to 10^12 words.
ALIASES = "a0: &a0 [x]\n" + "".join(f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 10)}]\n" for i in range(12))
ENDLESS = f"{ALIASES}rosbag2_bagfile_information: {{relative_file_paths: [log_0.mcap], custom_data: {{k: *a12}}, "


@pytest.mark.parametrize(
    "text",
    [
        "",
        "][",
        "a: 1\n",
        "rosbag2_bagfile_information: 3\n",
        "\0",
        "[" * 100_000,  # nested too deeply for a parser
        ENDLESS + "topics_with_message_count: []}\n",
        "x" * 2**23,  # larger than any metadata
    ],
    ids=range(8),
)
def test_a_metadata_file_of_any_kind_costs_nothing(small_log: SmallLog, text: str) -> None:
    log = small_log(max_duration_s=0.25)
    whole = messages(log)
    (log / "metadata.yaml").write_text(text)
    result = recover(log)
    assert messages(result.output) == whole
    assert any("metadata.yaml cannot be read" in note for note in result.notes)


def test_a_stale_metadata_file_hides_no_split_and_a_missing_one_is_told(small_log: SmallLog) -> None:
    log = small_log(max_duration_s=0.25)
    whole = messages(log)
    text = (log / "metadata.yaml").read_text().replace("    - log_2.mcap\n", "")
    (log / "metadata.yaml").write_text(text)
    assert messages(recover(log).output) == whole
    (log / "log_0.mcap").unlink()
    result = recover(log, log.with_name("second"))
    assert result.notes == ("log_0.mcap, which metadata.yaml lists, is missing.",)
    assert [topic.lost for topic in result.topics.values()] == [25, 25]


def test_a_file_without_anything_sound_is_left_out_and_the_rest_renumbered(small_log: SmallLog) -> None:
    log = small_log(max_duration_s=0.25)
    rest = messages(log / "log_1.mcap") + messages(log / "log_2.mcap")
    (log / "log_0.mcap").write_bytes(bytes(5000))
    result = recover(log)
    assert messages(result.output) == rest
    assert [file.recovered_as for file in result.files] == [None, "log_recovered_0.mcap", "log_recovered_1.mcap"]
    assert result.files[0].lost_bytes == 5000


def test_a_single_file_becomes_a_bag(small_log: SmallLog) -> None:
    log = small_log()
    shutil.copy(log / "log_0.mcap", log.with_name("alone.mcap"))
    result = recover(log.with_name("alone.mcap"))
    assert result.output == log.with_name("alone_recovered")
    assert messages(result.output) == messages(log)


def without_names(path: Path) -> None:
    """Damage every chunk of a file that declares topics, and cut its summary off."""
    blocks = scan(path).blocks
    data = path.read_bytes()
    declaring = [
        i for i, block in enumerate(blocks) if b"offered_qos" in data[block.offset : block.offset + block.length]
    ]
    start = int.from_bytes(data[-28:-20], "little")
    harm(path, *(inside(path, number) for number in declaring))
    path.write_bytes(path.read_bytes()[: start - 13])


def test_lost_names_are_taken_from_other_files_of_our_recorder_only(small_log: SmallLog) -> None:
    log = small_log(max_duration_s=0.35)
    first = messages(log / "log_0.mcap")
    without_names(log / "log_1.mcap")
    foreign = shutil.copytree(log, log.with_name("foreign"))
    result = recover(log)
    assert len(messages(result.output)) > len(first)
    assert set(messages(result.output)) > set(first)
    assert any("the names of 2 topics were lost, and taken from other files" in note for note in result.notes)
    for path in foreign.glob("*.mcap"):
        path.write_bytes(path.read_bytes().replace(b"seat_gear_dynamics 0.1.0", b"somebody_elses_tool 0.1.", 1))
    result = recover(foreign)
    assert messages(result.output) == first
    assert any("nothing says to which topics" in note for note in result.notes)


def test_lost_names_are_taken_from_metadata_yaml_only_unchecked(small_log: SmallLog) -> None:
    log = small_log()
    whole = set(messages(log))
    without_names(log / "log_0.mcap")
    with pytest.raises(LogError, match=r"nothing says to which topics its .* messages belong; --unchecked"):
        recover(log)
    result = recover(log, unchecked=True)
    assert 0 < len(messages(result.output)) < len(whole)
    assert set(messages(result.output)) < whole
    assert any("taken from metadata.yaml" in note for note in result.notes)


def test_a_bag_without_checksums_is_refused_and_kept_unchecked(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no checksum vouches for any message in it; --unchecked"):
        recover(THIRD_PARTY, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []
    result = recover(THIRD_PARTY, tmp_path / "out", unchecked=True)
    assert messages(result.output) == messages(THIRD_PARTY)
    assert result.verified_by == ALL
    assert any("kept unchecked" in note for note in result.notes)
    old, new = information(THIRD_PARTY), information(result.output)
    # rosbag2 lists topics in an order of its own.
    assert sorted(map(str, old["topics_with_message_count"])) == sorted(map(str, new["topics_with_message_count"]))


def test_a_bag_written_by_rosbags_is_recovered_with_its_qualities(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    with RosbagsWriter(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/x", "std_msgs/msg/Bool", typestore=store)
        for i in range(200):
            writer.write(connection, 10**18 + i, b"\0\1\0\0" + bytes([i % 2]))
    path = next((tmp_path / "bag").glob("*.mcap"))
    path.write_bytes(path.read_bytes()[:-40])
    result = recover(tmp_path / "bag", unchecked=True)
    assert len(messages(result.output)) == 200
    with AnyReader([result.output]) as reader:
        assert sum(1 for _ in reader.messages()) == 200


def make_mixed(path: Path, profile: str = "ros2") -> None:
    with open(path, "wb") as file:
        writer = Writer(file, chunk_size=200)
        writer.start(profile)
        writer.add_attachment(1, 2, "photo", "image/png", b"\x89PNG" * 100)
        encoding = "ros2msg" if profile == "ros2" else "jsonschema"
        schema = writer.register_schema("std_msgs/msg/Bool", encoding, b"bool data")
        channel = writer.register_channel("/x", "cdr" if profile == "ros2" else "json", schema)
        for i in range(30):
            writer.add_message(channel, i, struct.pack("<4s?", b"\0\1\0\0", True), i, i)
        writer.add_metadata("note", {"bench": "7"})
        writer.add_metadata("rosbag2", {"serialized_metadata": "message_count: 30"})
        writer.finish()  # type: ignore[no-untyped-call]


@pytest.mark.parametrize("profile", ["ros2", ""])
def test_attachments_and_metadata_are_kept_and_rosbag2s_own_is_stated_anew(tmp_path: Path, profile: str) -> None:
    path = tmp_path / "mixed.mcap"
    make_mixed(path, profile)
    harm(path, inside(path, 1))
    result = recover(path)
    with open(result.output / "mixed_recovered_0.mcap", "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert [(a.name, a.log_time, a.create_time, a.data) for a in reader.iter_attachments()] == [
            ("photo", 2, 1, b"\x89PNG" * 100)
        ]
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
    assert metadata["note"] == {"bench": "7"}
    kept = yaml.safe_load(metadata["rosbag2"]["serialized_metadata"])["message_count"]
    assert kept == result.messages < 30
    assert result.verified_by == (ALL if profile else ALL[:2])


def test_what_was_recovered_can_be_damaged_and_recovered_again(small_log: SmallLog) -> None:
    log = small_log()
    whole = messages(log)
    harm(log / "log_0.mcap", inside(log / "log_0.mcap", 0))  # the chunk with the declarations
    first = recover(log).output
    path = first / "log_recovered_0.mcap"
    path.write_bytes(path.read_bytes()[:-600])
    second = recover(first).output
    assert second.name == "log_recovered_recovered"
    assert set(messages(second)) <= set(messages(first)) < set(whole)
    assert messages(second)


def test_paths_that_will_not_do_are_refused(small_log: SmallLog, tmp_path: Path) -> None:
    log = small_log()
    (tmp_path / "there").mkdir()
    (tmp_path / "empty").mkdir()
    cases = [
        (log, tmp_path / "there", "exists already"),
        (log, log / "inside", "would lie in the damaged log"),
        (tmp_path / "nowhere", None, "There is no log"),
        (tmp_path / "empty", None, "holds no .mcap file"),
    ]
    for source, output, said in cases:
        with pytest.raises(LogError, match=said):
            recover(source, output)
    (tmp_path / "zeros.mcap").write_bytes(bytes(1000))
    with pytest.raises(LogError, match="no sound message is left"):
        recover(tmp_path / "zeros.mcap")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["empty", "log", "there", "zeros.mcap"]


def test_a_full_disk_leaves_nothing_behind(small_log: SmallLog, monkeypatch: pytest.MonkeyPatch) -> None:
    log = small_log()

    def full(self: RebuiltFile) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(RebuiltFile, "finish", full)
    with pytest.raises(LogError, match=r"cannot be recovered to .*: No space left"):
        recover(log)
    assert [path.name for path in log.parent.iterdir()] == ["log"]


def test_the_verification_finds_a_message_too_many_too_few_and_a_changed_one(small_log: SmallLog) -> None:
    log = small_log()

    def tally(rows: list[BagMessage]) -> Tally:
        found = Tally()
        for row in rows:
            found.add(*row)
        return found

    rows = messages(log)
    assert verify(log, tally(rows), ros2=True) == (ALL, [])
    changed = [rows[0]._replace(data=rows[2].data), *rows[1:]]
    for wrong in (rows[1:], [*rows, rows[0]], changed, [rows[0]._replace(log_time_ns=1), *rows[1:]]):
        with pytest.raises(LogError, match="does not read back"):
            verify(log, tally(wrong), ros2=True)
    harm(log / "log_0.mcap", inside(log / "log_0.mcap", 1))
    with pytest.raises(LogError, match="does not read back"):
        verify(log, tally(rows), ros2=True)


def test_each_stage_is_told_up_to_its_end(small_log: SmallLog) -> None:
    log, told = small_log(max_duration_s=0.25), list[tuple[str, int, int]]()
    harm(log / "log_0.mcap", inside(log / "log_0.mcap", 1))
    found = recover(log, tell=lambda *given: told.append(given))
    kept = sum(topic.kept for topic in found.topics.values())
    stages = {stage: [given[1:] for given in told if given[0] == stage] for stage, _, _ in told}
    assert list(stages) == ["searching, MiB", "writing, MiB", "reading back"]
    assert all(given == sorted(given) for given in stages.values())
    assert [given[-1] for given in stages.values()] == [(1, 1), (1, 1), (2 * kept, 2 * kept)]


def test_a_link_is_recovered_beside_itself(
    small_log: SmallLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small_log(tmp_path / "far" / "log")
    (tmp_path / "near").symlink_to(tmp_path / "far" / "log")
    assert recover(tmp_path / "near").output == tmp_path / "near_recovered"
    monkeypatch.chdir(tmp_path / "far" / "log")
    assert recover(".").output == tmp_path / "far" / "log_recovered"
