"""Histories, occupancy, bands, directions, section clouds and flows, each against what is known of a made drive."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import ForbiddenBand
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis.bands import BandStays
from seat_gear_dynamics.logs.analysis.batches import FORCE_COLUMNS, Direction, Recent, empty
from seat_gear_dynamics.logs.analysis.histories import Binned
from seat_gear_dynamics.logs.analysis.occupancy import Occupancy, holds
from seat_gear_dynamics.logs.analysis.section_cloud import SectionCloud
from seat_gear_dynamics.logs.analysis.zones import FixedZones, stretches
from seat_gear_dynamics.logs.flows import Flows

BANDS = (ForbiddenBand(100.0, 110.0, 600.0), ForbiddenBand(150.0, 200.0, 600.0))


def ramp(low: float, high: float, seconds: float, rate: float = 100.0) -> NDArray[np.float64]:
    time = np.arange(int(seconds * rate) + 1) / rate
    speed = low + (high - low) * time / seconds
    return np.column_stack([time, speed, np.full(len(time), 600.0), np.sign(high - low) * np.ones(len(time))])


@given(st.lists(st.integers(1, 40), min_size=1, max_size=6))
def test_how_a_drive_is_cut_into_batches_changes_no_result(sizes: list[int]) -> None:
    rows = ramp(0.0, 220.0, 2.0)
    cuts = np.cumsum(sizes)
    pieces = np.split(rows, cuts[cuts < len(rows)])
    results = []
    for parts in ([rows], pieces):
        bands, occupancy = BandStays(FixedZones(BANDS)), Occupancy()
        for part in parts:
            bands.add(part, empty(FORCE_COLUMNS))
            occupancy.add(part)
        stays = [(s.seconds, s.visits, s.longest) for s in bands.found()]
        results.append((stays, occupancy.cells()))
    np.testing.assert_allclose(results[0][0], results[1][0], atol=1e-12)  # sums in another order: rounding
    np.testing.assert_allclose(results[0][1], results[1][1], atol=1e-12)


def test_binned_keeps_extremes_and_means_and_leaves_out_nan() -> None:
    history = Binned(("a", "b"), 0.0, 10.0, bins=5)
    history.add(np.array([0.5, 1.5, 9.9, 10.0]), np.array([[1.0, np.nan], [3.0, 2.0], [5.0, 1.0], [7.0, 1.0]]))
    np.testing.assert_array_equal(history.mean("a"), [2, np.nan, np.nan, np.nan, 6])
    np.testing.assert_array_equal(history.least("a")[[0, 4]], [1, 5])
    np.testing.assert_array_equal(history.most("a")[[0, 4]], [3, 7])
    assert history.mean("b")[0] == 2
    np.testing.assert_array_equal(history.time, [1, 3, 5, 7, 9])
    with pytest.raises(ValueError, match="expected 1 or more"):
        Binned(("a",), 0.0, 1.0, bins=0)


def test_a_gap_is_no_time_anywhere() -> None:
    np.testing.assert_allclose(holds(np.array([1.0, 1.1, 9.0, 9.1]), 0.9), [0.1, 0.1, 0.0, 0.1])
    assert holds(np.empty(0), None).size == 0


def test_time_in_a_band_is_its_width_over_the_slope() -> None:
    stays = BandStays(FixedZones(BANDS))
    stays.add(ramp(0.0, 220.0, 22.0), empty(FORCE_COLUMNS))  # 10 rad/s a second
    seconds = [stay.seconds for stay in stays.found()]
    # 10, 1, 4, 5 and 2 s; a sample stands for the 10 ms before it, so each edge is good to one of them.
    np.testing.assert_allclose(seconds, [10, 1, 4, 5, 2], atol=0.011)
    assert [stay.visits for stay in stays.found()] == [1] * 5
    assert [stay.stretch.forbidden for stay in stays.found()] == [False, True, False, True, False]


def test_forces_of_a_band_are_weighted_by_time() -> None:
    stays = BandStays(FixedZones(BANDS))
    drive = np.column_stack([[0.0, 0.1, 0.4], [105.0] * 3, [600.0] * 3, [0.0] * 3])
    force = np.zeros((3, 11))
    force[:, 0], force[:, 9] = [0.0, 0.1, 0.4], 105.0
    force[:, 1:5] = [[9, 9, 9, 9], [10, -1, 20, 12], [20, 2, 50, 24]]
    stays.add(drive, force)
    found = stays.found()[1]
    assert found.force_seconds == pytest.approx(0.4)
    assert found.forces["s1_s2"].mean == pytest.approx((0.1 * 10 + 0.3 * 20) / 0.4)
    assert found.forces["s1_s2"].rms == pytest.approx(np.sqrt((0.1 * 144 + 0.3 * 576) / 0.4))
    assert (found.forces["s1_s2"].min, found.forces["s1_s2"].max) == (-1, 50)
    assert np.isnan(stays.found()[0].forces["s1_s2"].mean)


def test_stretches_cover_all_speeds_without_overlap() -> None:
    found = stretches(BANDS)
    assert [s.low for s in found] == [0, 100, 110, 150, 200]
    assert found[-1].high == np.inf
    assert stretches(())[0].high == np.inf


def test_a_dwell_keeps_the_direction_from_which_it_was_reached_in_spite_of_noise() -> None:
    noise = np.random.default_rng(1).normal(0, 0.5 * RPM, 400)
    up, down = np.linspace(0, 100, 100), np.linspace(100, 50, 100)
    speed = np.concatenate([up, np.full(100, 100.0), down, np.full(100, 50.0)])
    found = Direction(15 * RPM).follow(speed + noise)
    assert (found[10:200] == 1).all()
    assert (found[210:] == -1).all()
    np.testing.assert_array_equal(Direction(1.0).follow(-speed)[10:200], 1)  # faster in reverse is a run-up too


def test_recent_interpolates_speed_and_holds_direction() -> None:
    recent = Recent(seconds=1.0)
    assert np.isnan(recent.at(np.array([0.0]), "speed")).all()
    recent.extend(np.array([[0.0, 0.0, 600.0, 1.0], [5.0, 50.0, 600.0, 1.0], [5.5, 60.0, 600.0, -1.0]]))
    np.testing.assert_allclose(recent.at(np.array([5.25, 9.0]), "speed"), [55, 60])
    np.testing.assert_array_equal(recent.at(np.array([5.25, 5.5]), "direction"), [1, -1])
    np.testing.assert_allclose(recent.at(np.array([0.0]), "speed"), [50])  # older than a second: forgotten


def test_a_section_cloud_keeps_everything_that_fits_and_a_fair_sample_of_more() -> None:
    cloud = SectionCloud(room=50, seed=3)
    rows = np.column_stack([np.arange(1000.0), np.arange(1000.0), np.zeros(1000), np.full(1000, 100.0), np.ones(1000)])
    cloud.add(rows[:40])
    np.testing.assert_array_equal(cloud.points(1)[:, 1], np.arange(40))
    cloud.add(rows[40:])
    kept = cloud.points(1)
    assert kept.shape == (50, 4)
    assert len(np.unique(kept[:, 1])) == 50
    assert cloud.seen == 1000
    # Each of 50 draws is uniform on 0..999: their mean is 500 within four standard errors of 289/√50.
    assert abs(kept[:, 1].mean() - 499.5) < 4 * 289 / np.sqrt(50)
    assert len(cloud.points(-1)) == 0


def test_points_without_speed_or_direction_are_left_out_of_a_section_cloud() -> None:
    cloud = SectionCloud()
    cloud.add(np.array([[0.0, 1.0, 0.0, np.nan, 1.0], [0.0, 1.0, 0.0, 100.0, 0.0]]))
    assert cloud.seen == 0


def test_flows_count_gaps_exactly_and_medians_to_one_per_cent_beyond_the_exact() -> None:
    flows = Flows(["/a", "/b", "/none"])
    for k in range(10_000):
        flows.add("/a", k * 20_000_000)
    for stamp in (0, 100, 50, 400):  # 50 came late
        flows.add("/b", stamp)
    a, b, none = flows.found()
    assert (a.count, b.count, none.count) == (10_000, 4, 0)
    assert a.longest_gap == pytest.approx(0.02)
    assert a.period == pytest.approx(0.02, rel=0.01)
    assert b.longest_gap == pytest.approx(300e-9)
    assert np.isnan(none.period)
