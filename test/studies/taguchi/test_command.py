"""`seat-gear taguchi`: what it prints and writes."""

import argparse
import csv
import json
from functools import partial
from pathlib import Path

import pytest

from seat_gear_dynamics.commands import taguchi
from seat_gear_dynamics.commands.errors import CommandError
from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.studies import taguchi as studies

SHORT = partial(studies.vibration_and_impact, noise=(), transient=2, periods=2)


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without noise and with short runs: what is printed is under test, not the figures."""
    monkeypatch.setattr(studies, "vibration_and_impact", SHORT)


def parsed(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    parser.add_argument("--system")
    parser.add_argument("--json", action="store_true")
    taguchi.add_arguments(parser)
    return parser.parse_args(arguments)


def test_json_is_one_object_and_the_files_are_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "new" / "study"
    assert taguchi.run(parsed("--json", "--output", str(folder))) == 0
    printed = capsys.readouterr()
    values = json.loads(printed.out)
    assert (values["array"], set(values["responses"])) == ("L18", {"vibration", "impact"})
    written = [Path(name) for name in values["files"]]
    assert [path.name for path in written] == [
        "runs.csv",
        "ratios.csv",
        "variance.csv",
        "effects.csv",
        "main_effects_vibration.png",
        "main_effects_impact.png",
    ]
    assert sorted(folder.iterdir()) == sorted(written)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in written[4:])
    with (folder / "variance.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for response, found in values["responses"].items():
        shares = [float(row["contribution"]) for row in rows if row["response"] == response]
        assert shares == [source["contribution"] for source in found["variance"]]


def test_the_tables_are_printed_for_people(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def evaluate(setting: dict[str, float]) -> dict[str, float]:
        return {"impact": setting["speed"] / setting["load"] * setting["transmission error"] + setting["damping ratio"]}

    # In place of the command's own experiments, whose progress it counts.
    monkeypatch.setattr(studies, "vibration_and_impact", lambda *a, **k: SHORT(*a, **{**k, "evaluate": evaluate}))
    assert taguchi.run(parsed("--response", "impact", "--speed-rpm", "400", "--load", "500", "--array", "L27")) == 0
    text = capsys.readouterr().out
    assert text.startswith("array L27: 27 runs of ")
    assert "impact: mean S/N ratio" in text
    assert "vibration:" not in text
    for expected in ("transmission error", "pooled", "predicted at the best levels", "confirmation run:", "gain over"):
        assert expected in text
    present = {line.split()[0]: line.split()[1] for line in text.splitlines() if line.endswith(("N·m", "r/min"))}
    assert present == {"load": "500", "speed": "400"}
    assert all(len(line) <= 120 for line in text.splitlines())


def test_a_study_without_a_result_says_why(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def evaluate(setting: object) -> dict[str, float]:
        raise DivergedError("The motion diverged.")

    # In place of the command's own experiments, whose progress it counts.
    monkeypatch.setattr(studies, "vibration_and_impact", lambda *a, **k: SHORT(*a, **{**k, "evaluate": evaluate}))
    assert taguchi.run(parsed("--response", "vibration")) == 0
    text = capsys.readouterr().out
    assert "left out, because an experiment failed: runs 1, 2, 3" in text
    assert "vibration: no analysis. 18 of 18 runs failed." in text


def test_a_confirmation_that_fails_is_said(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def evaluate(setting: dict[str, float]) -> dict[str, float]:
        # All seven at their best together; the array has no such run.
        ratios = [setting["speed"] / 522.8, setting["transmission error"], setting["support stiffness"]]
        if max(ratios) < 0.9:
            raise DivergedError("The motion diverged.")
        return {"vibration": ratios[0] * ratios[1] * ratios[2]}

    # In place of the command's own experiments, whose progress it counts.
    monkeypatch.setattr(studies, "vibration_and_impact", lambda *a, **k: SHORT(*a, **{**k, "evaluate": evaluate}))
    taguchi.run(parsed("--response", "vibration"))
    assert "confirmation run: failed" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--array", "L10"), "no array 'L10' here"),
        (("--array", "L8"), "L8 has no free column of 3 levels"),
        (("--load", "0"), "The load is 0 N·m"),
        (("--load", "nan"), "load is nan"),
    ],
)
def test_what_cannot_be_studied_is_one_sentence(arguments: tuple[str, ...], said: str) -> None:
    with pytest.raises(CommandError, match=said):
        taguchi.run(parsed(*arguments))


def test_an_unknown_response_is_wrong_use() -> None:
    with pytest.raises(SystemExit) as ended:
        parsed("--response", "noise")
    assert ended.value.code == 2
