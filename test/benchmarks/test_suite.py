"""The benchmarks as one run: that it measures, reports, compares with its record, and survives what is broken."""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks import suite
from benchmarks.ratio import Findings, Ratio

ROOT = Path(__file__).resolve().parents[2]


def run(*words: str) -> tuple[dict[str, Any], str]:
    command = [sys.executable, "-m", "benchmarks", "--short", *words]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found, done.stderr


def test_it_runs_records_and_says_what_changed(tmp_path: Path) -> None:
    records, output = tmp_path / "records", tmp_path / "found.json"
    first, words = run("--only", "core", "--records", str(records), "--record")
    assert "no record to compare with" in words
    assert (records / "short.json").is_file()
    assert first["form"] == "short"
    assert not first["broken"]
    march = first["ratios"]["core.march_pair_over_calibration"]
    assert march["median"] == sorted(march["values"])[2]
    assert all(value > 0 for ratio in first["ratios"].values() for value in ratio["values"])

    stored = json.loads((records / "short.json").read_text())
    for ratio in stored["ratios"].values():  # a record of a machine a thousand times as fast
        ratio["values"] = [1000 * value for value in ratio["values"]]
    (records / "short.json").write_text(json.dumps(stored))
    second, words = run("--only", "core", "--records", str(records), "--output", str(output))
    assert "0 better" in words
    assert {change["verdict"] for change in second["changes"]} == {"worse"}
    assert json.loads(output.read_text()) == second


def test_what_is_broken_takes_nothing_else_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(**_: Any) -> Findings:
        raise OSError("no such thing")

    modules = {
        "benchmarks.core": SimpleNamespace(measure=broken),
        "benchmarks.lanes": SimpleNamespace(measure=lambda **_: Findings({"a": 1})),
    }
    monkeypatch.setattr(suite, "import_module", modules.__getitem__)
    told: list[str] = []
    found, failed = suite.run(["core", "lanes"], short=True, progress=told.append)
    assert list(found) == ["lanes"]
    assert "OSError: no such thing" in failed["core"]
    assert told == ["core is broken: OSError: no such thing"]


def test_runs_are_pooled_repeat_by_repeat() -> None:
    one, two = Ratio((1.0, 2.0), "m", "lower", 3.0), Ratio((4.0,), "m", "lower", 3.0)
    assert suite.pooled([{"a": one}, {"a": two, "b": two}]) == {
        "a": Ratio((1.0, 2.0, 4.0), "m", "lower", 3.0),
        "b": two,
    }


def test_the_short_form_is_part_of_the_full_one() -> None:
    assert set(suite.SHORT) < set(suite.FULL)
