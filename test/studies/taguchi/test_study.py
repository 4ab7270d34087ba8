"""The study itself on analytic experiments: additive, interacting, noisy, failing."""

import json
from collections.abc import Mapping
from math import log10, prod

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.motion.march import DivergedError
from seat_gear_dynamics.studies.taguchi import (
    Factor,
    Study,
    analyse,
    larger_the_better,
    orthogonal_array,
    run_study,
    smaller_the_better,
)

FACTORS = [Factor(name, "1", (1.0, 2.0, 4.0), start=1) for name in "ABC"]
POWERS = {"A": 1.0, "B": -0.5, "C": 0.1}
NOISE = [Factor("gain", "1", (0.9, 1.1)), Factor("offset", "1", (0.0, 0.2))]


def product_of_powers(setting: Mapping[str, float]) -> dict[str, float]:
    """A product becomes a sum in dB: exactly additive."""
    return {"y": prod(setting[name] ** power for name, power in POWERS.items())}


def noisy_product(setting: Mapping[str, float]) -> dict[str, float]:
    return {"y": product_of_powers(setting)["y"] * setting["gain"] + setting["offset"]}


def study(**changes: object) -> Study:
    arguments: dict[str, object] = {"factors": FACTORS, "evaluate": product_of_powers, "responses": ["y"]}
    return run_study(**(arguments | changes))  # type: ignore[arg-type]


def test_an_additive_experiment_is_predicted_exactly_and_confirmed() -> None:
    finding = study().findings["y"]
    assert finding.analysis is not None
    assert finding.best is not None
    assert finding.predicted is not None
    assert finding.best.setting == {"A": 1.0, "B": 4.0, "C": 1.0}
    # In steps of 6.02 dB: the mean is that of the middle levels, −1 + 0.5 − 0.1; the best levels lie 1, 0.5 and 0.1
    # above it. C, the weakest, is pooled and so missing in the prediction.
    step = 20 * log10(2)
    assert finding.analysis.pooled == ("C",)
    assert finding.analysis.mean == pytest.approx(-0.6 * step, abs=1e-9)
    assert finding.predicted.value == pytest.approx(0.9 * step, abs=1e-9)
    assert finding.confirmed == pytest.approx(1.0 * step, abs=1e-9)
    assert finding.gain == pytest.approx(1.6 * step, abs=1e-9)
    assert finding.within is True


@settings(max_examples=20)
@given(st.lists(st.floats(-2, 2), min_size=3, max_size=3))
def test_without_pooling_prediction_confirmation_and_gain_agree(powers: list[float]) -> None:
    def experiment(setting: Mapping[str, float]) -> dict[str, float]:
        return {"y": prod(setting[name] ** power for name, power in zip("ABC", powers, strict=True))}

    if max(map(abs, powers)) < 1e-6:  # nothing varies: no variance to analyse
        return
    finding = study(evaluate=experiment, pooled=()).findings["y"]
    assert finding.predicted is not None
    assert finding.predicted_start is not None
    # Sums of a few logarithms.
    assert finding.confirmed == pytest.approx(finding.predicted.value, abs=1e-9)
    assert finding.start.ratios["y"] == pytest.approx(finding.predicted_start.value, abs=1e-9)
    assert finding.gain == pytest.approx(20 * log10(2) * sum(map(abs, powers)), abs=1e-9)


def test_a_run_is_made_under_every_noise_condition_and_becomes_one_ratio() -> None:
    made = study(evaluate=noisy_product, noise=NOISE)
    assert made.noise_array is not None
    assert made.noise_array.name == "L4"
    for run in made.runs:
        y = product_of_powers(run.setting)["y"]
        expected = [y * o.noise["gain"] + o.noise["offset"] for o in run.outcomes]
        assert sorted({(o.noise["gain"], o.noise["offset"]) for o in run.outcomes}) == [
            (0.9, 0.0),
            (0.9, 0.2),
            (1.1, 0.0),
            (1.1, 0.2),
        ]
        assert [o.values["y"] for o in run.outcomes] == expected
        assert run.ratios["y"] == float(smaller_the_better(expected))
        assert run.mean("y") == pytest.approx(np.mean(expected))


def test_the_analysis_is_that_of_the_ratios_over_the_array() -> None:
    made = study(evaluate=noisy_product, noise=NOISE, pooled=("C",))
    expected = analyse(
        orthogonal_array("L9").levels[:, :3], [run.ratios["y"] for run in made.runs], ["A", "B", "C"], pooled=["C"]
    )
    assert made.array.name == "L9"
    assert made.findings["y"].analysis == expected


def test_the_result_does_not_depend_on_the_number_of_threads() -> None:
    alone, many = (study(evaluate=noisy_product, noise=NOISE, workers=workers).as_dict() for workers in (1, 7))
    assert alone == many


def test_a_larger_array_and_another_ratio_may_be_asked_for() -> None:
    made = study(array="L18", ratio=larger_the_better)
    assert (made.array.name, len(made.runs)) == ("L18", 18)
    best = made.findings["y"].best
    assert best is not None
    assert best.setting == {"A": 4.0, "B": 1.0, "C": 4.0}


def test_factors_that_interact_fail_their_confirmation() -> None:
    # All three at their best are bad together. An L9 holds every pair of levels, but not this triple.
    def experiment(setting: Mapping[str, float]) -> dict[str, float]:
        trap = 100.0 if setting == {"A": 1.0, "B": 4.0, "C": 1.0} else 1.0
        return {"y": product_of_powers(setting)["y"] * trap}

    plain, trapped = study().findings["y"], study(evaluate=experiment).findings["y"]
    assert trapped.analysis == plain.analysis
    assert plain.confirmed is not None
    assert trapped.confirmed == pytest.approx(plain.confirmed - 40.0, abs=1e-9)
    assert trapped.within is False
    assert trapped.gain is not None
    assert trapped.gain < 0


def test_a_diverged_run_is_reported_and_left_out() -> None:
    def experiment(setting: Mapping[str, float]) -> dict[str, float]:
        if setting["A"] == 4.0 and setting["B"] == 1.0 and setting["gain"] == 1.1:
            raise DivergedError("The motion diverged.")
        return product_of_powers(setting)

    made = study(evaluate=experiment, noise=NOISE[:1], pooled=())
    assert made.diverged == (7,)
    run = made.runs[6]
    assert run.setting == {"A": 4.0, "B": 1.0, "C": 4.0}
    # One noise factor of two levels in an L4: two of four conditions.
    assert run.failures == ("The motion diverged.",) * 2
    assert [outcome.values == {} for outcome in run.outcomes] == [o.noise["gain"] == 1.1 for o in run.outcomes]
    assert run.ratios == {}
    assert run.mean("y") is None
    left = made.findings["y"].analysis
    assert left is not None
    assert not left.orthogonal
    assert left.total.degrees_of_freedom == 7
    # What is left is still additive: it has the same effects as the whole.
    whole = study(pooled=()).findings["y"].analysis
    assert whole is not None
    for name in "ABC":
        assert left.effects[name] == pytest.approx(whole.effects[name], abs=1e-9)


def test_a_response_that_is_not_finite_is_a_failure_too() -> None:
    made = study(evaluate=lambda s: {"y": float("nan") if s["A"] == s["B"] == s["C"] == 1.0 else s["A"]})
    assert made.diverged == (1,)
    assert made.runs[0].failures == ("The response y is nan, expected a finite number.",)


def test_where_all_runs_fail_the_study_still_says_so() -> None:
    def experiment(setting: Mapping[str, float]) -> dict[str, float]:
        raise DivergedError("The motion diverged.")

    made = study(evaluate=experiment)
    finding = made.findings["y"]
    assert made.diverged == tuple(range(1, 10))
    assert finding.analysis is None
    assert finding.reason is not None
    assert finding.reason.startswith("9 of 9 runs failed.")
    assert (finding.best, finding.predicted, finding.confirmed, finding.within, finding.gain) == (None,) * 5
    assert json.loads(json.dumps(made.as_dict(), allow_nan=False)) == made.as_dict()


def test_a_confirmation_that_diverges_is_no_gain() -> None:
    def experiment(setting: Mapping[str, float]) -> dict[str, float]:
        if setting == {"A": 1.0, "B": 4.0, "C": 1.0}:
            raise DivergedError("The motion diverged.")
        return product_of_powers(setting)

    finding = study(evaluate=experiment).findings["y"]
    assert finding.best is not None
    assert finding.best.failures == ("The motion diverged.",)
    assert finding.predicted is not None
    assert (finding.confirmed, finding.within, finding.gain) == (None, None, None)


def test_the_study_as_plain_values_holds_what_it_found() -> None:
    made = study(evaluate=noisy_product, noise=NOISE)
    values = json.loads(json.dumps(made.as_dict(), allow_nan=False))
    found = made.findings["y"]
    assert found.analysis is not None
    assert (values["array"], values["noise_array"], len(values["runs"])) == ("L9", "L4", 9)
    assert values["factors"][0] == {"name": "A", "unit": "1", "levels": [1.0, 2.0, 4.0], "start": 2.0}
    response = values["responses"]["y"]
    assert response["confirmed"] == found.confirmed
    assert response["effects"]["A"] == list(found.analysis.effects["A"])
    assert [line["source"] for line in response["variance"]] == ["A", "B", "C", "error", "total"]
    assert response["predicted"]["low"] < response["predicted"]["value"] < response["predicted"]["high"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"responses": []}, r"responses \[\]"),
        ({"factors": [*FACTORS, FACTORS[0]]}, "expected different names"),
        ({"noise": [Factor("A", "1", (0.0, 1.0))]}, "expected different names"),
        ({"factors": []}, "0 factors to arrange"),
        ({"array": "L4"}, "L4 has no free column of 3 levels"),
        ({"pooled": ["Z"]}, r"To be pooled is \['Z'\]"),
        ({"responses": ["z"]}, r"gives \['y'\], and not \['z'\]"),
        ({"evaluate": lambda setting: {"y": -1.0}}, "is -1, expected at least 0"),
    ],
)
def test_a_study_that_cannot_be_made_is_refused(changes: dict[str, object], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        study(**changes)


def test_a_constant_response_has_no_analysis_but_a_reason() -> None:
    finding = study(evaluate=lambda setting: {"y": 2.0}).findings["y"]
    assert finding.analysis is None
    assert finding.reason is not None
    assert "0 of 9 runs failed. The values are not all finite, or all the same" in finding.reason


@pytest.mark.parametrize(
    ("levels", "start", "said"),
    [
        ((1.0,), 0, "expected two or more different numbers"),
        ((1.0, 1.0), 0, "expected two or more different numbers"),
        ((1.0, float("nan")), 0, "expected two or more different numbers"),
        ((1.0, 2.0), 2, "is level 2, expected 0 to 1"),
    ],
)
def test_an_impossible_factor_is_refused(levels: tuple[float, ...], start: int, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        Factor("A", "1", levels, start)
