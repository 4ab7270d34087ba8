"""The nearest calm speed, by brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seat_gear_dynamics.gears import ForbiddenBand
from seat_gear_dynamics.regimes import Regime
from seat_gear_dynamics.sensing import Alarm, AlarmSettings

BANDS = st.lists(st.tuples(st.floats(1, 200), st.floats(0.1, 60)), max_size=4).map(
    lambda pairs: [ForbiddenBand(low, low + width, 600.0) for low, width in pairs]
)


def calm(speed: float | np.ndarray, bands: list[ForbiddenBand], margin: float) -> np.ndarray:
    """Say of each speed whether it is outside every band by the margin."""
    speeds = np.asarray(speed)
    return np.asarray(
        np.all([(speeds <= b.low - margin) | (speeds >= b.high + margin) for b in bands] or [speeds >= 0], axis=0)
    )


@settings(max_examples=200)
@given(BANDS, st.floats(0, 300), st.floats(0, 20), st.floats(10, 300))
def test_calm_speed_is_outside_every_band_by_the_margin_and_none_is_nearer(
    bands: list[ForbiddenBand], magnitude: float, margin: float, covered: float
) -> None:
    found = Alarm(bands, covered_speed=covered, settings=AlarmSettings(margin=margin)).calm_speed(magnitude)
    grid = np.linspace(0, covered, 6001)
    candidates = grid[calm(grid, bands, margin)]
    if found is None:
        assert len(candidates) == 0
        return
    assert 0 <= found <= covered
    assert calm(found, bands, margin)
    if len(candidates):
        assert abs(found - magnitude) <= np.abs(candidates - magnitude).min() + 1e-9


def test_a_calm_speed_is_its_own_nearest() -> None:
    alarm = Alarm([ForbiddenBand(100, 120, 600.0)], covered_speed=200, settings=AlarmSettings(margin=5))
    assert alarm.calm_speed(50.0) == 50.0
    assert alarm.calm_speed(97.0) == 95.0
    assert alarm.calm_speed(109.0) == 95.0
    assert alarm.calm_speed(111.0) == 125.0


def test_beyond_the_studied_range_its_end_is_the_nearest_calm_speed() -> None:
    assert Alarm([], covered_speed=200).calm_speed(300.0) == 200.0


@pytest.mark.parametrize("magnitude", [0.0, 50.0, 300.0])
def test_there_is_none_where_bands_fill_the_studied_range(magnitude: float) -> None:
    assert Alarm([ForbiddenBand(1, 250, 600.0)], covered_speed=200).calm_speed(magnitude) is None


def test_a_speed_at_which_the_drive_rattles_is_not_calm_though_no_band_says_so() -> None:
    alarm = Alarm([ForbiddenBand(100.0, 120.0, 600.0)], covered_speed=300.0, settings=AlarmSettings(margin=5.0))
    assert alarm.calm_speed(90.0) == 90.0
    assert alarm.calm_speed(90.0, rattling=True) in (85.0, 95.0)
    assert alarm.calm_speed(94.0, rattling=True) == 89.0  # upwards lies the band
    verdict = alarm.update(0.0, -94.0, 600.0, Regime("chaotic", None, 0.05, 0.001, "told so"))
    assert verdict.calm_speed == -89.0
