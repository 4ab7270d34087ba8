"""Diagnostics as tasks: merging by maximum, what is said by default, and the health of inputs on a test's clock."""

import pytest

from seat_gear_dynamics.nodes.diagnostics import Composite, Status, Updater
from seat_gear_dynamics.nodes.input_health import InputHealth, SampleHealth, Wakefulness
from seat_gear_dynamics.sensing import Level

SECOND = 10**9


class Saying:
    """A task that says what it is given."""

    def __init__(self, name: str, *said: tuple[Level, str, dict[str, object]]) -> None:
        self.name, self._said = name, said

    def run(self, status: Status) -> None:
        for level, text, values in self._said:
            status.say(level, text, values)


def merged(*said: tuple[Level, str]) -> tuple[Level, str]:
    status = Status()
    for level, text in said:
        status.say(level, text)
    return status.level, status.text


def test_a_task_that_says_nothing_is_an_error() -> None:
    (status,) = Updater("node", [Saying("lazy")]).update()
    assert (status.level, status.name, status.message) == (b"\x02", "node: lazy", "no message was set")


def test_levels_merge_by_maximum_and_the_worst_keep_their_texts() -> None:
    ok, warn, error, stale = Level.OK, Level.WARN, Level.ERROR, Level.STALE
    assert merged((ok, "a"), (ok, "b")) == (ok, "a")
    assert merged((ok, "a"), (warn, "b"), (warn, "c"), (ok, "d")) == (warn, "b; c")
    assert merged((warn, "a"), (error, "b"), (warn, "c")) == (error, "b")
    assert merged((error, "a"), (stale, "b")) == (stale, "b")


def test_several_tasks_are_one_status_with_all_values_in_order() -> None:
    tasks = (Saying("one", (Level.OK, "a", {"x (m)": 1.0})), Saying("two", (Level.WARN, "b", {"y (s)": None})))
    (status,) = Updater("node", [Composite("both", tasks)]).update()
    assert (status.level, status.message) == (b"\x01", "b")
    assert [(value.key, value.value) for value in status.values] == [("x (m)", "1"), ("y (s)", "unknown")]


class Input:
    """The health of a speed, on a clock that the test moves."""

    def __init__(self, limit: float = 0.5) -> None:
        self.now, self.publishers = 100 * SECOND, 1
        self.wakefulness = Wakefulness(self.now, 1000 * SECOND)
        self.health = InputHealth(
            "speed",
            "motor/speed",
            lambda: self.now,
            lambda since, now: self.wakefulness.held_up(since, now),
            lambda: limit,
            lambda: self.publishers,
        )

    def come(self, times: int, period: float, *, good: bool = True) -> None:
        for _ in range(times):
            self.now += round(period * SECOND)
            self.health.heard(self.now)
            if good:
                self.health.used(self.now)
            else:
                self.health.refused("it is nonsense")

    def report(self) -> Status:
        status = Status()
        self.health.run(status)
        return status


def test_rate_age_and_gap_are_those_since_the_last_report() -> None:
    speed = Input()
    speed.come(100, 0.01)
    found = speed.report()
    assert found.level == Level.OK
    assert found.values["speed rate (Hz)"] == pytest.approx(100)  # exact but for rounding of a quotient
    assert found.values["speed age (s)"] == 0
    assert found.values["speed longest gap (s)"] == pytest.approx(0.01)
    speed.now += SECOND // 4
    speed.come(1, 0.0)
    assert speed.report().values["speed longest gap (s)"] == pytest.approx(0.25)


def test_silence_is_stale_and_nonsense_an_error() -> None:
    speed = Input()
    assert (speed.report().level, speed.report().text) == (Level.STALE, "no speed received yet")
    speed.come(10, 0.1)
    speed.come(10, 0.1, good=False)
    assert speed.report().level == Level.ERROR
    assert speed.health.silence() == "no speed that can be used for more than 0.5 s: it is nonsense"
    speed.come(1, 0.1)
    assert speed.report().level == Level.OK
    speed.now += SECOND
    assert (speed.report().level, speed.health.silence()) == (Level.STALE, "no speed for more than 0.5 s")


def test_one_bad_value_among_good_ones_is_no_silence() -> None:
    speed = Input()
    speed.come(10, 0.1)
    speed.come(4, 0.1, good=False)
    assert speed.health.silence() is None


def test_a_clock_that_steps_back_leaves_no_age() -> None:
    speed = Input()
    speed.come(10, 0.1)
    speed.now -= 50 * SECOND
    speed.health.forget()
    assert speed.health.silence() == "no speed received yet"
    speed.come(5, 0.1)
    assert speed.report().level == Level.OK


def test_slow_and_double_publishers_are_a_warning() -> None:
    speed = Input()
    speed.come(3, 0.7)
    speed.publishers = 2
    found = speed.report()
    assert found.level == Level.WARN
    assert found.text == (
        "speed: it comes with gaps of up to 0.7 s, 0.5 s is allowed; "
        "2 publishers on motor/speed: their values are mixed"
    )


def test_refused_samples_warn_once_and_stay_counted() -> None:
    samples = SampleHealth()
    samples.refuse("late", "it was late")
    first, second = Status(), Status()
    samples.run(first)
    samples.run(second)
    assert (first.level, first.text) == (Level.WARN, "1 samples refused, the last: it was late")
    assert (second.level, second.values["refused, late"]) == (Level.OK, 1)


@pytest.mark.parametrize(("ns", "words"), [(200_000_000, "0.2 s late"), (-200_000_000, "0.2 s ahead")])
def test_a_sample_far_from_its_time_is_named(ns: int, words: str) -> None:
    samples, status = SampleHealth(), Status()
    samples.waited(ns)
    samples.waited(1000)
    samples.run(status)
    assert status.level == Level.WARN
    assert words in status.text


def test_a_hold_up_is_known_from_ticks_that_come_late_and_before_they_come() -> None:
    wakefulness = Wakefulness(0, 100)
    for now in (100, 200, 390):  # within two periods of each other
        wakefulness.tick(now)
    assert [wakefulness.held_up(0, now) for now in (400, 590, 591, 1300)] == [0, 0, 101, 810]
    wakefulness.tick(1300)
    assert [wakefulness.held_up(since, 1350) for since in (0, 490, 1000, 1300, 1340)] == [810, 810, 300, 0, 0]
    wakefulness.tick(1400)
    wakefulness.tick(2000)
    assert wakefulness.held_up(0, 2000) == 810 + 500
    assert wakefulness.held_up(1400, 2000) == 500


def test_a_hold_up_is_no_silence_but_silence_goes_on_after_it() -> None:
    speed = Input(limit=0.5)
    speed.wakefulness = Wakefulness(speed.now, SECOND // 10)
    for _ in range(10):
        speed.come(1, 0.1)
        speed.wakefulness.tick(speed.now)
    speed.now += 60 * SECOND
    assert speed.health.silence() is None, "no tick has come yet, and what waits is unread"
    speed.wakefulness.tick(speed.now)
    for silent in (False, False, False, False, True):  # a period is left of the hold-up, and 0.4 s to its limit
        assert (speed.health.silence() is not None) == silent
        speed.now += round(0.1001 * SECOND)
        speed.wakefulness.tick(speed.now)
    speed.come(1, 0.0)
    assert speed.health.silence() is None


@pytest.mark.parametrize("period", [0.21, 1.0, 60.0])
def test_a_node_that_is_late_at_every_tick_finds_silence_as_well(period: float) -> None:
    speed = Input(limit=0.5)
    speed.wakefulness = Wakefulness(speed.now, SECOND // 10)
    speed.come(1, 0.0)
    found = []
    for _ in range(6):
        speed.now += round(period * SECOND)
        speed.wakefulness.tick(speed.now)
        found.append(speed.health.silence() is not None)
    # Of the last three hold-ups only a period of 0.1 s each counts, of an earlier one everything.
    assert found == [False, False, False, True, True, True]
