"""Distance and time to bands that stand still and to bands that the load moves."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import ForbiddenBand
from seat_gear_dynamics.sensing.approach import containing, distance, nearest, time_to_band, time_to_moving_band
from seat_gear_dynamics.sensing.bands import Bands

BANDS = (ForbiddenBand(100.0, 110.0, 600.0), ForbiddenBand(150.0, 160.0, 600.0))


class Sliding:
    """One band, 10 rad/s wide, whose low edge is the load in N·m."""

    name = label = "sliding"
    covered_speed = 1000.0
    follows_load = True

    def at(self, load: float) -> Bands:
        return (ForbiddenBand(load, load + 10.0, load),)

    def forbids(self, speed: float, load: float) -> bool:
        return load <= speed <= load + 10.0

    def beyond(self, speed: float, load: float) -> str | None:
        return None

    def probability(self, speed: float, load: float) -> float | None:
        return None


def test_distance_is_negative_inside_and_the_nearest_band_is_found() -> None:
    assert [distance(BANDS[0], v) for v in (90.0, 100.0, 104.0, 120.0)] == [10.0, 0.0, -4.0, 10.0]
    assert nearest(BANDS, 120.0) is BANDS[0]
    assert nearest((), 120.0) is None
    assert containing(BANDS, 112.0) is None
    assert containing(BANDS, 112.0, slack=2.0) is BANDS[0]


def test_time_is_gap_over_speed_and_none_when_moving_away() -> None:
    assert time_to_band(BANDS, 90.0, 20.0) == pytest.approx(0.5)
    assert time_to_band(BANDS, 120.0, -20.0) == pytest.approx(0.5)
    assert time_to_band(BANDS, 105.0, 0.0) == 0.0
    assert time_to_band(BANDS, 90.0, -20.0) is None
    assert time_to_band((), 90.0, 20.0) is None


@given(st.floats(5, 400), st.floats(-300, 300), st.floats(-300, 300))
def test_time_to_a_moving_band_is_gap_over_closing_speed(gap: float, acceleration: float, rate: float) -> None:
    found = time_to_moving_band(Sliding(), 500.0, 500.0 + gap, (acceleration, rate), 1.0)
    closing = acceleration - rate
    # Twelve halvings of a fiftieth of the horizon; a band 10 rad/s wide is not stepped over below 500 rad/s².
    if closing > 0 and gap / closing < 0.98 and closing < 490:
        assert found == pytest.approx(gap / closing, abs=1e-5)
    elif closing * 1.0 < gap:
        assert found is None


def test_a_standing_speed_is_met_by_a_band_that_the_load_moves() -> None:
    assert time_to_moving_band(Sliding(), 300.0, 400.0, (0.0, -200.0), 1.0) == pytest.approx(0.5, abs=1e-5)
    assert time_to_moving_band(Sliding(), 405.0, 400.0, (0.0, -200.0), 1.0) == 0.0
