"""The line of action: its ends, and the gap beyond them against the distance from a tip's corner to an involute."""

from math import asin, cos, nan, sin, sqrt, tan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.studies.contact_verification.line_of_action import Line, gap, line_of_action


@pytest.fixture(scope="module", params=[0, 1], ids=["s1_s2", "s3_s4"])
def line(request: pytest.FixtureRequest, train: GearTrain) -> Line:
    return line_of_action(train.meshes[request.param], 0.0)


def distance(line: Line, position: float) -> float:
    """Return the distance from the driven tip's corner to the driver's flank, both placed for `position`, m.

    World axes: the driver's centre at 0, its base-circle tangent point on the x axis, the line of action along y.
    """
    r, other, tip, length = line.driver_radius, line.driven_radius, line.driven_tip, line.length
    roll = sqrt((tip / other) ** 2 - 1)
    turned = (length - position) / other - (roll - np.arctan(roll))
    corner = np.array([r + other - tip * cos(turned), length - tip * sin(turned)])
    origin = position / r  # a string unwound to `position` at polar angle 0 began at this base-circle angle

    def apart(unwound: float) -> float:
        angle = origin - unwound
        point = r * np.array([cos(angle) - unwound * sin(angle), sin(angle) + unwound * cos(angle)])
        return float(np.hypot(*(point - corner)))

    nearby = position / r + 0.1
    found = minimize_scalar(apart, bounds=(0.0, nearby + 0.5), method="bounded", options={"xatol": 1e-12})
    return float(found.fun)


def test_path_of_contact_has_the_trains_contact_ratio(line: Line, train: GearTrain) -> None:
    # Table 1 prints base radii with four digits, and so the ends of the path are right to some 1e-3 of a pitch.
    ratios = [mesh.contact_ratio for mesh in train.meshes]
    assert min(abs((line.end - line.start) / line.pitch - ratio) for ratio in ratios) < 1e-3


def test_nothing_slides_at_the_pitch_point(line: Line) -> None:
    ratio = line.driver_radius / line.driven_radius
    assert line.pitch_point - ratio * (line.length - line.pitch_point) == pytest.approx(0.0, abs=1e-15)


def test_no_gap_on_the_path_and_a_smooth_one_beyond_it(line: Line) -> None:
    for position in np.linspace(line.start, line.end, 9):
        assert gap(line, float(position)) == (0.0, 0.0)
    for end, outward in ((line.start, -1), (line.end, 1)):
        separation, slope = gap(line, end + outward * 1e-9)
        assert separation == pytest.approx(0.0, abs=1e-14)
        assert slope == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("beyond", [1e-4, 2e-4, 4e-4])
def test_gap_before_the_path_is_the_distance_of_the_corner_from_the_flank(line: Line, beyond: float) -> None:
    separation, _ = gap(line, line.start - beyond)
    # 1e-9 m: what the minimum's flatness leaves of 1e-12 in the roll angle is far less, rounding of metres is 1e-17.
    assert separation == pytest.approx(distance(line, line.start - beyond), abs=1e-9)
    assert separation > 1e-7


@pytest.mark.parametrize("beyond", [1e-4, 4e-4])
def test_gap_past_the_path_is_that_of_the_swapped_pair(line: Line, beyond: float) -> None:
    swapped = line._replace(
        driver_radius=line.driven_radius,
        driven_radius=line.driver_radius,
        driver_tip=line.driven_tip,
        driven_tip=line.driver_tip,
        start=line.length - line.end,
        end=line.length - line.start,
    )
    separation, slope = gap(line, line.end + beyond)
    mirrored, mirrored_slope = gap(swapped, swapped.start - beyond)
    assert separation == pytest.approx(mirrored, rel=1e-12)
    assert slope == pytest.approx(-mirrored_slope, rel=1e-12)


@given(st.floats(1e-5, 5e-4), st.booleans())
def test_gap_grows_outward_with_its_slope(train: GearTrain, outside: float, past: bool) -> None:
    line = line_of_action(train.meshes[0], 0.0)
    position = line.end + outside if past else line.start - outside
    h = 1e-8
    ahead, behind = gap(line, position + h), gap(line, position - h)
    # Central difference of a function with curvature below 1e3 per m: error below h²·1e6, and 1e-19/h of rounding.
    assert gap(line, position)[1] == pytest.approx((ahead[0] - behind[0]) / (2 * h), abs=1e-6)
    assert (ahead[0] > behind[0]) == past


def test_a_pitch_away_from_the_path_nothing_can_touch(line: Line) -> None:
    # Loads of this machine press flanks together by less than 0.6 mm in any reading of Table 2.
    assert gap(line, line.start - line.pitch)[0] > 1e-3
    assert gap(line, line.end + line.pitch)[0] > 1e-3


def test_without_corner_contact_pairs_are_out_of_reach_beyond_the_path(line: Line) -> None:
    abrupt = line._replace(corner=False)
    assert gap(abrupt, line.start - 1e-6) == (1.0, 0.0)
    assert gap(abrupt, line.start) == (0.0, 0.0)


@pytest.mark.parametrize("backlash", [10e-6, 30e-6, 100e-6])
def test_the_centre_distance_opens_the_backlash_asked_for(train: GearTrain, backlash: float) -> None:
    def involute(line: Line) -> float:
        angle = asin(line.sine)
        return tan(angle) - angle

    tight, open_ = (line_of_action(train.meshes[0], b) for b in (0.0, backlash))
    gained = 2 * (tight.driver_radius + tight.driven_radius) * (involute(open_) - involute(tight))
    # The law is of first order in the shift Δ; the second is Δ·cos³α/(2·(r_a + r_b)·sin²α) of it, 1.3 % at 100 µm.
    # Beyond that 0.1 %: the third order, and Table 1's base radii, which stand for 20.007° and not 20°.
    shift = backlash / (2 * tight.sine)
    second = shift * tight.cosine**3 / (2 * (tight.driver_radius + tight.driven_radius) * tight.sine**2)
    assert gained == pytest.approx(backlash * (1 + second), rel=1e-3)
    assert open_.half_backlash == backlash / 2
    assert open_.end - open_.start < tight.end - tight.start


@pytest.mark.parametrize("backlash", [-1e-6, nan])
def test_a_backlash_that_is_none_is_refused(train: GearTrain, backlash: float) -> None:
    with pytest.raises(ValueError, match="backlash is"):
        line_of_action(train.meshes[0], backlash)


def test_a_backlash_that_takes_the_teeth_apart_is_refused(train: GearTrain) -> None:
    with pytest.raises(ValueError, match="contact ratio of s1_s2"):
        line_of_action(train.meshes[0], 2e-3)
