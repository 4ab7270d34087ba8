"""Vibration and impact of P12: by hand, against the linear system solved in frequency, and as a whole study."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Response, System, Window, integrate
from seat_gear_dynamics.motion.coefficients import PER_MESH
from seat_gear_dynamics.studies.taguchi import CONTROLS, NOISE, RESPONSES, Study, experiment, responses_of
from seat_gear_dynamics.studies.taguchi import vibration_and_impact as study_of


def response(train: GearTrain, window: Window) -> Response:
    """A response of which only the windows matter."""
    return Response(System(train), np.empty((0, 2)), np.empty((0, 2)), (window, Window()), np.zeros(24), 1.0)


def named(*names: str) -> list[object]:
    return [variation for variation in (*CONTROLS, *NOISE) if variation.name in names]


@given(st.floats(0.1, 10), st.floats(0, 5), st.sampled_from([-1.0, 1.0]))
def test_a_sine_on_a_mean_has_its_rms_and_its_peak(train: GearTrain, mean: float, share: float, sign: float) -> None:
    amplitude = share * mean
    window = Window(2.0, 2 * sign * mean, 2 * (mean**2 + amplitude**2 / 2), -amplitude, amplitude, 0.5)
    window = replace(window, minimum=sign * mean - amplitude, maximum=sign * mean + amplitude)
    found = responses_of(response(train, window))
    # The rms comes from a difference of squares: half of the digits at worst.
    assert found["vibration"] == pytest.approx(share / sqrt(2), abs=1e-7)
    assert found["overshoot"] == pytest.approx(share, abs=1e-12)
    assert found["contact_loss"] == 0.25
    assert found["impact"] == pytest.approx(1.25 * share, abs=1e-12)


def test_a_mean_force_of_0_is_no_scale(train: GearTrain) -> None:
    with pytest.raises(ValueError, match="mean force of P12 is 0"):
        responses_of(response(train, Window(1.0, 0.0, 1.0, -1.0, 1.0, 0.0)))


def linear_force_amplitude(system: System, amplitude: float) -> float:
    """|F| of P12 per unit of static force, from (M s² + C s + K + …)·q = … at s = iΩ, for a sine error of one harmonic.

    In mass-normalised coordinates q″ + Bq′ + Kq + g·F = 0 and F = (κ + c·s)(w·q − e), so that with the supports'
    receptance H = 1/(s² + Bs + K) the mesh sees F·(1/(κ + cs) + Σ w·H·g) = −e.
    """
    c, own, s = system.coefficients, slice(0, PER_MESH), 1j * system.operating_point.frequency
    receptance = 1 / (s**2 + c.damping[own] * s + c.stiffness[own])
    compliance = 1 / (1 + c.mesh_damping[0] * s) + np.sum(c.direction[own] * receptance * c.reaction[own])
    return float(abs(amplitude / c.length_unit / compliance))


@pytest.mark.parametrize("frequency", [0.4, 0.9, 1.6])
def test_in_contact_at_constant_stiffness_it_is_the_linear_response(
    make_train: Callable[..., GearTrain], steady: Callable[[GearTrain], GearTrain], frequency: float
) -> None:
    # A tenth of a micrometre under a heavy load: teeth never part, and the system is linear.
    train = steady(make_train({"*.error_amplitude": [0.1], "*.error_phase": [0.0], "gears.*.eccentricity": 0}))
    system = System(train).at(frequency=frequency, load=2000.0)
    window = integrate(system, transient=400, periods=20).windows[0]
    found = experiment(system, [], transient=400, periods=20)({})
    expected = linear_force_amplitude(system, 0.1e-6) / window.mean
    assert found["contact_loss"] == 0.0
    # The run-in's remainder and the error of a step of fourth order, found below 3e-7.
    assert found["vibration"] == pytest.approx(expected / sqrt(2), rel=2e-6)
    # The grid meets the peak to within half of one of 272 steps a period.
    assert found["impact"] == pytest.approx(expected, rel=2e-6 + (pi / 272) ** 2 / 2)


def test_a_setting_is_put_into_the_system(train: GearTrain) -> None:
    system = System(train).at(frequency=0.5, load=600.0)
    evaluate = experiment(system, [*CONTROLS, *NOISE], transient=5, periods=5)
    changed = System(train.with_mesh(0, damping_ratio=0.1, backlash=11e-6)).at(frequency=0.5, load=300.0)
    expected = responses_of(integrate(changed, transient=5, periods=5))
    found = evaluate({"damping ratio": 0.1, "backlash": 10.0, "load": 300.0, "backlash tolerance": 1.1})
    # 10 µm by a factor is 11 µm but for rounding.
    assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("load", [600.0, -600.0])
def test_the_initial_gap_moves_the_teeth_apart_on_either_flank(train: GearTrain, load: float) -> None:
    system = System(train).at(frequency=0.5, load=load)
    # At once, in the first part of a period, the teeth are out of contact; from static deflection they are not.
    evaluate = experiment(system, [], transient=0, periods=1)
    assert evaluate({"initial gap": 0.5})["contact_loss"] > evaluate({})["contact_loss"]


def small(system: System, **changes: object) -> Study:
    arguments: dict[str, object] = {
        "controls": named("damping ratio", "load", "speed", "transmission error"),
        "noise": (),
        "pooled": ("damping ratio",),
        "transient": 10,
        "periods": 10,
    }
    return study_of(system, **(arguments | changes))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def study(make_train: Callable[..., GearTrain]) -> Study:
    train = make_train({"gears.*.eccentricity": 0})
    return small(System(train).at(frequency=0.4, load=600.0))


def test_the_study_runs_its_array(study: Study) -> None:
    assert study.array.name == "L9"
    assert study.noise_array is None
    assert [len(run.outcomes) for run in study.runs] == [1] * 9
    assert study.diverged == ()
    assert set(study.findings) == set(RESPONSES)


# Mean and confirmed ratio, dB, then the shares of damping ratio, load, speed and transmission error.
# With four times as many steps vibration's agree to 1e-6 dB and 2e-6, impact's, of a peak, to 5e-3 dB and 5e-4.
GOLDEN = {
    "vibration": [10.986979180769424, 14.885337224526777, 0.08273640786, 0.7537989971, 0.03275264997, 0.1307119451],
    "impact": [3.978969909584287, 7.449468294304475, 0.007700785423, 0.7645574871, 0.002644720949, 0.2250970065],
}


@pytest.mark.parametrize("name", RESPONSES)
def test_the_study_keeps_its_golden_values(study: Study, name: str) -> None:
    finding = study.findings[name]
    assert finding.analysis is not None
    shares = [source.contribution for source in finding.analysis.factors]
    assert [finding.analysis.mean, finding.confirmed, *shares] == pytest.approx(GOLDEN[name], rel=1e-6)


def test_in_contact_at_constant_stiffness_the_ratios_are_those_of_error_over_load(
    make_train: Callable[..., GearTrain], steady: Callable[[GearTrain], GearTrain]
) -> None:
    # A linear system: the dynamic force goes with the error, its ratio to the mean force with error/load. In dB that
    # is a sum of 20·lg of the levels, of which speed takes its own part.
    train = steady(make_train({"*.error_amplitude": [0.1], "*.error_phase": [0.0], "gears.*.eccentricity": 0}))
    made = small(
        System(train).at(frequency=0.5, load=2000.0),
        controls=named("load", "speed", "transmission error"),
        noise=named("error phase"),
        pooled=(),
        transient=60,
    )
    for name in RESPONSES:
        analysis = made.findings[name].analysis
        assert analysis is not None
        steps = 20 * np.log10([0.5, 1.0, 1.5])
        # What 60 periods of run-in leave: found below 5e-5 dB. Four means of it in a prediction.
        assert np.diff(analysis.effects["load"]) == pytest.approx(np.diff(steps), abs=2e-4)
        assert np.diff(analysis.effects["transmission error"]) == pytest.approx(-np.diff(steps), abs=2e-4)
        assert made.findings[name].confirmed == pytest.approx(analysis.predict(analysis.best_levels).value, abs=1e-3)


def test_a_design_that_blows_up_is_an_outcome(train: GearTrain) -> None:
    # Negative damping is what no description allows and what surely diverges.
    controls = named("load", "speed", "transmission error")
    unstable = replace(CONTROLS[0], spread=(-20.0, 1.0, 2.0))
    made = small(System(train).at(frequency=1.0, load=600.0), controls=[unstable, *controls], pooled=None, periods=40)
    assert set(made.diverged) >= {1, 2, 3}
    assert "diverged" in made.runs[0].failures[0]
    assert made.findings["vibration"].analysis is None


def test_another_experiment_may_stand_in(train: GearTrain) -> None:
    def evaluate(setting: Mapping[str, float]) -> dict[str, float]:
        return {"noise": setting["speed"] / setting["load"]}

    made = study_of(System(train), evaluate=evaluate, responses=["noise"], pooled=())
    best = made.findings["noise"].analysis
    assert best is not None
    assert (best.best_levels["speed"], best.best_levels["load"]) == (0, 2)
    # Two factors of seven carry everything; the others are rounding.
    assert {s.name for s in best.factors if s.contribution > 1e-20} == {"speed", "load"}
    assert made.array.name == "L18"
    assert [factor.name for factor in made.factors] == [control.name for control in CONTROLS]
    assert [factor.name for factor in made.noise] == [noise.name for noise in NOISE]


def test_a_load_or_a_frequency_of_0_is_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match="The load is 0 N·m"):
        study_of(System(train).at(load=0.0))
    with pytest.raises(ValueError, match="The frequency is 0"):
        small(System(train).at(frequency=0.0))
