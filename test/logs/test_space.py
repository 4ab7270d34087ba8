"""The room on the disk: time to full, warning and stop."""

from __future__ import annotations

import pytest

from seat_gear_dynamics.logs.space import SpaceWatch

MB = 1_000_000


def watch() -> SpaceWatch:
    return SpaceWatch(reserve=100 * MB, warn_seconds=60.0)


def test_time_to_full_is_what_is_left_over_the_rate() -> None:
    seen = watch()
    found = [seen.update(t, 1000 * MB - 2 * t * MB) for t in range(11)]
    # 980 MB free, 100 of them kept, 2 MB/s
    assert found[-1].time_to_full == pytest.approx(440.0, rel=1e-12)
    assert found[-1].room == "enough"
    assert found[0].time_to_full is None, "one look has no rate"
    assert found[1].time_to_full is None, "a rate over one second says nothing"


def test_low_is_said_in_time_and_full_at_the_reserve() -> None:
    seen = watch()
    rooms = {t: seen.update(t, 1000 * MB - 5 * t * MB) for t in range(181)}
    assert rooms[110].room == "enough"
    # 100 + 60 s · 5 MB/s = 400 MB: reached at t = 120
    assert rooms[120].room == "low"
    assert rooms[120].time_to_full == pytest.approx(60.0, rel=1e-12)
    assert "400 MB free, full in 60 s" in rooms[120].text
    assert rooms[180].room == "full"


def test_a_disk_that_stands_still_or_grows_has_no_time_to_full_and_is_low_near_the_reserve() -> None:
    seen = watch()
    assert [seen.update(t, 500 * MB).room for t in range(5)] == ["enough"] * 5
    assert seen.update(5, 600 * MB).time_to_full is None
    assert watch().update(0, 199 * MB).room == "low"
    assert watch().update(0, 100 * MB).room == "full"


def test_the_rate_is_that_of_the_last_half_minute() -> None:
    seen = watch()
    for t in range(100):
        seen.update(t, 1000 * MB)
    last = [seen.update(100 + t, 1000 * MB - t * MB) for t in range(31)][-1]
    assert last.time_to_full == pytest.approx((970 - 100) / 1.0, rel=1e-12)


def test_a_clock_that_steps_back_starts_the_rate_anew() -> None:
    seen = watch()
    seen.update(1000.0, 900 * MB)
    assert seen.update(0.0, 800 * MB).time_to_full is None
    assert seen.update(4.0, 796 * MB).time_to_full == pytest.approx(696.0, rel=1e-12)
