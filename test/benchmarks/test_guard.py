"""The regression guard: when it says that something changed, in which words, and what it keeps."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.guard import compare, ratios_of, read_record, record_path, report, write_record
from benchmarks.machine import description, same_machine
from benchmarks.ratio import Better, Findings, Ratio, quotients

MACHINE = {"processor": "one", "processors": 2, "python": "3.11.7"}


def ratio(*values: float, better: Better = "higher", reach: float | None = None) -> Ratio:
    return Ratio(values, "of a test", better, reach)


@pytest.mark.parametrize(
    ("now", "then", "better", "verdict", "factor"),
    [
        ((4.0, 4.2), (2.0, 2.1), "higher", "better", 2.0),
        ((4.0, 4.2), (2.0, 2.1), "lower", "worse", 2.0),
        ((1.0, 1.1), (2.0, 2.2), "higher", "worse", 2.0),
        ((1.0, 1.1), (2.0, 2.2), "lower", "better", 2.0),
        ((2.0, 2.1), (2.05, 2.3), "higher", "same", None),
        ((2.0, 2.1), (2.1, 2.2), "higher", "same", None),  # they touch
        ((1.0,), (2.0, 2.1), "higher", "worse", 2.05),
        ((1.0,), (2.0,), "higher", "unjudged", 2.0),
    ],
)
def test_a_change_is_what_lies_beyond_the_scatter_of_both(
    now: tuple[float, ...], then: tuple[float, ...], better: Better, verdict: str, factor: float | None
) -> None:
    (change,) = compare({"a": ratio(*now, better=better)}, {"a": ratio(*then, better=better)})
    assert change.verdict == verdict
    if factor is not None:
        assert change.factor == pytest.approx(factor, rel=1e-12)  # quotients of the medians


@given(st.lists(st.floats(0.1, 10.0), min_size=2, max_size=5), st.lists(st.floats(0.1, 10.0), min_size=2, max_size=5))
def test_what_is_better_one_way_is_worse_the_other(now: list[float], then: list[float]) -> None:
    there = compare({"a": ratio(*now)}, {"a": ratio(*then)})[0]
    back = compare({"a": ratio(*then)}, {"a": ratio(*now)})[0]
    assert {there.verdict, back.verdict} in ({"same"}, {"better", "worse"})


def test_the_words_name_both_sides_and_the_factor() -> None:
    changes = compare(
        {"a": ratio(4.0, 4.2), "b": ratio(1.0), "d": ratio(1.0)},
        {"a": ratio(2.0, 2.1), "c": ratio(1.0), "d": ratio(1.0)},
    )
    assert [change.sentence for change in changes] == [
        "a: 4.1 (4 to 4.2), was 2.05 (2 to 2.1): better by a factor of 2, beyond the scatter of the repeats.",
        "b: 1, not recorded before.",
        "c: recorded, but not measured now.",
        "d: 1, was 1: one repeat of each, so that no change can be told from scatter.",
    ]


def test_a_record_comes_back_as_it_was(tmp_path: Path) -> None:
    path = record_path("short", tmp_path / "made")
    kept = {"lanes.x": ratio(1.25, 2.5, better="lower", reach=3.0)}
    write_record(path, MACHINE, kept)
    assert read_record(path) == (MACHINE, kept)


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"machine": {}, "ratios": {"a": {"values": "x"}}}', "\x00"])
def test_a_damaged_record_is_none(tmp_path: Path, text: str) -> None:
    (tmp_path / "short.json").write_text(text)
    assert read_record(tmp_path / "short.json") is None
    assert read_record(tmp_path / "absent.json") is None


def test_without_a_record_it_says_how_to_make_one() -> None:
    changes, lines = report(MACHINE, {"a.x": ratio(1.0)}, None)
    assert not changes
    assert "--record" in lines[0]


def test_the_summary_counts_and_warns_of_another_machine() -> None:
    now = {"a.x": ratio(4.0, 4.1), "a.y": ratio(1.0, 1.1)}
    then = {"a.x": ratio(2.0, 2.1), "a.y": ratio(1.0, 1.1), "b.z": ratio(1.0, 1.1)}
    _, lines = report(MACHINE, now, (MACHINE, then))
    assert lines[-1] == "1 ratios as recorded, 1 better, 0 worse."
    _, lines = report(MACHINE, now, ({**MACHINE, "processor": "two"}, then))
    assert "another machine" in lines[-1]
    assert "two" in lines[-1]


def test_benchmarks_that_did_not_run_are_not_missed() -> None:
    changes, _ = report(MACHINE, {"a.x": ratio(1.0, 1.1)}, (MACHINE, {"b.z": ratio(1.0, 1.1), "a.w": ratio(1.0, 1.1)}))
    assert {change.name: change.verdict for change in changes} == {"a.x": "new", "a.w": "gone"}


def test_ratios_carry_the_name_of_their_benchmark() -> None:
    one = ratio(1.0)
    assert ratios_of({"lanes": Findings(ratios={"x": one}), "core": Findings(skipped="why")}) == {"lanes.x": one}


def test_a_ratio_knows_whether_it_reaches_what_it_is_meant_to() -> None:
    assert ratio(1.0, 4.0, 5.0, reach=4.0).reached is True
    assert ratio(1.0, 3.0, 5.0, reach=4.0).reached is False
    assert ratio(0.2, better="lower", reach=0.3).reached is True
    assert ratio(0.4, better="lower", reach=0.3).reached is False
    assert ratio(1.0).reached is None


def test_quotients_want_as_many_of_both() -> None:
    assert quotients([4.0, 9.0], [2.0, 3.0]) == (2.0, 3.0)
    with pytest.raises(ValueError, match="shorter"):
        quotients([1.0, 2.0], [1.0])


def test_the_description_is_of_this_machine_whatever_its_load() -> None:
    now = description()
    assert same_machine(now, {**now, "load_average": now["load_average"] + 1.0})
    assert not same_machine(now, {**now, "vector_bits": 64})
    assert now["packages"]["numpy"]


def test_the_words_tell_of_a_busy_machine() -> None:
    busy = {**MACHINE, "load_average": 7.25}
    _, lines = report(busy, {"a.x": ratio(1.0)}, (MACHINE, {"a.x": ratio(1.0)}))
    assert lines[-1].startswith("Now the machine was busy already, load 7.2 on 2 processors")
    _, lines = report(MACHINE, {"a.x": ratio(1.0)}, (busy, {"a.x": ratio(1.0)}))
    assert lines[-1].startswith("When recorded the machine was busy")
