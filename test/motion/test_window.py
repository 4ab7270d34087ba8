"""Force statistics over stretches of time."""

from dataclasses import astuple
from math import isnan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Inputs, March, Window

forces = st.lists(st.floats(-100, 100), min_size=0, max_size=20)


def window_of(samples: list[float]) -> Window:
    """Return the window of forces held for half a unit of time each; zero force counts as separated."""
    window = Window()
    for f in samples:
        window = window.merged(Window(0.5, 0.5 * f, 0.5 * f * f, f, f, 0.5 * (f == 0)))
    return window


@given(forces, forces)
def test_merged_windows_are_the_window_of_all_samples(first: list[float], second: list[float]) -> None:
    merged = window_of(first).merged(window_of(second))
    assert astuple(merged) == pytest.approx(astuple(window_of(first + second)), rel=1e-9, abs=1e-9)
    samples = np.array(first + second)
    if len(samples):
        assert merged.mean == pytest.approx(samples.mean(), abs=1e-9)
        assert merged.rms == pytest.approx(np.sqrt(np.mean(samples**2)), rel=1e-9, abs=1e-9)
        assert (merged.minimum, merged.maximum) == (samples.min(), samples.max())
        assert merged.contact_loss == pytest.approx(np.mean(samples == 0), abs=1e-12)


@given(forces)
def test_an_empty_window_changes_nothing(samples: list[float]) -> None:
    window = window_of(samples)
    assert window.merged(Window()) == window
    assert Window().merged(window) == window


def test_an_empty_window_has_no_mean() -> None:
    assert all(isnan(v) for v in (Window().mean, Window().rms, Window().contact_loss))


def test_constant_force_is_mean_extremes_and_rms_alike(conservative: GearTrain) -> None:
    march, inputs = March(conservative, load=600.0), Inputs(0.5, 600.0)
    force = march.meshes(0.5)[:, 2]
    for window, expected in zip(march.advance((0.0, inputs), (100.0, inputs)), force, strict=True):
        found = (window.mean, window.rms, window.minimum, window.maximum)
        assert found == pytest.approx([expected] * 4, rel=1e-9)
        assert window.contact_loss == 0


def test_teeth_without_load_float_and_are_out_of_contact_all_the_time(conservative: GearTrain) -> None:
    march, inputs = March(conservative, load=0.0), Inputs(0.5, 0.0)
    for window in march.advance((0.0, inputs), (100.0, inputs)):
        assert window.contact_loss == 1
        assert (window.mean, window.minimum, window.maximum) == (0, 0, 0)


def test_windows_cover_the_time_marched(train: GearTrain) -> None:
    march = March(train, load=600.0)
    first, second = march.advance((0.0, Inputs(0.2, 600.0)), (77.0, Inputs(1.9, 100.0)))
    assert first.duration == pytest.approx(march.tau, rel=1e-12)
    assert second.duration == first.duration
    assert 77.0 <= march.tau < 77.1


def test_mean_square_and_mean_are_integrals_over_the_steps(train: GearTrain) -> None:
    march, inputs = March(train, load=60.0), Inputs(0.9, 60.0)
    h = 2 * np.pi / 0.9 / march.steps_per_period
    found = []
    for n in range(1, 400):
        found.append(march.meshes(0.9)[0])
        march.advance((march.tau, inputs), ((n - 0.5) * h, inputs))
    samples = np.array(found)
    march.restart(60.0)
    window, _ = march.advance((0.0, inputs), (398.5 * h, inputs))
    assert window.mean == pytest.approx(samples[:, 2].mean(), rel=1e-9)
    assert window.rms == pytest.approx(np.sqrt((samples[:, 2] ** 2).mean()), rel=1e-9)
    assert window.contact_loss == pytest.approx(1 - samples[:, 3].mean(), rel=1e-9)
    assert 0 < window.contact_loss < 1
