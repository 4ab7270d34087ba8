"""Bifurcation sweeps: a linear train against its exact answer, a fold that is known, and the order of things."""

import pickle
from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from dataclasses import astuple, replace
from itertools import islice
from math import log, pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes import MeshForce, Regime, simulate
from seat_gear_dynamics.regimes.points import bare
from seat_gear_dynamics.regimes.sweep import Row, Sweep, intervals, stretches, sweep, sweep_each, sweep_rows
from seat_gear_dynamics.regimes.sweep_plan import Begun, Plan, Way

Array = NDArray[np.float64]
MakeTrain = Callable[..., GearTrain]

PAIR = np.array([*range(6), *range(12, 18)])  # the coordinates of P12 and their rates


@pytest.fixture(scope="module")
def linear(make_train: MakeTrain, steady: Callable[[GearTrain], GearTrain]) -> System:
    """A train without backlash and stiffness variation, well damped: a linear system forced by its error."""
    edits = {"meshes.*.backlash": 0, "*damping_ratio": 0.3, "*.torsional_stiffness": 2e7}
    return System(steady(make_train(edits))).at(frequency=0.5, load=600.0)


def jacobian(system: System) -> Array:
    """Return the Jacobian of P12, (12, 12); unit steps are exact where the right-hand side is linear."""
    base = system.derivative(0.0, np.zeros(24))
    columns = [system.derivative(0.0, unit) - base for unit in np.eye(24)[PAIR]]
    return np.array([column[PAIR] for column in columns]).T


def steady_section(system: System) -> Array:
    """Return (δ/b_c, its rate) at mesh phase 0 of the forced motion, harmonic by harmonic."""
    frequency, samples = system.operating_point.frequency, 16
    times = 2 * pi / frequency * np.arange(samples) / samples
    forcing = np.array([system.derivative(t, np.zeros(24))[PAIR] for t in times])
    harmonics = np.fft.fft(forcing, axis=0) / samples
    orders = np.fft.fftfreq(samples, 1 / samples)
    matrix = jacobian(system)
    parts = [
        np.linalg.solve(1j * n * frequency * np.eye(12) - matrix, h) for n, h in zip(orders, harmonics, strict=True)
    ]
    state = np.zeros(24)
    state[PAIR] = np.real(np.sum(parts, axis=0))
    delta, rate = system.deflections(0.0, state)
    return np.array([delta[0], rate[0]])


@pytest.fixture(scope="module")
def linear_sweep(linear: System) -> Sweep:
    return sweep(linear, over="frequency", start=0.4, stop=1.6, points=4, direction="up", transient=60, periods=64)


def test_a_linear_train_moves_with_period_one_on_its_exact_section(linear: System, linear_sweep: Sweep) -> None:
    assert [row.value for row in linear_sweep.rows] == pytest.approx([0.4, 0.8, 1.2, 1.6])
    for row in linear_sweep.rows:
        assert (row.regime.name, row.regime.period) == ("periodic", 1)
        # The march's local error is (0.1)^5/120 of the fastest mode a step; what of it stays is below 1e-5.
        expected = steady_section(linear.at(frequency=row.value))
        assert np.abs(row.section - expected).max() < 1e-5
        assert row.force is not None
        assert row.force.min <= row.force.mean <= row.force.rms <= row.force.max


def test_the_exponent_of_a_linear_train_is_its_slowest_damping(linear: System, linear_sweep: Sweep) -> None:
    values, vectors = np.linalg.eig(jacobian(linear))
    # Whatever the tangent's first direction and the turning of complex modes, the logarithm of its length stays within
    # that of the modes' condition number.
    spread = log(np.linalg.cond(vectors))
    for row in linear_sweep.rows:
        assert row.regime.lyapunov == pytest.approx(values.real.max(), abs=spread / (64 * 2 * pi / row.value))
        assert row.regime.lyapunov is not None
        assert row.regime.lyapunov < 0


def test_a_linear_train_has_no_second_motion(linear: System) -> None:
    found = sweep(linear, over="load", start=100, stop=600, points=2, direction="both", transient=60, periods=48)
    assert found.coexisting() == ()
    assert intervals(found, "chaotic") == ()
    assert intervals(found, "periodic") == ((100.0, 600.0),)


@pytest.fixture(scope="module")
def light(make_train: MakeTrain) -> System:
    """A lightly damped, lightly loaded train: its resonance leans over as teeth part."""
    return System(make_train({"meshes.*.damping_ratio": 0.05})).at(frequency=0.5, load=200.0)


@pytest.fixture(scope="module")
def fold(light: System) -> Sweep:
    return sweep(light, over="frequency", start=0.78, stop=0.98, points=5, direction="both", transient=200, periods=64)


def test_up_and_down_part_between_the_folds_of_a_gear_pair_with_backlash(fold: Sweep) -> None:
    # The jump of Kahraman & Singh 1990 (Journal of Sound and Vibration 142, 49-75): the curve softens, so that going
    # up the small motion lasts, and going down the large one, whose teeth part.
    assert fold.coexisting() == pytest.approx((0.83, 0.88, 0.93))
    for up, down in list(zip(fold.along("up"), fold.along("down"), strict=True))[1:4]:
        assert up.regime.period == down.regime.period == 1
        assert up.force is not None
        assert down.force is not None
        assert down.force.max > 1.2 * up.force.max
        assert down.force.contact_loss > 2 * up.force.contact_loss


def test_outside_the_folds_both_directions_end_on_one_motion(fold: Sweep) -> None:
    for index in (0, 4):
        up, down = fold.along("up")[index], fold.along("down")[index]
        # Both are within what is left of the run-in, in which a period closes to 1e-3.
        assert np.abs(up.section[-1] - down.section[-1]).max() < 1e-2


def test_both_directions_take_turns_and_the_second_goes_down(fold: Sweep) -> None:
    assert [row.direction for row in fold.rows] == ["up", "down"] * 5
    assert [row.value for row in fold.rows[::2]] == sorted(row.value for row in fold.rows)[::2]
    assert [row.value for row in fold.rows[1::2]] == [row.value for row in fold.rows[::2]][::-1]
    assert fold.directions == ("up", "down")
    assert Plan("frequency", 0.78, 0.98, 5, "both").rows == len(fold.rows)


def test_one_direction_alone_gives_the_same_rows_as_beside_the_other(light: System, fold: Sweep) -> None:
    rows = sweep_rows(light, Plan("frequency", 0.78, 0.98, 5, "down", 200, 64))
    with closing(rows):
        for row, expected in zip(islice(rows, 2), fold.along("down")[::-1], strict=False):
            assert row.as_dict() == expected.as_dict()
            assert row.section.tolist() == expected.section.tolist()


def test_a_row_of_the_fold_keeps_its_numbers(fold: Sweep) -> None:
    row = fold.along("down")[2]
    assert row.value == pytest.approx(0.88)
    found = row.as_dict()
    assert list(found) == [
        "value",
        "regime",
        "period",
        "lyapunov",
        "contact_loss",
        "force_min",
        "force_max",
        "force_mean",
        "force_rms",
        "direction",
        "lyapunov_error",
    ]
    # Golden: of the train of fixed parameters, as first found. On a stable motion rounding dies out; 1e-6 leaves room
    # for another machine's.
    golden = {
        "contact_loss": 162 / 272,
        "force_min": -116.83617877584004,
        "force_max": 912.7139665482973,
        "force_mean": 188.36405664023894,
        "force_rms": 360.3142495211127,
    }
    assert (found["regime"], found["period"], found["direction"]) == ("periodic", 1, "down")
    assert {name: found[name] for name in golden} == pytest.approx(golden, rel=1e-6)


def test_a_cold_row_is_what_simulate_gives_there(light: System) -> None:
    found = sweep(light, over="damping", start=0.06, stop=0.08, points=2, transient=5, periods=48)
    assert found.directions == ("cold",)
    for row in found.rows:
        expected = simulate(light, damping=row.value, transient=5, periods=48)
        # Sweeps are marched in lanes: the same steps but for rounding.
        assert row.force is not None
        assert astuple(row.force) == pytest.approx(astuple(expected.meshes["s1_s2"]), rel=1e-9, abs=1e-9)
        assert (row.regime.name, row.regime.period) == (expected.regime.name, expected.regime.period)
        assert row.section == pytest.approx(expected.response.section, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("over", "value", "same"),
    [
        ("speed_rpm", 1359.0, {"speed": 1359 * RPM}),
        ("speed", 140.0, {"speed": 140.0}),
        ("frequency", 0.8, {"frequency": 0.8}),
        ("load", 350.0, {"load": 350.0}),
        ("backlash_um", 12.5, {"backlash": 12.5 * 1e-6}),
    ],
)
def test_every_quantity_means_what_simulate_means_by_it(
    light: System, over: Any, value: float, same: dict[str, Any]
) -> None:
    with closing(sweep_rows(light, Plan(over, value, value + 1, 2, transient=0, periods=4))) as rows:
        row = next(rows)
    expected = simulate(light, transient=0, periods=4, **same)
    assert row.value == value
    assert row.force is not None
    assert astuple(row.force) == pytest.approx(astuple(expected.meshes["s1_s2"]), rel=1e-9, abs=1e-9)  # rounding


def test_rows_do_not_depend_on_the_number_of_threads(light: System) -> None:
    options: Any = {"over": "load", "start": 50, "stop": 150, "points": 3, "transient": 0, "periods": 48}
    first, second = (sweep(light, workers=workers, **options) for workers in (1, 3))
    assert [row.as_dict() for row in first.rows] == [row.as_dict() for row in second.rows]


@pytest.mark.parametrize("direction", ["up", "both", "cold"])
def test_rows_stream_before_the_sweep_is_done(light: System, direction: Any) -> None:
    rows = sweep_rows(light, Plan("load", 1, 1000, 1000, direction, 0, 1), workers=1)
    with closing(rows):
        told = [next(rows).value for _ in range(2)]
    assert told == {"up": [1.0, 2.0], "both": [1.0, 1000.0], "cold": [1.0, 2.0]}[direction]


def test_progress_is_told_of_every_row(light: System) -> None:
    told: list[tuple[int, int]] = []
    options: Any = {"over": "load", "start": 100, "stop": 200, "points": 2, "transient": 0, "periods": 1}
    sweep(light, direction="both", progress=lambda *done: told.append(done), **options)
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]


def test_a_value_at_which_the_motion_diverges_is_a_row_without_force(conservative: GearTrain) -> None:
    # A load whose deflection is beyond every bound: a hundred million b_c.
    system = System(conservative).at(frequency=0.5, load=600.0)
    first, last = sweep(system, over="load", start=600, stop=1e16, points=2, transient=0, periods=48).rows
    assert first.force is not None
    assert last.force is None
    assert last.section.shape == (0, 2)
    values = last.as_dict()
    assert (values["regime"], values["lyapunov"], values["force_max"]) == ("undecided", None, None)
    assert "diverged" in last.regime.reason


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"over": "colour"}, "over 'colour', expected one of frequency, speed, speed_rpm"),
        ({"direction": "sideways"}, "direction is 'sideways', expected one of up, down, both, cold"),
        ({"start": 2.0}, "from 2.0 to 1.0, expected finite numbers, the lower first"),
        ({"stop": float("nan")}, "from 0.5 to nan"),
        ({"points": 1}, "has 1 points, expected at least 2"),
        ({"start": -1.0, "points": 3}, "frequency is 0"),
        ({"over": "damping", "start": -1.0}, "damping ratio is -1.0"),
        ({"periods": 0}, "0 sampled periods"),
    ],
)
def test_impossible_sweeps_are_refused_before_anything_runs(
    light: System, change: dict[str, Any], sentence: str
) -> None:
    asked: Any = {"over": "frequency", "start": 0.5, "stop": 1.0, "points": 3} | change
    with pytest.raises(ValueError, match=sentence):
        sweep_rows(light, Plan(**asked))


def test_a_system_at_standstill_can_be_swept_over_its_speed_alone(light: System) -> None:
    still = light.at(frequency=0.0)
    with pytest.raises(ValueError, match="frequency is 0"):
        sweep_rows(still, Plan("load", 1, 2, 2))
    found = sweep(still, over="frequency", start=0.5, stop=0.6, points=2, transient=0, periods=1)
    assert all(row.force is not None for row in found.rows)


@given(st.floats(-1e6, 1e6), st.floats(1e-6, 1e6), st.integers(2, 200), st.integers(0, 199), st.integers(1, 50))
def test_values_in_blocks_are_those_of_linspace(
    start: float, width: float, points: int, first: int, length: int
) -> None:
    plan = Plan("load", start, start + width, points)
    numbers = range(first % points, min(first % points + length, points))
    expected = np.linspace(start, start + width, points).tolist()
    assert plan.values("up", numbers) == plan.values("cold", numbers) == expected[numbers.start : numbers.stop]
    assert plan.values("down", numbers) == expected[::-1][numbers.start : numbers.stop]


def test_values_of_a_study_that_does_not_fit_into_memory_are_known_block_by_block() -> None:
    plan = Plan("load", 0.0, 1.0, 10**12 + 1)
    assert plan.values("up", range(5 * 10**11, 5 * 10**11 + 2)) == [0.5, 0.5 + 1e-12]
    assert plan.values("up", range(10**12, 10**12 + 1)) == [1.0]


def numbers_of(row: Row) -> tuple[object, ...]:
    return row.as_dict(), row.section.tolist(), None if row.state is None else row.state.tolist()


@pytest.mark.parametrize("direction", ["up", "down", "both", "cold"])
def test_a_sweep_goes_on_behind_any_row_with_the_rows_it_would_have_had(light: System, direction: Any) -> None:
    plan = Plan("load", 50, 350, 4, direction, 3, 48)
    whole = list(sweep_rows(light, plan))
    expected = [numbers_of(row) for row in whole]
    for done in range(plan.rows):
        states = {row.direction: row.state for row in whole[:done]}
        # As it comes back from a file: a list.
        kept = {way: None if state is None else state.tolist() for way, state in states.items()}
        rest = [numbers_of(row) for row in sweep_rows(light, plan, begun=Begun(done, kept))]
        assert rest == expected[done:]


def test_a_row_says_where_the_next_value_starts_and_nothing_after_a_divergence(conservative: GearTrain) -> None:
    system = System(conservative).at(frequency=0.5, load=600.0)
    first, last = sweep_rows(system, Plan("load", 600, 1e16, 2, "up", 0, 48))
    assert first.state is not None
    assert first.state.shape == (24,)
    assert last.state is None
    cold, _ = sweep_rows(system, Plan("load", 600, 700, 2, transient=0, periods=48))
    assert cold.state is None


class Shuffled:
    """Workers that cut and order their work otherwise than threads do, and pickle all of it on the way."""

    def __init__(self, length: int) -> None:
        self.segment, self._length = length, length

    def share(self, points: int) -> int:
        return self._length

    def compute(self, work: Callable[[Any], Any], blocks: Iterable[Any]) -> Generator[Any, None, None]:
        asked = [pickle.dumps((work, block)) for block in blocks]
        found = {}
        for number in reversed(range(len(asked))):
            task, block = pickle.loads(asked[number])
            found[number] = pickle.dumps(task(block))
        yield from (pickle.loads(found[number]) for number in range(len(asked)))


@pytest.mark.parametrize("direction", ["both", "cold"])
@pytest.mark.parametrize("length", [1, 3, 100])
def test_rows_do_not_depend_on_who_computes_them_in_what_blocks(light: System, direction: Any, length: int) -> None:
    plan = Plan("load", 50, 350, 5, direction, 3, 48)
    found = [numbers_of(row) for row in sweep_rows(light, plan, workers=Shuffled(length))]
    assert found == [numbers_of(row) for row in sweep_rows(light, plan)]


def test_what_is_made_of_a_row_is_made_where_the_row_is(light: System) -> None:
    plan = Plan("load", 50, 350, 5, transient=0, periods=48)
    found = list(sweep_each(light, plan, value_of, workers=Shuffled(2)))
    assert found == plan.values("cold", range(5))


def value_of(row: Row) -> float:
    return row.value


def test_what_travels_is_lean(light: System) -> None:
    # The train's text and its tooth stiffness curves, which a worker computes as quickly as it would unpack them.
    assert len(pickle.dumps(bare(light.train))) < len(light.train.text)
    assert bare(light.train).meshes[0].stiffness == light.train.meshes[0].stiffness


def made(names: list[str], way: Way = "up", section: Array | None = None) -> list[Row]:
    force = MeshForce(1.0, 0.0, 2.0, 1.1, 0.0, 1.0)
    points = np.zeros((4, 2)) if section is None else section
    return [
        Row(float(k), way, Regime(name, None, None, None, "made"), force, points)  # type: ignore[arg-type]
        for k, name in enumerate(names)
    ]


def test_intervals_are_runs_of_neighbouring_values() -> None:
    found = Sweep("load", tuple(made(["chaotic", "chaotic", "periodic", "chaotic", "undecided"])))
    assert intervals(found, "chaotic") == ((0.0, 1.0), (3.0, 3.0))
    assert intervals(found, "periodic") == ((2.0, 2.0),)
    assert intervals(found, "quasi-periodic") == ()


def test_stretches_are_the_same_whichever_way_the_values_come() -> None:
    judged = [(1.0, True), (2.0, True), (3.0, False), (4.0, True)]
    assert list(stretches(judged)) == [(1.0, 2.0), (4.0, 4.0)]
    assert list(stretches(judged[::-1])) == [(4.0, 4.0), (1.0, 2.0)]
    assert list(stretches([])) == []


def test_intervals_of_both_directions_are_where_either_is_so() -> None:
    found = Sweep("load", (*made(["chaotic", "periodic"]), *made(["periodic", "chaotic"], "down")))
    assert intervals(found, "chaotic") == ((0.0, 1.0),)
    assert intervals(found, "chaotic", direction="up") == ((0.0, 0.0),)


@given(st.lists(st.sampled_from(["chaotic", "periodic", "undecided"]), min_size=1, max_size=30))
def test_every_value_of_a_regime_is_in_one_of_its_intervals_and_no_other_is(names: list[str]) -> None:
    found = intervals(Sweep("load", tuple(made(names))), "chaotic")
    for k, name in enumerate(names):
        assert (name == "chaotic") == any(low <= k <= high for low, high in found)


def test_a_divergence_in_one_direction_alone_is_a_difference() -> None:
    up, down = made(["periodic"]), made(["periodic"], "down")
    assert Sweep("load", (*up, *down)).coexisting() == ()
    lost = [replace(row, force=None, section=np.empty((0, 2))) for row in down]
    assert Sweep("load", (*up, *lost)).coexisting() == (0.0,)
    both = [replace(row, force=None, section=np.empty((0, 2))) for row in up]
    assert Sweep("load", (*both, *lost)).coexisting() == ()
    assert Sweep("load", tuple(up)).coexisting() == ()


def test_a_sweep_that_was_cut_short_compares_only_values_met_from_both_sides() -> None:
    up, down = made(["periodic"] * 3)[:2], made(["periodic"] * 3, "down", np.ones((4, 2)))[1:]
    assert Sweep("load", (*up, *down)).coexisting() == (1.0,)
