"""The bags beside the project: each does what bags/README.md says of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.description import parse_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis, analyse
from seat_gear_dynamics.logs.analysis.rerun import rerun
from seat_gear_dynamics.logs.analysis.rerun_result import Rerun
from seat_gear_dynamics.logs.analysis.what_if import MonitorSettings
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.recovery import recover

BAGS = Path(__file__).resolve().parents[2] / "bags"
MADE = ("split_retained", "band_snapshot1", "killed", "damaged", "damaged_recovered", "ramp")
FORCE, INPUT = "/gear_monitor/mesh_force", "/gear_monitor/input"


def kept_train(bag: Path) -> GearTrain:
    return parse_train((Bag(bag).metadata or {})["system"])


def assert_same_forces(found: Rerun) -> None:
    """Where a bag was made all is equal bit for bit; on another build rounding differs, and calm motion forgets it."""
    for logged, replayed in found.forces.values():
        for name in ("mean", "rms"):
            # Chaos, where the run has any, grows rounding to another path of the same motion: means over seconds hold.
            assert replayed[name] == pytest.approx(logged[name], rel=0.02)


def test_every_bag_is_described_and_small() -> None:
    text = (BAGS / "README.md").read_text(encoding="utf-8")
    folders = sorted(path.name for path in BAGS.iterdir() if (path / "metadata.yaml").is_file())
    assert set(MADE) <= set(folders)
    for name in folders:
        assert f"## {name}\n" in text, f"bags/README.md says nothing of {name}"
    for name in MADE:
        assert sum(file.stat().st_size for file in (BAGS / name).iterdir()) < 200_000


@pytest.mark.parametrize("name", [name for name in MADE if name not in ("killed", "damaged")])
def test_a_sound_bag_opens_here_and_in_rosbags(name: str) -> None:
    bag = Bag(BAGS / name)
    assert (bag.damage, bag.closed) == (None, True)
    with Reader(BAGS / name) as reader:
        assert reader.message_count == bag.message_count == sum(1 for _ in bag.messages())


def test_the_split_log_holds_its_last_files_each_of_which_replays_alone() -> None:
    bag = Bag(BAGS / "split_retained")
    assert [path.name for path in bag.files] == [f"split_retained_{k}.mcap" for k in (4, 5, 6)]
    assert "files let go" in bag.custom_data
    whole = rerun(bag.path, kept_train(bag.path))
    assert (whole.begins, whole.messages) == ("model state", 120)
    assert_same_forces(whole)
    for path in bag.files[1:]:
        alone = rerun(path, kept_train(path))
        assert alone.begins == "model state"
        assert 0 < alone.messages < whole.messages
        assert_same_forces(alone)


def test_the_snapshot_shows_calm_and_event_and_replays_from_its_state() -> None:
    bag = Bag(BAGS / "band_snapshot1")
    assert bag.custom_data["snapshot"] == "a warning began"
    assert (bag.end_ns - bag.start_ns) * 1e-9 <= 1.5
    levels = [status.level for status in bag.statuses("gear_monitor/chaos_warning")]
    assert levels[0] < 2
    assert 2 in levels
    found = rerun(bag.path, kept_train(bag.path))
    assert (found.begins, found.messages, found.damage) == ("model state", 66, None)
    assert_same_forces(found)


def test_the_killed_log_has_no_end_and_replays_as_far_as_it_was_synced(tmp_path: Path) -> None:
    bag = Bag(BAGS / "killed")
    assert not bag.closed
    # Killed with its 150th input, at 3.00 s; the last sync was a second before at most.
    assert 100 <= bag.topics[INPUT].count < 150
    found = rerun(bag.path, kept_train(bag.path))
    assert (found.begins, found.samples) == ("first input", bag.topics[INPUT].count)
    assert_same_forces(found)
    result = recover(bag.path, tmp_path / "sound", unchecked=False, version="test")
    again = Bag(result.output)
    assert again.closed
    assert list(again.messages()) == list(bag.messages())


def test_the_damaged_log_is_reported_and_its_recovery_is_the_one_beside_it(tmp_path: Path) -> None:
    damaged, recovered = Bag(BAGS / "damaged"), Bag(BAGS / "damaged_recovered")
    sound = list(damaged.messages())
    assert damaged.damage is not None
    assert "cannot be unpacked" in damaged.damage
    assert len(sound) == 305 == damaged.message_count - 102
    assert list(recovered.messages()) == sound
    assert recovered.custom_data["recovered_from"] == "damaged"
    result = recover(damaged.path, tmp_path / "again", unchecked=False, version="test")
    assert list(Bag(result.output).messages()) == sound
    assert {topic: each.lost for topic, each in result.topics.items()} == {
        FORCE: 50,
        INPUT: 50,
        "/gear_monitor/model_state": 2,
    }


def test_a_replay_of_the_damaged_log_says_that_it_is() -> None:
    found = rerun(BAGS / "damaged", kept_train(BAGS / "damaged"))
    assert found.damage is not None
    # The missing second is a gap of inputs, at which the monitor of the log did not restart.
    assert not found.identical
    assert found.first_difference is not None


@pytest.fixture(scope="module")
def ramp() -> Analysis:
    return analyse(BAGS / "ramp", kept_train(BAGS / "ramp"))


def test_the_ramp_replays_with_the_section_it_was_recorded_with() -> None:
    path = BAGS / "ramp"
    found = rerun(path, kept_train(path), MonitorSettings(section_points=64))
    assert {each.topic: each.messages for each in found.topics}["gear_monitor/poincare"] == 81
    assert (found.begins, found.samples) == ("first input", 409)
    assert_same_forces(found)


def test_the_ramp_crosses_the_narrow_band_twice_and_dwells_in_the_wide_one(ramp: Analysis) -> None:
    forbidden = [stay for stay in ramp.bands if stay.stretch.forbidden]
    assert [stay.visits for stay in forbidden] == [2, 1]
    assert {round(dwell.speed / RPM, -1) for dwell in ramp.dwells.rows} == {1280, 1700}
    assert (len(ramp.detection.episodes), ramp.detection.missed) == (3, 0)


def test_the_ramp_shows_the_hysteresis_of_its_period_3_motion(ramp: Analysis) -> None:
    """The jump from the branch above δ = 1.8 b_c comes at a higher speed going up than the one onto it going down."""
    ends: list[Any] = []
    for direction in (+1, -1):
        points = ramp.cloud.points(direction)
        high = points[(points[:, 1] > 1.85) & (points[:, 0] > 1420 * RPM)]
        ends.append(np.max(high[:, 0]) / RPM)
    # 1511 up and 1487 down; bins of the cloud are 5 r/min wide, and the drive moves 3 r/min between samples.
    assert ends[0] - ends[1] > 10
