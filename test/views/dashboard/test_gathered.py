"""What the listener keeps of messages, right and wrong ones."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import seat_gear_dynamics.nodes  # noqa: F401  (makes rclpy importable)
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.dashboard_gathered import Gathered, section_points
from seat_gear_dynamics.sensing import Contact, ForceWindow, Level

STAMP = 1_700_000_000_500_000_000
CONTACTS = (Contact(1e-5, 2e-3, 300.0), Contact(3e-5, 4e-3, 500.0))
WINDOWS = tuple(ForceWindow(0.02, 0.02 * mean, 0.02 * mean * mean, mean - 9, mean + 9) for mean in (300.0, 500.0))


class Clock:
    """Steady time that the test sets."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def gathered(clock: Clock) -> Gathered:
    return Gathered(clock)


def test_nothing_heard_is_nothing_and_has_no_age(gathered: Gathered) -> None:
    snapshot = gathered.take()
    assert [snapshot.speed, snapshot.load, snapshot.warning, snapshot.section] == [None] * 4
    assert snapshot.samples.shape == (0, 7)
    assert snapshot.windows.shape == (0, 9)
    assert snapshot.ages == {}


def test_rows_come_once_and_words_stay(gathered: Gathered, clock: Clock) -> None:
    gathered.on_input(messages.model_input(STAMP, 188.5, 600.0))
    gathered.on_force(messages.mesh_force(STAMP, WINDOWS))
    gathered.on_state(messages.mesh_state(STAMP, CONTACTS))
    first = gathered.take()
    assert first.windows.tolist() == [pytest.approx([STAMP * 1e-9, 300, 291, 309, 300, 500, 491, 509, 500])]
    assert first.samples.tolist() == [pytest.approx([STAMP * 1e-9, 1e-5, 2e-3, 300, 3e-5, 4e-3, 500])]
    clock.now += 2.5
    second = gathered.take()
    assert len(second.windows) == len(second.samples) == 0
    assert (second.speed, second.load) == (188.5, 600.0)
    assert second.ages == {"speed": 2.5, "load": 2.5, "mesh": 2.5}


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf"), 1e300])
def test_numbers_that_no_bench_can_mean_are_not_heard(gathered: Gathered, value: float) -> None:
    from std_msgs.msg import Float64

    gathered.on_speed(Float64(data=value))
    gathered.on_load(Float64(data=value))
    gathered.on_input(messages.model_input(STAMP, value, 600.0))
    gathered.on_force(messages.mesh_force(STAMP, (WINDOWS[0], ForceWindow(1.0, value, 1.0, 0.0, 1.0))))
    gathered.on_state(messages.mesh_state(STAMP, (CONTACTS[0], Contact(value, 0.0, 0.0))))
    snapshot = gathered.take()
    assert snapshot.speed is None
    assert snapshot.load is None
    assert len(snapshot.windows) == len(snapshot.samples) == 0


@pytest.mark.parametrize(
    "spoil", [lambda m: m.name.pop(), lambda m: m.effort.pop(), lambda m: m.name.reverse() or m.effort.clear()]
)
def test_joint_states_of_another_shape_are_not_heard(gathered: Gathered, spoil: Callable[[Any], Any]) -> None:
    state, force = messages.mesh_state(STAMP, CONTACTS), messages.mesh_force(STAMP, WINDOWS)
    spoil(state)
    spoil(force)
    gathered.on_state(state)
    gathered.on_force(force)
    gathered.on_input(messages.mesh_state(STAMP, ()))
    snapshot = gathered.take()
    assert len(snapshot.windows) == len(snapshot.samples) == 0
    assert snapshot.speed is None


def test_meshes_are_known_by_name_in_any_order(gathered: Gathered) -> None:
    state = messages.mesh_state(STAMP, CONTACTS)
    for column in (state.name, state.position, state.velocity, state.effort):
        column.reverse()
    gathered.on_state(state)
    assert gathered.take().samples[0, 1:].tolist() == [1e-5, 2e-3, 300.0, 3e-5, 4e-3, 500.0]


def test_rows_that_nobody_takes_do_not_gather_without_end(gathered: Gathered) -> None:
    for k in range(5000):
        gathered.on_force(messages.mesh_force(STAMP + k, WINDOWS))
    assert len(gathered.take().windows) == 2000


def test_section_points_are_read_as_they_are_written() -> None:
    section = np.array([[1.0, -0.5, 0.25], [1.5, 0.5, 0.5]])
    points = section_points(messages.poincare(STAMP, section, STAMP))
    assert points is not None
    # x and y travel as float32, t as float64 of seconds since the epoch.
    assert points[:, :2] == pytest.approx(section[:, :2], rel=1e-7)
    assert points[:, 2] - STAMP * 1e-9 == pytest.approx(section[:, 2], abs=1e-6)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda c: setattr(c, "fields", c.fields[:2]),
        lambda c: setattr(c, "width", 10**9),
        lambda c: setattr(c, "point_step", 4),
        lambda c: setattr(c, "point_step", 0),
        lambda c: setattr(c, "data", bytes(3)),
        lambda c: setattr(c, "is_bigendian", True),
        lambda c: setattr(c.fields[0], "offset", 10**6),
    ],
    ids=["a field less", "width", "step", "no step", "data", "endianness", "offset"],
)
def test_a_cloud_of_another_layout_is_not_heard(gathered: Gathered, spoil: Callable[[Any], None]) -> None:
    cloud = messages.poincare(STAMP, np.ones((3, 3)), STAMP)
    spoil(cloud)
    gathered.on_section(cloud)
    assert gathered.take().section is None


def test_an_empty_cloud_is_an_empty_section_and_points_that_are_none_are_left_out() -> None:
    assert section_points(messages.poincare(STAMP, np.empty((0, 3)), STAMP)) == pytest.approx(np.empty((0, 3)))
    section = np.array([[np.nan, 0.0, 0.0], [1.0, 1.0, 1.0], [np.inf, 0.0, 0.0]])
    points = section_points(messages.poincare(STAMP, section, STAMP))
    assert points is not None
    assert points[:, 0].tolist() == [1.0]


def test_diagnostics_are_sorted_and_silent_ones_forgotten(gathered: Gathered, clock: Clock) -> None:
    from diagnostic_msgs.msg import DiagnosticArray

    def array(*names: str) -> Any:
        return DiagnosticArray(status=[messages.status(Level.WARN, name, "text", {"key": 1}) for name in names])

    gathered.on_diagnostics(array("gear_monitor: input", "gear_monitor: warning", "bench_recorder: recording", "odd"))
    snapshot = gathered.take()
    assert [status.name for status in snapshot.health] == ["gear_monitor: input", "odd"]
    assert snapshot.recorder is not None
    assert snapshot.recorder.level == 1
    assert snapshot.recorder.values == (("key", "1"),)
    clock.now += 6
    gathered.on_diagnostics(array("odd"))
    assert [status.name for status in gathered.take().health] == ["odd"]
    gathered.on_diagnostics(array(*(f"flood {i}" for i in range(10_000))))
    assert len(gathered.take().health) <= 40


def test_texts_without_end_are_cut(gathered: Gathered) -> None:
    values = {f"{i}": "v" * 10_000 for i in range(1000)}
    gathered.on_warning(messages.status(Level.ERROR, "n" * 10_000, "m" * 10_000, values))
    warning = gathered.take().warning
    assert warning is not None
    assert (len(warning.name), len(warning.message), len(warning.values)) == (400, 400, 40)
    assert max(len(value) for _, value in warning.values) == 400
