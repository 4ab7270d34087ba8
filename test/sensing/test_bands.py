"""Bands that follow the load: what holds at the map's loads, between them, at its ends, and for whom."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import ForbiddenBand, GearTrain, load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes import MapError, RegimeMap
from seat_gear_dynamics.sensing import BandSource, MapBands, PublishedBands, packaged_map

MakeMap = Callable[..., RegimeMap]
STEP = 10.0  # rad/s from one speed of the made maps to the next
ROUNDING = 1e-9


def spans(source: MapBands, load: float) -> list[tuple[float, float]]:
    return [(band.low, band.high) for band in source.at(load)]


@pytest.fixture
def source(make_map: MakeMap, train: GearTrain) -> MapBands:
    """Chaos at 30-50 rad/s and 100 N·m, at 40-60 and 200 N·m, nowhere at 300 N·m."""
    return MapBands(make_map([[0, 0, 1, 1, 1, 0, 0, 0], [0, 0, 0, 1, 1, 1, 0, 0], [0] * 8]), train)


def test_at_a_load_of_the_map_a_band_reaches_to_the_calm_speed_beside_it(source: MapBands) -> None:
    assert spans(source, 100.0) == [(20.0, 60.0)]


def test_edges_move_linearly_between_loads(source: MapBands) -> None:
    assert spans(source, 125.0) == [pytest.approx((22.5, 62.5))]


def test_a_band_that_ends_between_two_loads_is_held_to_the_next(source: MapBands) -> None:
    for load in (200.0, 250.0, 299.0, 300.0):
        assert spans(source, load) == [(30.0, 70.0)]


def test_a_gap_that_one_load_has_alone_is_closed(make_map: MakeMap, train: GearTrain) -> None:
    split = [0, 1, 1, 0, 0, 0, 1, 1, 0]
    found = MapBands(make_map([[0, 1, 1, 1, 1, 1, 1, 1, 0], split, split]), train)
    assert len(found.at(100.0)) == len(found.at(150.0)) == len(found.at(200.0)) == 1
    assert len(found.at(201.0)) == len(found.at(300.0)) == 2


SHARES = st.lists(st.lists(st.floats(0, 1), min_size=9, max_size=9), min_size=2, max_size=4)


@given(rows=SHARES, load=st.floats(100, 400) | st.sampled_from([100.0, 200.0, 300.0]), speed=st.floats(0, 100))
def test_short_ways_give_what_the_long_ones_do_to_the_bit(
    make_map: MakeMap, train: GearTrain, rows: list[list[float]], load: float, speed: float
) -> None:
    chart = make_map(rows)
    found = MapBands(chart, train)
    assert found.forbids(speed, load) == any(low <= speed <= high for low, high in spans(found, load))
    if chart.covers(max(speed, STEP), load):
        share = chart.probability_at(max(speed, STEP), load) * min(1.0, speed / STEP)
        assert found.probability(speed, load) == (share + 0.5) / 2


def test_a_label_names_what_the_bands_depend_on(make_map: MakeMap, train: GearTrain) -> None:
    rows = [[0, 0, 1], [0, 1, 1]]
    label = MapBands(make_map(rows), train).label
    assert label == MapBands(make_map(rows), train).label
    assert len(label.split()) == 2
    others: list[BandSource] = [
        MapBands(make_map([[0, 0, 1], [0, 0, 1]]), train),
        MapBands(make_map(rows, samples=24), train),
        MapBands(make_map(rows, first=11.0), train),
        MapBands(make_map(rows), train, threshold=0.3),
        PublishedBands.of(train),
    ]
    assert len({label, *(each.label for each in others)}) == 6


BINARY_ROWS = st.lists(st.lists(st.sampled_from([0.0, 1.0]), min_size=9, max_size=9), min_size=2, max_size=4)


@given(rows=BINARY_ROWS, share=st.floats(0, 1))
def test_what_is_forbidden_at_two_neighbouring_loads_is_so_between_them(
    make_map: MakeMap, train: GearTrain, rows: list[list[float]], share: float
) -> None:
    found = MapBands(make_map(rows), train)
    for row in range(len(rows) - 1):
        load = 100.0 * (row + 1 + share)
        for column, pair in enumerate(zip(rows[row], rows[row + 1], strict=True)):
            if min(pair) == 1.0:
                speed = STEP * (column + 1)
                assert any(low - ROUNDING <= speed <= high + ROUNDING for low, high in spans(found, load))


@given(rows=BINARY_ROWS, load=st.floats(100, 400), speed=st.floats(0, 90))
def test_no_error_of_the_load_however_small_opens_what_is_forbidden(
    make_map: MakeMap, train: GearTrain, rows: list[list[float]], load: float, speed: float
) -> None:
    # Near a load of the map what holds beside it holds at it: the set at the limit contains the limit of the sets.
    found = MapBands(make_map(rows), train)
    load = min(load, 100.0 * len(rows))
    for near in (load - 1e-7, load + 1e-7):
        for low, high in spans(found, near):
            if low + 1e-6 < speed < high - 1e-6:
                assert any(a - 1e-6 <= speed <= b + 1e-6 for a, b in spans(found, load))


def test_bands_are_apart_and_within_the_map(make_map: MakeMap, train: GearTrain) -> None:
    generator = np.random.default_rng(3)
    found = MapBands(make_map(generator.integers(0, 2, (5, 12)).astype(float).tolist()), train)
    for load in np.linspace(100, 500, 81):
        edges = [edge for span in spans(found, float(load)) for edge in span]
        assert edges == sorted(set(edges))
        assert all(0 <= edge <= 120.0 for edge in edges)


def test_the_map_covers_from_standstill_on_and_nothing_beyond_its_ends(source: MapBands) -> None:
    for speed, load in ((0.0, 100.0), (80.0, 300.0), (5.0, 200.0)):
        assert source.beyond(speed, load) is None
    for speed, load in ((80.1, 200.0), (50.0, 99.9), (50.0, 300.1)):
        assert "outside the map, which covers 0 to 764 r/min and 100 to 300 N·m" in str(source.beyond(speed, load))
        assert source.probability(speed, load) is None
    assert source.at(99.9) == ()


def test_a_map_that_begins_high_says_nothing_below_itself(make_map: MakeMap, train: GearTrain) -> None:
    found = MapBands(make_map([[0, 1], [0, 1]], first=50.0), train)
    assert found.beyond(49.0, 150.0) is not None
    assert found.beyond(50.0, 150.0) is None


def test_the_probability_is_the_maps_and_never_sure(make_map: MakeMap, train: GearTrain) -> None:
    found = MapBands(make_map([[0.0, 0.5, 1.0], [0.0, 0.5, 1.0]], samples=20), train)
    # Jeffreys: (20 p + 1/2)/21.
    assert found.probability(10.0, 150.0) == pytest.approx(0.5 / 21)
    assert found.probability(20.0, 150.0) == pytest.approx(10.5 / 21)
    assert found.probability(30.0, 150.0) == pytest.approx(20.5 / 21)
    assert found.probability(0.0, 150.0) == pytest.approx(0.5 / 21)


def test_a_lower_threshold_forbids_more(make_map: MakeMap, train: GearTrain) -> None:
    found = make_map([[0.0, 0.0, 0.3, 0.9, 0.3, 0.0, 0.0]] * 2, samples=20)
    ((low, high),) = spans(MapBands(found, train, threshold=0.2), 150.0)
    ((inner_low, inner_high),) = spans(MapBands(found, train), 150.0)
    assert low < inner_low < inner_high < high
    with pytest.raises(MapError, match="threshold is 0, expected more than 0"):
        MapBands(found, train, threshold=0)


def test_a_map_of_another_machine_or_of_a_single_load_is_refused_in_a_sentence(
    make_map: MakeMap, train: GearTrain
) -> None:
    with pytest.raises(MapError, match=r"of another machine: .* compute the map of this machine"):
        MapBands(make_map([[0, 1], [0, 1]]), train.with_mesh(0, backlash=21e-6))
    with pytest.raises(MapError, match=r"one load, 100 N·m, .* two loads at least"):
        MapBands(make_map([[0, 1]]), train)


def test_published_bands_hold_at_every_load_and_have_no_probability(train: GearTrain) -> None:
    source = PublishedBands.of(train)
    assert source.at(-50.0) == source.at(600.0) == tuple(sorted(train.bands, key=lambda band: band.low))
    assert source.probability(100.0, 600.0) is None
    assert source.beyond(train.model.covered_speed, 1e6) is None
    assert "beyond the studied range, which ends at 2102 r/min" in str(source.beyond(250.0, 600.0))
    assert PublishedBands([ForbiddenBand(5.0, 6.0, 1.0), ForbiddenBand(1.0, 2.0, 1.0)], 9.0).at(0.0)[0].low == 1.0


def test_the_packaged_map_is_of_the_packaged_machine_and_covers_what_was_studied() -> None:
    train = load_train()
    with packaged_map().open("rb") as file:
        found = RegimeMap.load(file, train)
    source = MapBands(found, train)
    assert found.samples >= 20
    assert source.covered_speed == pytest.approx(train.model.covered_speed)
    assert source.beyond(0.0, 50.0) is None
    # The published bands, 1349-1359 and 1589-2060 r/min at 600 N·m, are forbidden by it too.
    for band in train.bands:
        assert any(b.low <= band.low and band.high <= b.high for b in source.at(band.load))
    assert source.at(600.0)[0].low / RPM > 1100.0
