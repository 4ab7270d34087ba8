"""`seat-gear replay`: exit codes, JSON, words, and what if."""

import json
from pathlib import Path

import pytest

from seat_gear_dynamics.commands import main

OURS = str(Path(__file__).parents[2] / "bags" / "bench_dwell")


def test_the_replay_of_a_recorded_log_covers_all_its_outputs(capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["replay", OURS, "--json"])
    values = json.loads(capsys.readouterr().out)
    assert {each["topic"] for each in values["topics"]} == {
        f"gear_monitor/{name}" for name in ("mesh_force", "mesh_state", "poincare", "chaos_warning")
    }
    assert values["samples"] == 810
    assert values["what_if"] is False
    # The log may be from another build than this one: then it differs, says where, and ends with 1.
    assert code == (0 if values["identical"] else 1)
    assert (values["first_difference"] is None) == values["identical"]


def test_what_if_shows_both_and_ends_with_0(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", OURS, "--set", "meshes.*.damping_ratio=0.12", "--set", "margin_rpm=80", "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["what_if"] is True
    assert values["identical"] is False
    assert values["forces"]["s1_s2"]["logged"] != values["forces"]["s1_s2"]["replayed"]
    assert values["level_seconds"]["WARN"]["replayed"] > values["level_seconds"]["WARN"]["logged"] + 1


def test_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", OURS, "--set", "hold=0.5"]) == 0
    text = capsys.readouterr().out
    assert "810 samples replayed" in text
    assert "warnings of silence are taken over from the log" in text
    assert "what if" in text
    assert "s1_s2 max, N" in text


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("margin", "expected NAME=VALUE"),
        ("margin=3", "is unknown"),
        ("meshes.s1_s2.damping=0.1", "no parameter"),
        ("meshes.s1_s2.damping_ratio=-1", "expected"),
    ],
)
def test_wrong_settings_are_one_line(setting: str, sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", OURS, "--set", setting]) == 1
    printed = capsys.readouterr()
    assert sentence in printed.err
    assert len(printed.err.strip().splitlines()) == 1
