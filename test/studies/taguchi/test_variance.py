"""Analysis of variance: two textbooks, SciPy's one-way analysis, and the laws of the additive model."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import f as f_distribution
from scipy.stats import f_oneway

from seat_gear_dynamics.studies.taguchi import Analysis, analyse, orthogonal_array, weakest_factors

# Yang & El-Haik, Design for Six Sigma: A Roadmap for Product Development (2003), Example 13.11, p. 484-485: porosity of
# moulded bumpers, L8 with two measurements a run, and the analysis of variance the book prints.
# https://digilib.universitaspertamina.ac.id/ebook/Design%20for%20Six%20Sigma%20:%20a%20Roadmap%20for%20Product%20Development/files/basic-html/page525.html
POROSITY = [26, 38, 16, 6, 3, 17, 18, 16, 0, 5, 0, 1, 4, 5, 5, 3]
POROSITY_TABLE = {
    "A": (855.56, 28.82, 0.001, 49.44),
    "B": (27.56, 0.93, 0.363, 1.59),
    "AB": (115.56, 3.89, 0.084, 6.68),
    "D": (68.06, 2.29, 0.168, 3.93),
    "E": (33.06, 1.11, 0.322, 1.91),
    "BD": (217.56, 7.33, 0.027, 12.57),
    "G": (175.56, 5.91, 0.041, 10.15),
}
# The same book, Example 13.12, p. 486, 487 and 491 (after Park 1996): soybean yield, L9, its third column empty.
# https://digilib.universitaspertamina.ac.id/ebook/Design%20for%20Six%20Sigma%20:%20a%20Roadmap%20for%20Product%20Development/files/basic-html/page527.html
YIELD = [8, 12, 9, 11, 12, 15, 21, 18, 20]
YIELD_COLUMNS = [0, 1, 3]
# Phadke, Quality Engineering Using Robust Design (1989), chapter 3: surface defects of polysilicon, S/N ratios in dB of
# an L9; the data also in J. Nahas, Statistical Design of Experiments, part II, slides 7 and 8.
# https://vdocuments.us/statistical-design-of-jnahasdoeiicvdexamplev2pdftaguchi-l9-3-4-3-fractional.html
DEFECTS = [-20, -10, -30, -25, -45, -65, -45, -65, -70]
DEFECT_FACTORS = ["temperature", "pressure", "settling time", "cleaning method"]


@pytest.fixture
def porosity() -> Analysis:
    return analyse(np.repeat(orthogonal_array("L8").levels, 2, axis=0), POROSITY, list(POROSITY_TABLE))


@pytest.fixture
def defects() -> Analysis:
    return analyse(orthogonal_array("L9").levels, DEFECTS, DEFECT_FACTORS)


@pytest.mark.parametrize("name", POROSITY_TABLE)
def test_the_porosity_table_of_yang_and_el_haik_is_reproduced(porosity: Analysis, name: str) -> None:
    source = next(source for source in porosity.factors if source.name == name)
    squares, f, p, percent = POROSITY_TABLE[name]
    # Within half a unit of the last printed digit. Shares come from printed sums: a unit there.
    assert source.sum_of_squares == pytest.approx(squares, abs=0.005)
    assert source.f == pytest.approx(f, abs=0.005)
    assert source.p == pytest.approx(p, abs=0.0005)
    assert 100 * source.contribution == pytest.approx(percent, abs=0.01)


def test_error_and_total_of_the_porosity_table_are_reproduced(porosity: Analysis) -> None:
    assert (porosity.error.degrees_of_freedom, porosity.total.degrees_of_freedom) == (8, 15)
    assert porosity.error.sum_of_squares == pytest.approx(237.50, abs=0.005)
    assert porosity.error.mean_square == pytest.approx(29.69, abs=0.005)
    assert porosity.total.sum_of_squares == pytest.approx(1730.44, abs=0.005)
    assert 100 * porosity.error.contribution == pytest.approx(13.72, abs=0.01)
    assert porosity.mean == pytest.approx(10.188, abs=0.0005)


def test_the_l9_example_of_yang_and_el_haik_is_reproduced() -> None:
    analysis = analyse(orthogonal_array("L9").levels[:, YIELD_COLUMNS], YIELD, ["A", "B", "C"])
    squares = [source.sum_of_squares for source in (*analysis.factors, analysis.error, analysis.total)]
    assert squares == pytest.approx([158.0, 2.667, 18.667, 0.667, 180.0], abs=0.0005)
    assert [100 * s.contribution for s in analysis.factors] == pytest.approx([87.78, 1.48, 10.37], abs=0.005)
    # The book takes A at level 3 and C at level 2, leaves B out, and predicts 19.67 + 16 − 14 = 21.67.
    pooled = analyse(orthogonal_array("L9").levels[:, YIELD_COLUMNS], YIELD, ["A", "B", "C"], pooled=["B"])
    assert (pooled.best_levels["A"], pooled.best_levels["C"]) == (2, 1)
    assert pooled.predict(pooled.best_levels).value == pytest.approx(21.67, abs=0.005)


def test_the_effects_of_phadkes_example_are_the_means_by_hand(defects: Analysis) -> None:
    assert defects.mean == pytest.approx(-375 / 9)
    assert defects.effects["temperature"] == pytest.approx((-20, -45, -60))
    assert defects.effects["pressure"] == pytest.approx((-30, -40, -55))
    assert defects.effects["settling time"] == pytest.approx((-50, -35, -40))
    assert defects.effects["cleaning method"] == pytest.approx((-45, -40, -40))


def test_a_saturated_array_has_no_error_and_tests_nothing(defects: Analysis) -> None:
    assert [source.sum_of_squares for source in defects.factors] == pytest.approx([2450, 950, 350, 50])
    assert defects.error.degrees_of_freedom == 0
    assert defects.error.mean_square is None
    assert all(source.f is None and source.p is None for source in defects.factors)
    prediction = defects.predict(defects.best_levels)
    assert prediction.interval is None
    assert prediction.contains(0.0) is None


def test_pooling_the_weaker_half_of_phadkes_example(defects: Analysis) -> None:
    # By hand from the sums of squares: error (350 + 50)/4 = 100, so F = 1225/100 and 475/100; optimum
    # −20 − 30 + 41.67; variance of prediction 100·(1/9 + 2·(1/3 − 1/9) + 1/4) for four repeats of the optimum.
    assert weakest_factors(defects) == ("settling time", "cleaning method")
    pooled = analyse(orthogonal_array("L9").levels, DEFECTS, DEFECT_FACTORS, pooled=weakest_factors(defects))
    assert pooled.error.sum_of_squares == pytest.approx(400)
    assert pooled.error.degrees_of_freedom == 4
    assert [source.f for source in pooled.factors] == [pytest.approx(12.25), pytest.approx(4.75), None, None]
    assert [source.net_contribution for source in pooled.factors[:2]] == pytest.approx([2250 / 3800, 750 / 3800])
    prediction = pooled.predict({**pooled.best_levels}, runs=4)
    assert prediction.value == pytest.approx(-25 / 3)
    assert prediction.standard_error is not None
    assert prediction.standard_error**2 == pytest.approx(100 * (5 / 9 + 1 / 4))


def test_one_factor_is_scipys_one_way_analysis() -> None:
    groups = np.random.default_rng(1).normal([[1.0], [1.4], [2.0]], 0.5, (3, 6))
    analysis = analyse(np.repeat([[0], [1], [2]], 6, axis=0), groups.ravel(), ["A"])
    expected = f_oneway(*groups)
    assert analysis.factors[0].f == pytest.approx(float(expected.statistic), rel=1e-10)
    assert analysis.factors[0].p == pytest.approx(float(expected.pvalue), rel=1e-10)


@settings(max_examples=40)
@given(st.sampled_from(["L8", "L9", "L18", "L27"]), st.integers(0, 2**32 - 1))
def test_sums_of_squares_of_an_orthogonal_array_add_up(name: str, seed: int) -> None:
    levels = orthogonal_array(name).levels
    names = [f"factor {i}" for i in range(levels.shape[1] - 1)]
    analysis = analyse(levels[:, :-1], np.random.default_rng(seed).normal(size=len(levels)), names)
    assert analysis.orthogonal
    parts = [*analysis.factors, analysis.error]
    # A few dozen sums of rounded squares.
    assert sum(s.sum_of_squares for s in parts) == pytest.approx(analysis.total.sum_of_squares, rel=1e-10)
    assert sum(s.degrees_of_freedom for s in parts) == analysis.total.degrees_of_freedom
    assert all(np.mean(means) == pytest.approx(analysis.mean, abs=1e-10) for means in analysis.effects.values())


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(0, 3))
def test_additive_values_are_recovered_with_and_without_missing_runs(seed: int, missing: int) -> None:
    # Four factors of an L18 leave nine runs more than means; without three of them, any three, all means stay
    # determined, because each level keeps three runs of the six.
    rng = np.random.default_rng(seed)
    design, names = orthogonal_array("L18").levels[:, 1:5], ["A", "B", "C", "D"]
    effects = rng.normal(size=(4, 3))
    effects -= effects.mean(axis=1, keepdims=True)
    values = 7.0 + sum(effects[i][design[:, i]] for i in range(4))
    kept = np.sort(rng.permutation(18)[missing:])
    analysis = analyse(design[kept], values[kept], names, level_counts=[3] * 4)
    assert analysis.orthogonal == (missing == 0)
    assert analysis.mean == pytest.approx(7.0, abs=1e-10)
    for i, name in enumerate(names):
        assert analysis.effects[name] == pytest.approx(7.0 + effects[i], abs=1e-10)
    best = {name: int(np.argmax(effects[i])) for i, name in enumerate(names)}
    assert analysis.best_levels == best
    assert analysis.predict(best).value == pytest.approx(7.0 + effects.max(axis=1).sum(), abs=1e-10)


def test_the_interval_is_ross_s_with_the_effective_number_of_runs() -> None:
    # Ross, Taguchi Techniques for Quality Engineering (1988): ± sqrt(F(α; 1, ν)·V·(1/n_eff + 1/r)), n_eff = N/(1 + Σν).
    values = np.random.default_rng(2).normal(size=18)
    analysis = analyse(orthogonal_array("L18").levels[:, 1:4], values, ["A", "B", "C"], pooled=["B"])
    prediction = analysis.predict({"A": 2, "B": 0, "C": 1}, runs=3, confidence=0.9)
    variance, freedom = analysis.error.mean_square, analysis.error.degrees_of_freedom
    assert variance is not None
    half = np.sqrt(f_distribution.ppf(0.9, 1, freedom) * variance * ((1 + 4) / 18 + 1 / 3))
    assert prediction.interval == pytest.approx((prediction.value - half, prediction.value + half), rel=1e-9)
    assert prediction.contains(prediction.value + 0.99 * half)
    assert not prediction.contains(prediction.value - 1.01 * half)


def test_the_interval_holds_its_confidence_when_the_error_is_normal() -> None:
    rng, design = np.random.default_rng(3), orthogonal_array("L9").levels[:, :2]
    held = 0
    for _ in range(600):
        prediction = analyse(design, rng.normal(size=9), ["A", "B"]).predict({"A": 0, "B": 0}, confidence=0.8)
        held += bool(prediction.contains(rng.normal()))
    # Four standard deviations of a binomial share.
    assert held / 600 == pytest.approx(0.8, abs=4 * np.sqrt(0.8 * 0.2 / 600))


def test_a_factor_pooled_is_a_factor_of_the_error(defects: Analysis) -> None:
    left_out = analyse(orthogonal_array("L9").levels[:, :3], DEFECTS, DEFECT_FACTORS[:3])
    pooled = analyse(orthogonal_array("L9").levels, DEFECTS, DEFECT_FACTORS, pooled=["cleaning method"])
    assert pooled.error.sum_of_squares == pytest.approx(left_out.error.sum_of_squares)
    assert [s.p for s in pooled.factors[:3]] == pytest.approx([s.p for s in left_out.factors])
    assert pooled.pooled == ("cleaning method",)
    assert defects.pooled == ()


def test_weakest_factors_stay_within_their_share(defects: Analysis) -> None:
    assert weakest_factors(defects, share=0.0) == ()
    assert weakest_factors(defects, share=0.3) == ("cleaning method",)
    assert weakest_factors(defects, share=1.0) == tuple(DEFECT_FACTORS)


@pytest.mark.parametrize(
    ("rows", "values", "names", "pooled", "said"),
    [
        ([[0], [1]], [1.0], ["A"], (), r"The design has shape \(2, 1\), the values \(1,\)"),
        (np.empty((0, 1)), [], ["A"], (), r"The design has shape \(0, 1\)"),
        ([[0, 0], [1, 1]], [1.0, 2.0], ["A", "A"], (), "expected different names"),
        ([[0], [1]], [1.0, 2.0], ["A"], ("B",), r"pooled are \['B'\]"),
        ([[0], [1]], [1.0, float("nan")], ["A"], (), "not all finite"),
        ([[0], [1]], [1.0, 1.0], ["A"], (), "all the same"),
        ([[0, 0], [1, 1]], [1.0, 2.0], ["A", "B"], (), "do not determine the 3 means"),
    ],
)
def test_what_cannot_be_analysed_is_refused(
    rows: object, values: list[float], names: list[str], pooled: tuple[str, ...], said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        analyse(np.asarray(rows), values, names, pooled=pooled)


def test_a_level_without_a_run_is_refused() -> None:
    with pytest.raises(ValueError, match="do not determine the 3 means"):
        analyse([[0], [1], [0]], [1.0, 2.0, 3.0], ["A"], level_counts=[3])


@pytest.mark.parametrize("confidence", [0.0, 1.0, 95.0])
def test_an_impossible_confidence_is_refused(defects: Analysis, confidence: float) -> None:
    with pytest.raises(ValueError, match="expected a number between 0 and 1"):
        defects.predict(defects.best_levels, confidence=confidence)
