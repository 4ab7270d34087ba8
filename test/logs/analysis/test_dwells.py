"""Dwells in drives whose stands are known."""

from itertools import pairwise

import numpy as np
import pytest

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis.batches import Batch, Warned
from seat_gear_dynamics.logs.analysis.dwells import ROOM, SETTLING, Dwells


def stairs(*, step: float = 0.02) -> Batch:
    """Return 5 s at 1000 r/min, a ramp of 1 s, 3 s at 1300 r/min with noise, then 4 s of standstill; 600 N·m."""
    time = np.arange(0, 13, step)
    speed = np.interp(time, [0, 5, 6, 9, 9.2, 13], [1000, 1000, 1300, 1300, 0, 0]) * RPM
    speed += np.random.default_rng(0).normal(0, 0.5 * RPM, len(time)) * (speed > 0)
    load = np.full(len(time), 600.0)
    batch = Batch(drive=np.column_stack([time, speed, load, np.where(time < 5.1, 0, 1)]))
    fine = np.arange(0, 13, 0.002)
    batch.section = np.column_stack([fine, fine, -fine, fine, fine])
    batch.state = np.column_stack([time, *[time] * 6])
    statistics = np.tile(np.array([10.0, -5, 30, 12, 20, -9, 60, 25]), (len(time), 1))
    batch.force = np.column_stack([time, statistics, speed, load])
    batch.warnings = [Warned(t, 0, "", "periodic" if t < 5 else "chaotic") for t in np.arange(0, 13, 0.1).tolist()]
    return batch


def cut(batch: Batch, parts: int) -> list[Batch]:
    edges = np.linspace(0, 13.1, parts + 1).tolist()
    return [between(batch, low, high) for low, high in pairwise(edges)]


def between(batch: Batch, low: float, high: float) -> Batch:
    kept = {}
    for name in ("drive", "force", "state", "section"):
        rows = getattr(batch, name)
        kept[name] = rows[(rows[:, 0] >= low) & (rows[:, 0] < high)]
    return Batch(**kept, warnings=[w for w in batch.warnings if low <= w.time < high])


@pytest.mark.parametrize("parts", [1, 2, 7])
def test_stands_are_found_with_their_means_however_the_log_is_cut(parts: int) -> None:
    dwells = Dwells()
    for batch in cut(stairs(), parts):
        dwells.add(batch)
    dwells.finish()
    # A second on the ramp of 300 r/min a second crosses the tolerance of 1 % in 40 ms: no dwell; nor is standstill one.
    first, second = dwells.rows
    # The tolerance of 1 % is 10 and 13 r/min: on the ramp it lasts for a sample or two beyond the stand.
    assert (first.begin, first.end) == pytest.approx((0.0, 5.03), abs=0.03)
    assert second.begin == pytest.approx(6.0, abs=0.06)
    assert second.end == pytest.approx(9.0, abs=0.03)
    assert first.speed == pytest.approx(1000 * RPM, rel=1e-3)
    assert second.speed == pytest.approx(1300 * RPM, rel=2e-3)
    assert first.load == pytest.approx(600)
    assert first.regimes["periodic"] == pytest.approx(1.0, abs=0.03)  # one warning of 48 comes on the ramp
    assert second.regimes == {"chaotic": 1.0}
    np.testing.assert_allclose(second.force, [[10, -5, 30, 12], [20, -9, 60, 25]])


def test_section_and_states_come_in_order_from_behind_the_settling_and_are_bounded() -> None:
    dwells = Dwells()
    for batch in cut(stairs(), 3):
        dwells.add(batch)
    dwells.finish()
    first = dwells.rows[0]
    assert len(first.section) == ROOM  # 5 s at 500 points a second are more
    assert first.section[0, 0] == pytest.approx(SETTLING, abs=0.002)
    np.testing.assert_allclose(np.diff(first.section[:, 0]), 0.002)
    assert len(first.state) < ROOM
    assert len(first.drive) > 200


def test_only_the_longest_keep_their_motion_and_all_keep_their_row() -> None:
    dwells = Dwells(keep=1)
    dwells.add(stairs())
    dwells.finish()
    assert [len(dwell.drive) > 0 for dwell in dwells.rows] == [True, False]
    assert dwells.count == 2
    assert dwells.longest(1)[0].seconds == max(dwell.seconds for dwell in dwells.rows)


def test_nothing_gives_no_dwell() -> None:
    dwells = Dwells()
    dwells.add(Batch())
    dwells.finish()
    assert dwells.rows == []
