"""Zones of bands that hold at every load and of bands that follow it, and the choice of bands for a log."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import ForbiddenBand, GearTrain, load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis.band_source import band_source
from seat_gear_dynamics.logs.analysis.bands import BandStays
from seat_gear_dynamics.logs.analysis.batches import FORCE_COLUMNS, empty
from seat_gear_dynamics.logs.analysis.zones import FixedZones, MovingZones, zones
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.regimes.regime_map import RegimeMap
from seat_gear_dynamics.sensing import MapBands, PublishedBands, packaged_map

Array = NDArray[np.float64]
BANDS = (ForbiddenBand(100.0, 110.0, 600.0), ForbiddenBand(150.0, 200.0, 600.0))


@pytest.fixture
def chart(train: GearTrain, made_map: Callable[..., RegimeMap]) -> MapBands:
    """A band at 1000 to 1200 r/min at 300 N·m, 100 r/min higher at 400, and a second one from 1700 on at 400 alone."""
    return MapBands(made_map(train, [300.0, 400.0], [[(1000, 1200)], [(1100, 1300), (1700, 1800)]]), train)


def drive(speeds: list[float], loads: list[float]) -> Array:
    """Rows as `Batch.drive`, 0.1 s apart; speeds in r/min."""
    count = len(speeds)
    return np.column_stack([np.arange(count) / 10, np.array(speeds) * RPM, loads, np.zeros(count)])


@given(st.lists(st.floats(-250, 250), min_size=1, max_size=30))
def test_fixed_zones_are_the_bands_themselves(speeds: list[float]) -> None:
    cut, load = FixedZones(BANDS), np.zeros(len(speeds))
    inside = [any(band.low <= abs(speed) <= band.high for band in BANDS) for speed in speeds]
    assert cut.forbidden(np.array(speeds), load).tolist() == inside
    places = cut.where(np.array(speeds), load)
    for speed, place in zip(speeds, places.tolist(), strict=True):
        stretch = cut.stretches()[place]
        assert stretch.low <= abs(speed) <= stretch.high


def test_a_train_without_bands_has_one_zone() -> None:
    cut = FixedZones(())
    assert cut.forbidden(np.array([1.0, 200.0]), np.zeros(2)).tolist() == [False, False]
    assert [(s.low, s.high, s.forbidden) for s in cut.stretches()] == [(0.0, np.inf, False)]


def test_the_zones_of_a_map_are_its_bands_in_the_middle_of_a_newton_metre(chart: MapBands) -> None:
    cut = zones(chart)
    assert isinstance(cut, MovingZones)
    rng = np.random.default_rng(1)
    speed, load = rng.uniform(-2200, 2200, 3000) * RPM, rng.uniform(250, 450, 3000)
    covered = (load >= 300) & (load <= 400) & (np.abs(speed) <= chart.covered_speed)
    middle = np.minimum(np.floor(load) + 0.5, 400.0)
    pairs = zip(covered, np.abs(speed).tolist(), middle.tolist(), strict=True)
    expected = [bool(known) and chart.forbids(magnitude, at) for known, magnitude, at in pairs]
    assert cut.forbidden(speed, load).tolist() == expected
    found = [cut.stretches()[place] for place in cut.where(speed, load)]
    assert [stretch.forbidden for stretch in found] == expected
    assert [stretch.outside for stretch in found] == (~covered).tolist()


def test_time_in_a_map_counts_by_its_nearest_load(chart: MapBands) -> None:
    # The map's nodes are 50 r/min apart, and a band reaches 25 beyond where chaos crosses one half: 50 with both.
    speeds, loads = [600.0, 1100.0, 1100.0, 1250.0, 1250.0, 2000.0, 600.0], [310.0, 310, 311, 390, 391, 390, 500]
    stays = BandStays(zones(chart))
    stays.add(drive(speeds, loads), empty(FORCE_COLUMNS))
    rows = [(s.stretch.load, s.stretch.forbidden, round(s.seconds, 9), s.visits) for s in stays.found()]
    assert rows == [
        (300.0, False, 0.0, 1),
        (300.0, True, 0.2, 1),
        (400.0, True, 0.2, 1),
        (400.0, False, 0.1, 1),
        (None, False, 0.1, 1),
    ]
    last = stays.found()[-1].stretch
    assert last.outside
    band = stays.found()[1].stretch
    # The edges move by 1 r/min in a newton metre: between 300 and 400 N·m from 950 and 1250 to 1050 and 1350.
    assert [band.low / RPM, band.high / RPM] == pytest.approx([950 + 11.5, 1250 + 11.5])


@given(st.lists(st.integers(1, 9), min_size=1, max_size=12), st.integers(0, 3))
def test_how_a_drive_is_cut_changes_no_stay_in_a_map(sizes: list[int], seed: int) -> None:
    train = load_train()
    with packaged_map().open("rb") as file:
        source = MapBands(RegimeMap.load(file, train), train)
    rng = np.random.default_rng(seed)
    rows = drive(rng.uniform(0, 2200, 60).tolist(), rng.uniform(0, 750, 60).tolist())
    cuts = np.cumsum(sizes)
    found = []
    for parts in ([rows], np.split(rows, cuts[cuts < len(rows)])):
        stays = BandStays(zones(source))
        for part in parts:
            stays.add(part, empty(FORCE_COLUMNS))
        found.append([(s.stretch, round(s.seconds, 9), s.visits, round(s.longest, 9)) for s in stays.found()])
    assert found[0] == found[1]


def test_a_log_is_judged_by_the_bands_that_it_names(train: GearTrain) -> None:
    packaged = load_train()
    label = band_source(packaged, packaged_map(), None).label
    assert label.startswith("map ")
    assert band_source(packaged, None, label).label == label
    for machine, stated in ((packaged, None), (packaged, "published"), (packaged, "map 0123"), (train, label)):
        found = band_source(machine, None, stated)
        assert isinstance(found, PublishedBands)
        assert found.at(600.0) == tuple(sorted(machine.bands, key=lambda band: band.low))


def test_a_map_that_is_named_and_cannot_be_used_is_a_sentence(train: GearTrain, tmp_path: Path) -> None:
    (tmp_path / "no.npz").write_bytes(b"no map")
    cases = {
        tmp_path / "no.npz": "holds no regime map",
        tmp_path / "absent.npz": "No such file",
        packaged_map(): "of another machine",
    }
    for path, words in cases.items():
        with pytest.raises(LogError, match=words):
            band_source(train, path, None)


def test_the_packaged_map_may_be_called_by_its_word() -> None:
    train = load_train()
    assert band_source(train, Path("packaged"), None).label == band_source(train, packaged_map(), None).label
