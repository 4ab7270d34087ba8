"""Identification: observables and the model's against closed forms, the fit's intervals against known truth."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import OperatingPoint, System, load_system
from seat_gear_dynamics.studies.identification import identify as identification
from seat_gear_dynamics.studies.identification import waveform
from seat_gear_dynamics.studies.identification.confidence import confidence, partners
from seat_gear_dynamics.studies.identification.describe import described, lines, values
from seat_gear_dynamics.studies.identification.fit import Problem, Solution, solve
from seat_gear_dynamics.studies.identification.identify import FLOOR, Fitted, identify
from seat_gear_dynamics.studies.identification.model_observables import Drives, Predicted, predict
from seat_gear_dynamics.studies.identification.observables import Dwell, observe, statistics
from seat_gear_dynamics.studies.identification.parameters import PARAMETERS, Candidate, chosen
from seat_gear_dynamics.studies.identification.synthetic import synthetic_dwells
from seat_gear_dynamics.studies.identification.waveform import Sensor

Array = NDArray[np.float64]
TEETH = 17
SPEED = 60.0


def cosine(seconds: float = 4.0, rate: float = 2000.0, noise: float = 0.0, seed: int = 1) -> Dwell:
    """A force of mean 100, 20 at the mesh order and 5 at its double, at an unknown phase."""
    time = np.arange(int(seconds * rate)) / rate
    random = np.random.default_rng(seed)
    angle = SPEED * time + random.uniform(0, 2 * np.pi)
    value = 100 + 20 * np.cos(TEETH * angle) + 5 * np.sin(2 * TEETH * angle + 1)
    return Dwell(SPEED, 300.0, time, angle, value + noise * random.standard_normal(len(time)))


def test_observables_of_a_known_force() -> None:
    found = observe(cosine(noise=2.0), TEETH)
    by_name = dict(zip(found.names, found.value, strict=True))
    error = dict(zip(found.names, found.standard_error, strict=True))
    expected = {"mean": 100.0, "spread": np.sqrt(20**2 / 2 + 5**2 / 2 + 2**2), "order 1": 20.0, "order 2": 5.0}
    for name, value in expected.items():
        # Five standard errors of ten parts: Student's t with 9 degrees passes them once in a thousand draws. The last
        # part of a period and blocks cut by it move the mean by 20/(2π·650) at most.
        assert abs(by_name[name] - value) < 5 * error[name] + 0.01, name
    assert found.regular == pytest.approx(1 - 4 / (4 + 212.5), abs=0.01)  # noise is 4 of the variance


def test_the_standard_error_is_that_of_repeated_records() -> None:
    """What the jackknife says of one record is what other records show: the mean of white noise has σ/√n."""
    found = [observe(cosine(noise=8.0, seed=seed), TEETH) for seed in range(30)]
    for k, name in enumerate(found[0].names):
        across = np.std([o.value[k] for o in found], ddof=1)
        # 30 records give a standard deviation to 13 %, ten parts give each record's to 24 %, averaged over 30 to 4 %;
        # three times their sum. The jackknife of a quantile is no better than that (Künsch 1989).
        assert np.mean([o.standard_error[k] for o in found]) == pytest.approx(across, rel=0.5), name


def test_slow_sampling_leaves_the_orders_out_and_keeps_the_statistics() -> None:
    found = observe(cosine(seconds=40.0, rate=50.3), TEETH)
    assert found.names == ("mean", "spread", "low", "high")
    assert np.isnan(found.regular)
    # 2012 samples of an irrational rate fill the phases evenly: to 1/2012 of the range of 50.
    assert found.value[1] == pytest.approx(np.sqrt(212.5), rel=0.01)


@given(offset=st.floats(-1e3, 1e3), scale=st.floats(0.1, 100.0))
def test_observables_follow_offset_and_scale(offset: float, scale: float) -> None:
    dwell = cosine(seconds=1.0)
    one, other = observe(dwell, TEETH), observe(replace(dwell, value=offset + scale * dwell.value), TEETH)
    shifted = offset * np.array([name in ("mean", "low", "high") for name in one.names])
    # Rounding of sums of 2000 numbers of up to 1e4.
    np.testing.assert_allclose(other.value, shifted + scale * one.value, rtol=1e-9, atol=1e-7)


def test_senseless_dwells_are_refused() -> None:
    dwell = cosine(seconds=1.0)
    broken = dwell.value.copy()
    broken[7] = np.nan
    with pytest.raises(ValueError, match="Sample 7 of the dwell"):
        observe(replace(dwell, value=broken), TEETH)
    with pytest.raises(ValueError, match="at least 50"):
        observe(Dwell(1.0, 1.0, dwell.time[:20], dwell.angle[:20], dwell.value[:20]), TEETH)
    with pytest.raises(ValueError, match="at least 50"):
        observe(Dwell(1.0, 1.0, np.empty(0), np.empty(0), np.empty(0)), TEETH)
    with pytest.raises(ValueError, match="stands still"):
        observe(replace(dwell, angle=np.zeros(len(dwell.time))), TEETH)


def linear_response(system: System, output: Callable[[float, Array], float]) -> complex:
    """First harmonic of `output` in contact, by the frequency response of the plain right-hand side.

    In contact the right-hand side of a train of constant stiffness is affine in the state, so a difference of two
    states gives its matrix to rounding.
    """
    omega = system.operating_point.frequency
    rest = system.static_state()
    step = np.eye(24) * 1e-3
    base = system.derivative(0.0, rest)
    matrix = np.column_stack([(system.derivative(0.0, rest + s) - base) / 1e-3 for s in step])
    times = np.arange(64) / 64 * 2 * np.pi / omega
    turning = np.exp(-1j * omega * times)
    forcing = 2 / 64 * np.array([system.derivative(t, rest) for t in times]).T @ turning
    state = np.linalg.solve(1j * omega * np.eye(24) - matrix, forcing)
    slope = np.array([(output(0.0, rest + s) - output(0.0, rest)) / 1e-3 for s in step])
    return complex(slope @ state + 2 / 64 * np.array([output(t, rest) for t in times]) @ turning)


@pytest.fixture
def gentle(make_train: Callable[..., GearTrain], steady: Callable[[GearTrain], GearTrain]) -> GearTrain:
    """A train of constant stiffness and one small harmonic of error: its teeth never part."""
    return steady(make_train({"*.error_amplitude": [0.1], "*.error_phase": [0.4]}))


@pytest.mark.parametrize("kind", ["force", "acceleration"])
def test_the_models_first_order_is_the_linear_frequency_response(gentle: GearTrain, kind: str) -> None:
    speed, load = gentle.speed(0.6), 600.0
    system = System(gentle, OperatingPoint(0.6, load))
    c = system.coefficients

    def force(t: float, state: Array) -> float:
        return float(system.mesh_forces(t, state)[0]) * c.force_unit

    def acceleration(t: float, state: Array) -> float:
        rates = system.derivative(t, state)[12:14]
        return float(rates @ c.direction[:2]) * c.length_unit * gentle.model.time_scale**2

    expected = abs(linear_response(system, force if kind == "force" else acceleration))
    drives = Drives(np.array([speed]), np.array([load]), (2,))
    found = predict([Candidate(gentle)], drives, Sensor(kind))[0]
    assert found.regular.all()
    # The march's step errs by 1e-5 (waveform.STEPS), the slowest support motion has died away to e^-13 by 400 periods.
    assert found.value[4] == pytest.approx(expected, rel=2e-4)
    assert found.value[5] < 1e-3 * expected  # a linear motion has no second order
    assert found.value[1] == pytest.approx(expected / np.sqrt(2), rel=2e-4)


def test_noise_widens_the_models_statistics_as_it_does_a_record(gentle: GearTrain) -> None:
    drives = Drives(np.array([gentle.speed(0.6)]), np.array([600.0]), (1,))
    quiet, noisy = predict([Candidate(gentle), Candidate(gentle, 5.0)], drives, Sensor())
    wave = np.cos(np.linspace(0, 2 * np.pi, 20_001)[:-1])
    drawn = quiet.value[4] * wave + 5 * np.random.default_rng(3).standard_normal(20_000)
    expected = statistics(drawn) + np.array([quiet.value[0], 0, quiet.value[0], quiet.value[0]])
    # A quantile of 20 000 draws errs by about 0.1 of the noise, 15 nodes in place of a normal curve by 0.05.
    np.testing.assert_allclose(noisy.value[:4], expected, atol=0.75)


def test_golden_observables(train: GearTrain) -> None:
    drives = Drives(np.array([600 * RPM]), np.array([400.0]), (3,))
    found = predict([Candidate(train)], drives, Sensor())[0]
    expected = [376.747132, 335.813845, -23.678509, 971.433041, 65.292695, 445.826108, 112.71273]
    assert found.regular.all()
    # Printed to six decimals; rounding of a periodic motion dies away.
    np.testing.assert_allclose(found.value, expected, rtol=1e-6)


def straight(design: Array, truth: Array, deviation: float, seed: int) -> tuple[Solution, Problem]:
    """A fit of a model linear in its coordinates to noisy numbers."""
    noise = deviation * np.random.default_rng(seed).standard_normal(len(design))
    count, free = design.shape
    bounds = np.full(free, 10.0)
    problem = Problem(design @ truth + noise, np.eye(count) / deviation, -bounds, bounds)
    found = solve(lambda x: x @ design.T, problem, np.zeros(free), reach=np.ones(free), seed=1, searches=1)
    return found, problem


DESIGN = np.random.default_rng(5).standard_normal((24, 2))
DWELL = np.repeat(np.arange(8.0), 3)


def test_a_linear_model_gives_the_normal_equations_solution() -> None:
    found, problem = straight(DESIGN, np.array([0.3, -0.2]), 0.05, seed=2)
    expected = np.linalg.lstsq(DESIGN, problem.measured, rcond=None)[0]
    # Softened squares weigh a residual of one standard error by 3 %, so the two estimates differ by some per cent of
    # their own error of 0.05/√24.
    np.testing.assert_allclose(found.x, expected, atol=0.2 * 0.05 / np.sqrt(24))
    np.testing.assert_allclose(found.jacobian, DESIGN / 0.05, rtol=1e-9)


def test_intervals_cover_the_truth_as_often_as_they_say() -> None:
    truth, trials, covered = np.array([0.3, -0.2]), 200, np.zeros(2)
    for seed in range(trials):
        found, problem = straight(DESIGN, truth, 0.05, seed)
        sure = confidence(found, problem, DWELL, seed=1)
        covered += np.abs(found.x - truth) < sure.half_width
    # 95 % of 200 trials, give or take three binomial standard deviations of 1.54 %.
    assert (np.abs(covered / trials - 0.95) < 3 * 0.0154).all(), covered


def test_the_bootstrap_agrees_where_errors_are_as_stated() -> None:
    ratios = []
    for seed in range(20):
        found, problem = straight(DESIGN, np.array([0.3, -0.2]), 0.05, seed)
        sure = confidence(found, problem, DWELL, seed=1)
        ratios.append(np.diff(sure.bootstrap, axis=1)[:, 0] / (2 * sure.half_width))
    # Percentile intervals of eight dwells are too short by √(7/8) and by z/t, and vary by a quarter from fit to fit.
    assert 0.7 < np.mean(ratios) < 1.2


def test_what_nothing_depends_on_is_not_identified() -> None:
    found, problem = straight(np.column_stack([DESIGN[:, 0], np.zeros(24)]), np.array([0.3, 0.1]), 0.05, seed=1)
    sure = confidence(found, problem, DWELL, seed=1)
    assert sure.identified.tolist() == [True, False]
    assert np.isinf(sure.half_width[1])
    assert np.isinf(sure.condition)


def test_two_that_act_alike_are_told_as_a_pair() -> None:
    alike = np.column_stack([DESIGN[:, 0], DESIGN[:, 0] + 1e-4 * DESIGN[:, 1]])
    found, problem = straight(alike, np.array([0.3, 0.1]), 0.05, seed=1)
    sure = confidence(found, problem, DWELL, seed=1)
    assert not sure.identified.any()
    assert partners(sure, ["a", "b"], 0) == ["b"]
    assert sure.correlation[0, 1] < -0.9


def test_what_rests_on_one_dwell_is_not_identified() -> None:
    design = DESIGN.copy()
    design[DWELL > 0, 1] = 0.0
    found, problem = straight(design, np.array([0.3, 0.1]), 0.01, seed=1)
    sure = confidence(found, problem, DWELL, seed=1)
    assert sure.half_width[1] < 0.2
    assert sure.identified.tolist() == [True, False]


def test_fewer_observables_than_parameters_are_refused() -> None:
    with pytest.raises(ValueError, match="1 observables for 2 free"):
        straight(DESIGN[:1], np.zeros(2), 0.05, seed=1)


CALM = [(speed * RPM, load) for speed in (250, 400, 550) for load in (300.0, 600.0)]


@pytest.fixture(scope="module")
def fitted(train: GearTrain) -> tuple[Candidate, Fitted]:
    """A record of another machine than the one that the fit starts from, and the fit."""
    truth = Candidate(train).with_values(["time_scale", "damping", "stiffness"], [1950.0, 0.085, 2.4e8])
    dwells = synthetic_dwells(truth.train, CALM, Sensor(), seconds=1.5, noise=1.0, seed=4)
    free = ("time_scale", "damping", "stiffness", "backlash")
    return truth, identify(train, dwells, Sensor(), free=free, noise=1.0, candidates=6, searches=1)


def test_the_truth_lies_in_the_intervals(fitted: tuple[Candidate, Fitted]) -> None:
    truth, found = fitted
    for each in found.estimates[:3]:
        assert each.interval is not None, each.parameter.name
        low, high = each.interval
        true = truth.value(each.parameter.name)
        # 95 % intervals of three parameters miss one in seven records: twice the width misses one in ten thousand.
        assert low * low / each.value < true < high * high / each.value, (each.parameter.name, each.interval, true)
        assert high / low < 1.1, each.parameter.name


def test_backlash_is_not_invented_where_teeth_keep_one_flank(fitted: tuple[Candidate, Fitted]) -> None:
    backlash = fitted[1].estimates[3]
    assert backlash.interval is None
    assert backlash.bootstrap is None
    assert backlash.held
    assert backlash.value == backlash.start
    assert "backlash" in values(fitted[1])["not_identified"]
    assert any("backlash" in line and "not identified" in line for line in lines(fitted[1]))


def test_the_fitted_description_opens_and_carries_the_values(
    fitted: tuple[Candidate, Fitted], train: GearTrain, tmp_path: Path
) -> None:
    found = fitted[1]
    path = tmp_path / "fitted.yaml"
    for text in (train.text, (Path(__file__).parents[2] / "config" / "height_adjuster.yaml").read_text()):
        path.write_text(described(text, found))
        opened = load_system(path).train
        assert opened.model.time_scale == pytest.approx(found.train.model.time_scale, rel=1e-5)
        mesh = found.train.meshes[0]
        assert opened.meshes[0].mean_stiffness == pytest.approx(mesh.mean_stiffness, rel=1e-5)
        assert opened.meshes[0].damping_ratio == pytest.approx(mesh.damping_ratio, rel=1e-5)
        assert opened.meshes[1].damping_ratio == 0.07
        assert opened.provenance["model.time_scale"].kind == "calibrated"
        assert opened.provenance["meshes.s1_s2.backlash"].kind == "given"


def test_the_table_holds_every_observable(fitted: tuple[Candidate, Fitted]) -> None:
    found = fitted[1]
    table = found.table()
    assert {len(column.values) for column in table} == {sum(len(o.value) for o in found.observed)}
    assert table.column("speed_rpm").title == "speed_rpm [r/min]"
    assert table.column("after").title == "after [N]"
    assert [table.column(name).values[0] for name in ("speed_rpm", "load")] == pytest.approx([250.0, 300.0])
    assert table.column("observable").values[0] == "mean"
    measured, before, after = (np.array(table.column(name).values) for name in ("measured", "before", "after"))
    assert np.abs(after - measured).max() < 0.2 * np.abs(before - measured).max()


def test_too_little_is_refused_in_a_sentence(train: GearTrain) -> None:
    dwells = synthetic_dwells(train, CALM[:2], Sensor(), seconds=0.5)
    with pytest.raises(ValueError, match=r"There are 2 dwells .* expected at least 3"):
        identify(train, dwells, Sensor())
    with pytest.raises(ValueError, match="There are 0 dwells"):
        identify(train, [], Sensor())
    with pytest.raises(ValueError, match="noise is nan"):
        identify(train, [*dwells, *dwells], Sensor(), noise=float("nan"))


def test_parameters_are_asked_for_by_their_names() -> None:
    assert [p.name for p in chosen(("damping", "backlash"))] == ["damping", "backlash"]
    with pytest.raises(ValueError, match="'mass' is unknown"):
        chosen(("mass",))
    with pytest.raises(ValueError, match="each once"):
        chosen(("damping", "damping"))
    with pytest.raises(ValueError, match="none"):
        chosen(())
    with pytest.raises(ValueError, match="'torque', expected one of force"):
        Sensor("torque")


@pytest.mark.parametrize("name", list(PARAMETERS))
def test_every_parameter_is_set_and_read_back(train: GearTrain, name: str) -> None:
    parameter = PARAMETERS[name]
    value = float(np.sqrt(parameter.low * parameter.high))
    changed = Candidate(train).with_values([name], [value])
    assert changed.value(name) == pytest.approx(value)
    assert changed.train.meshes[1] == train.meshes[1]


def tight(make_train: Callable[..., GearTrain]) -> GearTrain:
    """A mesh as tight as its transmission error, which closes on both flanks in every dwell."""
    return make_train({"*.error_amplitude": [4.4], "*.error_phase": [0.4], "meshes.*.backlash": 4.0})


@pytest.mark.parametrize(("beside", "value"), [("damping", 0.08), ("stiffness", 2.25e8)])
def test_backlash_and_another_are_told_together_where_both_flanks_are_hit(
    make_train: Callable[..., GearTrain], beside: str, value: float
) -> None:
    before = tight(make_train)
    names = ("backlash", beside)
    truth = Candidate(before).with_values(names, [4.3e-6, value])
    drives = [(speed * RPM, 60.0) for speed in (500, 600, 700, 800, 900)]
    # A rate that is no whole ratio of a mesh frequency: quantiles see every phase.
    dwells = synthetic_dwells(truth.train, drives, Sensor(), seconds=1.2, rate=2003.7, noise=1.0)
    assert all(dwell.value.min() < 0 < dwell.value.max() for dwell in dwells)
    found = identify(before, dwells, Sensor(), free=names, noise=1.0, candidates=4, searches=1)
    for each in found.estimates:
        assert each.interval is not None, each.parameter.name
        low, high = each.interval
        # 95 % intervals as they are, of a record that its seed fixes; the floor makes them wide for so little noise.
        assert low < truth.value(each.parameter.name) < high, (each.parameter.name, each.interval)
        assert high / low < 1.15, each.parameter.name


def test_an_impacts_quantiles_do_not_depend_on_where_the_samples_fall(
    make_train: Callable[..., GearTrain], monkeypatch: pytest.MonkeyPatch
) -> None:
    """An impulse that wanders between samples must not look like a change of force: the fit would follow it."""
    before = Candidate(tight(make_train))
    asked = [before.with_values(["backlash"], [value]) for value in np.linspace(4.07e-6, 4.3e-6, 12)]
    drives = Drives(np.array([500 * RPM]), np.array([60.0]), (0,))
    found = [np.array([each.value for each in predict(asked, drives, Sensor())])]
    monkeypatch.setattr(waveform, "FINER", waveform.FINER + 2)
    found.append(np.array([each.value for each in predict(asked, drives, Sensor())]))
    # A fifth of what is added to every error, so that it bends no fit; 68 samples a period err by 2.8 times it.
    np.testing.assert_allclose(found[0], found[1], atol=0.2 * FLOOR * np.abs(found[1]).max())


def test_a_searchs_steps_are_told_up_to_the_end() -> None:
    told: list[tuple[int, int]] = []
    problem = Problem(DESIGN @ np.array([0.3, -0.2]), np.eye(24), np.full(2, -10.0), np.full(2, 10.0))
    solve(
        lambda x: x @ DESIGN.T, problem, np.zeros(2), reach=np.ones(2), seed=1, candidates=4, searches=2,
        progress=lambda *given: told.append(given),
    )  # fmt: skip
    assert told == sorted(told)
    assert told[0] == (0, told[-1][1])
    assert told[-1][0] == told[-1][1]
    assert len(told) > 3


def test_a_dwell_that_follows_the_fit_into_chaos_is_left_out_for_good(
    train: GearTrain, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its motion is regular where the other dwells put the damping, and irregular where it pulls it to itself."""
    time = np.arange(4000) / 2000
    dwells = [Dwell(SPEED, load, time, SPEED * time, 100 + 100 * np.cos(TEETH * SPEED * time)) for load in range(1, 6)]
    shape = observe(dwells[0], TEETH).value

    def model(candidates: list[Candidate], drives: Drives, sensor: Sensor) -> list[Predicted]:
        said = []
        for each in candidates:
            damping = each.value("damping")
            value = np.tile(shape * 0.085 / damping, (5, 1))
            value[2] *= 1.02
            said.append(Predicted(value.ravel(), np.array([True, True, damping < 0.0852, True, True])))
        return said

    monkeypatch.setattr(identification, "predict", model)
    found = identify(train, dwells, Sensor(), free=("damping",), searches=1)
    assert found.left_out == ("", "", "irregular in the model", "", "")
    # The other four agree exactly; the search ends at a relative change of 1e-5.
    assert found.estimates[0].value == pytest.approx(0.085, rel=1e-4)
