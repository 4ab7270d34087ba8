"""The regime map: what is asked of it between its nodes, and that it comes back from disk as it was."""

from collections.abc import Callable
from dataclasses import fields, replace
from io import BytesIO

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes import Regime, simulate
from seat_gear_dynamics.regimes.classification import Name
from seat_gear_dynamics.regimes.regime_map import NAMES, MapError, RegimeMap, chaos_weight, fingerprint

MakeTrain = Callable[..., GearTrain]


def made(chaos: list[list[float]], *, samples: int = 0) -> RegimeMap:
    """Make a map over speeds 10, 20, … rad/s and loads 100, 200, … N·m with this probability of chaos."""
    p = np.array(chaos)
    rows, columns = p.shape
    return RegimeMap(
        speeds=10.0 * np.arange(1, columns + 1),
        loads=100.0 * np.arange(1, rows + 1),
        codes=np.where(p >= 0.5, NAMES.index("chaotic"), NAMES.index("periodic")).astype(np.int64),
        period=np.where(p >= 0.5, 0, 1).astype(np.int64),
        lyapunov=np.where(p >= 0.5, 0.05, -0.01),
        contact_loss=p / 2,
        force_max=100 * p,
        chaos=p,
        samples=samples,
        fingerprint="made",
        transient=1,
        periods=48,
    )


@pytest.fixture(scope="module")
def system(make_train: MakeTrain) -> System:
    return System(make_train({"*.torsional_stiffness": 2e7, "*damping_ratio": 0.2}))


@pytest.fixture(scope="module")
def computed(system: System) -> RegimeMap:
    return RegimeMap.compute(system, [50.0, 90.0], [200.0, 400.0, 600.0], transient=20, periods=48)


def test_every_node_is_the_simulation_of_its_speed_and_load(system: System, computed: RegimeMap) -> None:
    assert computed.codes.shape == (3, 2)
    for row, column in ((0, 1), (2, 0)):
        speed, load = float(computed.speeds[column]), float(computed.loads[row])
        expected = simulate(system, speed=speed, load=load, transient=20, periods=48)
        assert NAMES[computed.codes[row, column]] == computed.regime_at(speed, load) == expected.regime.name
        assert computed.period[row, column] == (expected.regime.period or 0)
        # The map is marched in lanes: the same steps but for rounding, and a tangent without its part across the lines
        # of action, whose share in the exponent is within its error.
        error = expected.regime.lyapunov_error
        assert computed.lyapunov[row, column] == pytest.approx(expected.regime.lyapunov, abs=error)
        force = expected.meshes["s1_s2"]
        found = (computed.contact_loss[row, column], computed.force_max[row, column])
        assert found == pytest.approx((force.contact_loss, force.max), rel=1e-9, abs=1e-9)
        assert computed.chaos[row, column] == 0.0


def test_a_map_does_not_depend_on_threads_and_tells_its_progress(system: System, computed: RegimeMap) -> None:
    told: list[tuple[int, int]] = []
    again = RegimeMap.compute(
        system,
        computed.speeds,
        computed.loads,
        lambda *done: told.append(done),
        transient=20,
        periods=48,
        workers=1,
    )
    for field in fields(RegimeMap):
        assert np.array_equal(getattr(again, field.name), getattr(computed, field.name)), field.name
    assert told == [(k, 6) for k in range(1, 7)]


def test_a_map_comes_back_from_a_file_as_it_was(computed: RegimeMap, system: System) -> None:
    file = BytesIO()
    computed.save(file)
    file.seek(0)
    found = RegimeMap.load(file, system.train)
    for field in fields(RegimeMap):
        stored, kept = getattr(computed, field.name), getattr(found, field.name)
        assert type(kept) is type(stored)
        assert np.array_equal(stored, kept), field.name
        if isinstance(stored, np.ndarray):
            assert kept.dtype == stored.dtype


def test_a_map_of_another_machine_is_refused(computed: RegimeMap, system: System) -> None:
    file = BytesIO()
    computed.save(file)
    other = system.train.with_mesh(1, backlash=21e-6)
    file.seek(0)
    with pytest.raises(MapError, match=r"of another machine: its parameters have the hash .* those of height_adjuster"):
        RegimeMap.load(file, other)
    file.seek(0)
    assert not RegimeMap.load(file).belongs_to(other)


def test_the_fingerprint_is_of_what_moves_and_of_nothing_else(train: GearTrain) -> None:
    mark = fingerprint(train)
    assert fingerprint(replace(train, name="x", text="y", bands=(), provenance={})) == mark
    assert fingerprint(replace(train, model=replace(train.model, covered_speed=1.0, max_load=1.0))) == mark
    assert fingerprint(replace(train, model=replace(train.model, load_scale=0.06))) != mark
    assert fingerprint(train.with_mesh(0, damping_ratio=np.nextafter(0.07, 1))) != mark
    assert fingerprint(train.with_time_scale(1000.0)) != mark


@pytest.mark.parametrize("content", [b"", b"not a map", b"PK\x03\x04 torn"])
def test_a_file_that_is_no_npz_is_refused_in_a_sentence(content: bytes) -> None:
    with pytest.raises(MapError, match="The file holds no regime map"):
        RegimeMap.load(BytesIO(content))


def test_a_file_of_other_arrays_or_of_another_format_is_refused() -> None:
    file = BytesIO()
    np.savez(file, speeds=np.zeros(3))
    file.seek(0)
    with pytest.raises(MapError, match=r"no regime map of format 1 .missing: loads, codes"):
        RegimeMap.load(file)
    file = BytesIO()
    np.save(file, np.zeros(3))
    file.seek(0)
    with pytest.raises(MapError, match="a single array and no regime map"):
        RegimeMap.load(file)


def test_a_truncated_map_is_refused(computed: RegimeMap) -> None:
    file = BytesIO()
    computed.save(file)
    with pytest.raises(MapError, match="The file holds no regime map"):
        RegimeMap.load(BytesIO(file.getvalue()[:-200]))


def test_arrays_of_another_shape_are_refused() -> None:
    found = made([[0.0, 1.0]])
    with pytest.raises(MapError, match=r"chaos has shape \(2, 1\), expected \(1, 2\)"):
        found.with_chaos(np.zeros((2, 1)), 3)


def test_the_regime_is_that_of_the_nearest_node() -> None:
    found = made([[0, 1, 1], [0, 0, 1]])
    assert found.regime_at(14.9, 100.0) == "periodic"
    assert found.regime_at(15.1, 149.0) == "chaotic"
    assert found.regime_at(20.0, 151.0) == "periodic"
    assert found.regime_at(-20.0, 100.0) == "chaotic"


@given(st.floats(10, 30), st.floats(100, 200))
def test_the_probability_is_linear_between_nodes(speed: float, load: float) -> None:
    found = made([[0.0, 0.2, 0.4], [0.3, 0.5, 0.7]])  # 0.02 a rad/s and 0.003 a N·m: a plane, met exactly
    assert found.probability_at(speed, load) == pytest.approx(0.02 * (speed - 10) + 0.003 * (load - 100), abs=1e-12)
    assert found.probability_at(-speed, load) == found.probability_at(speed, load)


def test_the_interval_is_wilsons_where_machines_were_drawn_and_no_interval_where_not() -> None:
    nominal = made([[0.0, 0.5]])
    assert nominal.interval_at(20.0, 100.0) == (0.5, 0.5)
    drawn = nominal.with_chaos(nominal.chaos, 10)
    assert drawn.interval_at(20.0, 100.0) == pytest.approx((0.2366, 0.7634), abs=5e-5)
    assert drawn.interval_at(10.0, 100.0) == pytest.approx((0.0, 0.2775), abs=5e-5)
    assert drawn.samples == 10


@pytest.mark.parametrize(("speed", "load"), [(9.9, 100.0), (30.1, 100.0), (20.0, 99.0), (20.0, 201.0), (0.0, 150.0)])
def test_outside_the_map_nothing_is_said(speed: float, load: float) -> None:
    found = made([[0, 1, 1], [0, 0, 1]])
    assert not found.covers(speed, load)
    for question in (found.regime_at, found.probability_at, found.interval_at):
        with pytest.raises(MapError, match="outside the map, which covers 10 to 30 rad/s and 100 to 200 N·m"):
            question(speed, load)


def test_inside_the_map_and_on_its_edge_something_is_said() -> None:
    found = made([[0, 1, 1], [0, 0, 1]])
    assert found.covers(10.0, 100.0)
    assert found.covers(-30.0, 200.0)
    assert not found.covers(float("nan"), 100.0)
    assert not found.covers(20.0, float("nan"))


def test_bands_are_those_of_the_load() -> None:
    found = made([[0, 1, 1, 0], [0, 0, 1, 0], [0, 0, 0, 0]])
    assert [(b.low, b.high, b.load) for b in found.bands(100.0)] == [(15.0, 35.0, 100.0)]
    assert [(b.low, b.high, b.load) for b in found.bands(200.0)] == [(25.0, 35.0, 200.0)]
    assert found.bands(300.0) == ()


def test_bands_between_two_loads_shrink_from_one_to_the_other() -> None:
    found = made([[0, 1, 1, 0], [0, 0, 1, 0]])
    # At 120 N·m the node at 20 rad/s has 0.8: halfway to it the probability is 0.4, and 0.5 at 5/8.
    (band,) = found.bands(120.0)
    assert band.low == pytest.approx(10 + 10 * 0.5 / 0.8)
    (band,) = found.bands(180.0)
    assert band.low == pytest.approx(20 + 10 * (0.5 - 0.2) / 0.8)


def test_a_lower_threshold_forbids_more() -> None:
    found = made([[0.0, 0.3, 0.6, 0.9]], samples=20)
    wide, narrow = found.bands(100.0, 0.2)[0], found.bands(100.0, 0.8)[0]
    assert wide.low < narrow.low
    assert narrow.low_error > 5.0  # more than half a step: twenty machines do not say much


@pytest.mark.parametrize("threshold", [0.0, -1.0, 1.1, float("nan")])
def test_an_impossible_threshold_is_refused(threshold: float) -> None:
    with pytest.raises(MapError, match=r"threshold is .* expected more than 0 and at most 1"):
        made([[0.0, 1.0]]).bands(100.0, threshold)


def test_bands_of_a_load_outside_are_refused() -> None:
    with pytest.raises(MapError, match="outside the map"):
        made([[0.0, 1.0]]).bands(500.0)


@pytest.mark.parametrize(
    ("speeds", "loads", "sentence"),
    [
        ([50.0], [1.0], "one speed, expected at least two"),
        ([0.0, 50.0], [1.0], "lowest of the speeds is 0 rad/s"),
        ([50.0, 40.0], [1.0], "each above the one before"),
        ([40.0, 50.0], [], "The loads are"),
        ([40.0, 50.0], [float("nan")], "The loads are"),
    ],
)
def test_impossible_grids_are_refused(system: System, speeds: list[float], loads: list[float], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        RegimeMap.compute(system, speeds, loads)


def test_chaos_and_divergence_count_whole_and_what_leans_counts_half() -> None:
    weights = [
        chaos_weight(Regime(name, None, value, 0.01, ""), diverged=diverged) for name, value, diverged in MOTIONS
    ]
    assert weights == [0.0, 0.0, 1.0, 0.5, 0.0, 1.0]


MOTIONS: tuple[tuple[Name, float, bool], ...] = (
    ("periodic", -0.01, False),
    ("quasi-periodic", 0.0, False),
    ("chaotic", 0.05, False),
    ("undecided", 0.05, False),
    ("undecided", -0.05, False),
    ("undecided", 0.0, True),
)
