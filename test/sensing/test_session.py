"""Sensor and alarm together, as the node, the command line and a replay use them."""

import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from seat_gear_dynamics.gears import GearTrain, load_train
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion.compiling import COMPILING
from seat_gear_dynamics.sensing import AlarmSettings, Change, ForceWindow, Level, RejectedSampleError, Session

LOAD = 100.0


def feed(session: Session, rpm: np.ndarray, *, start: float = 0.0) -> list[Change]:
    return [session.feed(start + n / 100, float(v) * RPM, LOAD) for n, v in enumerate(rpm)]


def placed(session: Session) -> list[float]:
    """Return the state of the session's model, empty before a sample."""
    return [] if session.sensor.state is None else session.sensor.state.tolist()


@pytest.fixture
def session(train: GearTrain) -> Session:
    return Session(train)


def test_a_session_begins_stale_without_reading(session: Session) -> None:
    assert (session.verdict.level, session.verdict.reason, session.reading) == (Level.STALE, "no input yet", None)
    assert len(session.section) == 0


def test_a_change_is_flagged_exactly_where_level_or_trip_signal_moves(session: Session) -> None:
    before = (session.verdict.level, session.verdict.in_band)
    changes = feed(session, np.concatenate([np.arange(1200, 1400, 2.0), np.full(50, 1400.0)]))
    for change in changes:
        now = (change.verdict.level, change.verdict.in_band)
        assert change.changed == (now != before)
        before = now
    assert sum(c.changed for c in changes) >= 4
    assert session.verdict is changes[-1].verdict
    assert session.reading is changes[-1].reading


def test_a_sample_is_judged_before_the_model_moves_and_then_all_is_as_if_fed(train: GearTrain) -> None:
    fed, parted = Session(train), Session(train)
    for n, rpm in enumerate(np.concatenate([np.full(30, 1340.0), np.full(30, 1354.0)])):
        change = fed.feed(n / 100, rpm * RPM, LOAD)
        state, reading = placed(parted), parted.reading
        judged = parted.judge(n / 100, rpm * RPM, LOAD)
        assert (judged.verdict, judged.changed, judged.sample) == (change.verdict, change.changed, change.sample)
        assert parted.verdict is judged.verdict
        assert parted.reading is reading
        assert placed(parted) == state
        after = parted.advance(judged.sample)
        assert placed(parted) == placed(fed)
        assert (after.windows, after.contacts, after.regime) == (
            change.reading.windows,
            change.reading.contacts,
            change.reading.regime,
        )
    assert parted.verdict.in_band


def test_motion_is_judged_up_to_the_sample_before(train: GearTrain) -> None:
    session = Session(train)
    changes = feed(session, np.full(400, 1000.0))
    for before, after in pairwise(changes):
        assert after.sample.regime is before.reading.regime
    assert changes[-1].sample.regime.name != "undecided"


def test_a_drive_that_moved_is_not_judged_by_the_motion_it_left() -> None:
    session = Session(load_train())  # the packaged one is chaotic at 1800 r/min
    chaos = [session.feed(n / 100, 1800 * RPM, 600.0) for n in range(400)]
    assert chaos[-1].sample.regime.name == "chaotic"
    change = session.feed(4.0, 1450 * RPM, 600.0)
    assert (change.sample.regime.name, change.sample.regime.reason) == ("undecided", "the drive is not steady")
    assert not any(sign.kind == "motion" for sign in change.verdict.evidence)


def test_silence_is_stale_and_flagged_once(session: Session) -> None:
    feed(session, np.full(10, 1700.0))
    assert session.verdict.in_band
    assert session.silence("no speed for 1 s")
    assert (session.verdict.level, session.verdict.in_band) == (Level.STALE, False)
    assert not session.silence("no speed for 1 s")
    assert not session.silence("no load for 1 s")
    assert session.verdict.reason == "no load for 1 s"


def test_input_after_silence_is_judged_at_once(session: Session) -> None:
    feed(session, np.full(10, 1000.0))
    session.silence("no speed")
    (change,) = feed(session, np.array([1700.0]), start=5.0)
    assert change.changed
    assert change.verdict.in_band
    assert change.reading.event == "gap"


def test_windows_are_gathered_until_taken(session: Session) -> None:
    changes = feed(session, np.full(21, 1000.0))
    first, second = session.take_windows()
    total = (ForceWindow(), ForceWindow())
    for change in changes:
        total = (total[0].merged(change.reading.windows[0]), total[1].merged(change.reading.windows[1]))
    assert (first, second) == total
    assert first.duration == pytest.approx(0.2, abs=1e-3)
    assert session.take_windows() == (ForceWindow(), ForceWindow())


def test_section_keeps_the_last_points_and_no_more(train: GearTrain) -> None:
    session = Session(train, section_points=20)
    changes = feed(session, np.full(60, 1000.0))
    every = np.concatenate([c.reading.section for c in changes])
    assert len(every) > 100
    assert session.section.tolist() == every[-20:].tolist()


def test_a_restart_empties_the_section(session: Session) -> None:
    feed(session, np.full(40, 1000.0))
    assert len(session.section) > 0
    feed(session, np.array([1000.0]), start=9.0)
    assert len(session.section) == 0


def test_reset_starts_over_and_keeps_the_counts(session: Session) -> None:
    feed(session, np.full(40, 1700.0))
    session.reset()
    assert (session.verdict.level, session.verdict.in_band, session.reading) == (Level.STALE, False, None)
    assert session.verdict.reason == "reset, waiting for input"
    assert len(session.section) == 0
    assert session.take_windows() == (ForceWindow(), ForceWindow())
    assert session.sensor.counts == {"started": 1, "accepted": 39}
    (change,) = feed(session, np.array([1000.0]), start=0.4)
    assert (change.reading.event, change.verdict.level) == ("started", Level.OK)


def test_a_refused_sample_changes_neither_verdict_nor_windows(session: Session) -> None:
    feed(session, np.full(40, 1000.0))
    verdict, reading, section = session.verdict, session.reading, session.section
    with pytest.raises(RejectedSampleError):
        session.feed(0.4, float("nan"), LOAD)
    assert session.verdict is verdict
    assert session.reading is reading
    assert session.section is section


def test_two_sessions_fed_alike_agree_bit_for_bit(train: GearTrain) -> None:
    speeds = 1300 + 200 * np.sin(np.arange(80) / 10)
    for one, other in zip(feed(Session(train), speeds), feed(Session(train), speeds), strict=True):
        assert (one.verdict, one.changed, one.reading.contacts) == (
            other.verdict,
            other.changed,
            other.reading.contacts,
        )
        assert one.reading.section.tolist() == other.reading.section.tolist()


def test_settings_reach_the_alarm(train: GearTrain) -> None:
    settings = AlarmSettings(margin=200 * RPM)
    (change,) = feed(Session(train, settings=settings), np.array([1200.0]))
    assert change.verdict.level == Level.WARN


def test_gap_reaches_the_sensor(train: GearTrain) -> None:
    session = Session(train, max_gap=0.05)
    session.feed(0.0, 50.0, LOAD)
    assert session.feed(0.06, 50.0, LOAD).reading.event == "gap"


# Runs every profile of the bench after a warm-up, with and without a map, and prints what is compiled meanwhile.
_PROGRAM = """
from numba.core.event import Listener, install_listener
from seat_gear_dynamics.bench.drive import SimulatedBench
from seat_gear_dynamics.bench.profiles import PROFILES
from seat_gear_dynamics.gears import load_train
from seat_gear_dynamics.regimes.regime_map import RegimeMap
from seat_gear_dynamics.sensing import MapBands, PublishedBands, Session, packaged_map, warm_up

class Compiled(Listener):
    def on_start(self, event):
        print(event.data["dispatcher"])
    def on_end(self, event):
        pass

train = load_train()
warm_up(train, announce=print)
warm_up(train, announce=print)  # is no news
with packaged_map().open("rb") as file:
    map_bands = MapBands(RegimeMap.load(file, train), train)
with install_listener("numba:compile", Compiled()):
    for bands in (PublishedBands.of(train), map_bands):
        for profile in PROFILES.values():
            session, bench = Session(train, bands=bands), SimulatedBench(profile)
            while (sample := bench.step()).t < min(profile.duration, 30.0):
                session.feed(sample.t, sample.speed, sample.load)
                session.take_windows()
print("ran")
"""


def test_after_warming_up_nothing_is_compiled_in_a_running_drive(tmp_path: Path) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", _PROGRAM], env=environment, check=True, capture_output=True, text=True)
    assert done.stdout.splitlines() == [COMPILING, "ran"]
