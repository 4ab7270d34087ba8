"""How times are taken: turns, groups, the shortest of several."""

import numpy as np
import pytest

from benchmarks.timing import best_in_groups, best_of, in_turn


def test_runs_take_their_turns_after_one_that_may_compile() -> None:
    called: list[str] = []

    def run(name: str) -> float:
        called.append(name)
        return 3.0

    rates = in_turn({"a": lambda: run("a"), "b": lambda: run("b")}, 2)
    assert called == ["a", "b"] * 3
    assert {name: found.shape for name, found in rates.items()} == {"a": (2,), "b": (2,)}
    assert all((found > 0).all() for found in rates.values())


def test_the_best_of_each_group_counts() -> None:
    found = best_in_groups({"a": np.array([1.0, 5.0, 2.0, 3.0, 4.0])}, groups=2)
    assert found["a"].tolist() == [5.0, 4.0]


def test_the_best_is_of_as_many_as_asked() -> None:
    called: list[int] = []
    assert best_of(lambda: called.append(1), repeats=4) >= 0.0
    assert len(called) == 4
    with pytest.raises(ValueError, match="empty"):
        best_of(lambda: None, repeats=0)
