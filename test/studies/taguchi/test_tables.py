"""A study as rows."""

import pytest

from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.studies.taguchi import Factor, Study, run_study
from seat_gear_dynamics.studies.taguchi.tables import effect_rows, ratio_rows, run_rows, variance_rows

FACTORS = [Factor("a", "mm", (1.0, 2.0, 4.0)), Factor("b", "N", (1.0, 3.0, 9.0)), Factor("c", "1", (1.0, 2.0, 3.0))]
NOISE = [Factor("n", "rad", (-0.1, 0.1))]


def made(broken: float | None = None) -> Study:
    def evaluate(setting: dict[str, float]) -> dict[str, float]:
        if setting["a"] == setting["b"] == broken:
            raise DivergedError("The motion diverged.")
        y = setting["a"] / setting["b"] + setting["n"]
        return {"y": y, "z": 1 / y, "aside": 5.0}

    return run_study(FACTORS, evaluate, ["y", "z"], noise=NOISE)  # type: ignore[arg-type]


def test_there_is_a_row_for_every_experiment_with_units_and_everything_it_gave() -> None:
    rows = run_rows(made())
    assert len(rows) == 9 * 4
    assert [row["run"] for row in rows] == [run for run in range(1, 10) for _ in range(4)]
    assert rows[0] == {
        "run": 1,
        "a (mm)": 1.0,
        "b (N)": 1.0,
        "c (1)": 1.0,
        "n (rad)": -0.1,
        "y": 0.9,
        "z": 1 / 0.9,
        "aside": 5.0,
        "failure": "",
    }


def test_a_failed_experiment_has_its_row_with_the_reason() -> None:
    study = made(broken=1.0)
    rows = run_rows(study)
    assert rows[0]["failure"] == "The motion diverged."
    assert "y" not in rows[0]
    first = ratio_rows(study)[0]
    assert (first["y S/N (dB)"], first["y mean"]) == (None, None)
    failed = {(row["factor"], row["level"]): row["failed runs"] for row in effect_rows(study) if row["response"] == "y"}
    assert failed == {(f.name, level): int(level == 1) for f in FACTORS for level in (1, 2, 3)}


def test_there_is_a_row_for_every_run_with_its_ratios() -> None:
    study = made()
    rows = ratio_rows(study)
    assert [row["run"] for row in rows] == list(range(1, 10))
    for row, run in zip(rows, study.runs, strict=True):
        assert row["a (mm)"] == run.setting["a"]
        assert row["y S/N (dB)"] == run.ratios["y"]
        assert row["z mean"] == run.mean("z")


def test_the_variance_of_every_response_is_listed_to_its_total() -> None:
    rows = variance_rows(made())
    assert [(row["response"], row["source"]) for row in rows] == [
        (response, source) for response in ("y", "z") for source in ("a", "b", "c", "error", "total")
    ]
    y = rows[:4]
    shares = sum(row["contribution"] for row in y if not row["pooled"])
    # Shares of what is not pooled, and of the error, are all there is; rounding of a few sums.
    assert shares == pytest.approx(1.0, abs=1e-12)


def test_one_level_of_every_factor_is_the_best() -> None:
    rows = effect_rows(made())
    assert len(rows) == 2 * 9
    for response in ("y", "z"):
        best = {row["factor"]: row["value"] for row in rows if row["response"] == response and row["best"]}
        assert set(best) == {"a", "b", "c"}
        assert (best["a"], best["b"]) == ((1.0, 9.0) if response == "y" else (4.0, 1.0))


def test_a_study_without_an_analysis_has_runs_and_no_effects() -> None:
    def evaluate(setting: object) -> dict[str, float]:
        raise DivergedError("The motion diverged.")

    study = run_study(FACTORS, evaluate, ["y"])
    assert len(run_rows(study)) == 9
    assert (variance_rows(study), effect_rows(study)) == ([], [])
