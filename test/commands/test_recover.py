"""`seat-gear recover`: what it prints, and how it ends."""

import argparse
import io
import json
import struct
import sys
from pathlib import Path

import pytest

from seat_gear_dynamics.commands import recover
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.writer import BagWriter


class Terminal(io.StringIO):
    """A standard error that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def parsed(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    parser.add_argument("--system")
    parser.add_argument("--json", action="store_true")
    recover.add_arguments(parser)
    return parser.parse_args(arguments)


@pytest.fixture
def damaged(tmp_path: Path) -> Path:
    """A log whose third chunk has a wrong byte."""
    with BagWriter(tmp_path / "log", system_text="", system_hash="", software_version="0", chunk_size=400) as log:
        log.add_topic("/a", "std_msgs/msg/Float64")
        for i in range(100):
            log.write("/a", struct.pack("<4sd", b"\0\1\0\0", i), 10**18 + i, i)
    path = tmp_path / "log" / "log_0.mcap"
    data = bytearray(path.read_bytes())
    third = [i for i in range(len(data)) if data[i : i + 8] == b"\x04\0\0\0zstd"][2]
    data[third + 30] ^= 1
    path.write_bytes(data)
    return tmp_path / "log"


def test_people_read_what_was_kept_and_lost(damaged: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert recover.run(parsed(str(damaged))) == 0
    text = capsys.readouterr().out
    kept = Bag(damaged.with_name("log_recovered")).message_count
    assert 0 < kept < 100
    assert text.startswith(f"{kept} messages recovered from {damaged}\n")
    row = next(line.split() for line in text.splitlines() if line.startswith("/a"))
    assert row == ["/a", str(kept), str(100 - kept)]
    assert "read back by: seat_gear_dynamics, mcap, rosbags" in text
    assert "  bytes " in text


def test_a_terminal_sees_how_far_it_is(damaged: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    assert recover.run(parsed(str(damaged))) == 0
    for stage in ("searching, MiB", "writing, MiB", "reading back"):
        assert stage in stream.getvalue()


def test_json_is_one_object(damaged: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert recover.run(parsed(str(damaged), "--json", "--output", str(tmp_path / "new" / "sound"))) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["output"] == str(tmp_path / "new" / "sound")
    assert values["topics"]["/a"]["kept"] + values["topics"]["/a"]["lost"] == 100
    assert values["topics"]["/a"]["exact"] is True
    (file,) = values["files"]
    (lost,) = file["lost"]
    assert file["lost_bytes"] == lost["end"] - lost["begin"] > 0
    assert (values["unchecked"], values["notes"]) == (False, [])


def test_nothing_recovered_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "zeros.mcap").write_bytes(bytes(100))
    with pytest.raises(LogError, match=r"^Nothing of the log .* can be recovered: no sound message is left in it\.$"):
        recover.run(parsed(str(tmp_path / "zeros.mcap"), "--json"))
    assert capsys.readouterr().out == ""


def test_strict_is_the_default_and_excludes_unchecked() -> None:
    assert parsed("log").unchecked is False
    assert parsed("log", "--strict").unchecked is False
    assert parsed("log", "--unchecked").unchecked is True
    with pytest.raises(SystemExit) as ended:
        parsed("log", "--strict", "--unchecked")
    assert ended.value.code == 2
