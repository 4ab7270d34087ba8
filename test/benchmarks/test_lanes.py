"""The count of operations that the limit of the lane kernel is drawn from."""

from collections import Counter
from typing import Any, ClassVar

import pytest

from benchmarks.lanes import operations
from seat_gear_dynamics.motion.lanes import WIDTH
from seat_gear_dynamics.motion.lanes.source import advance_source
from seat_gear_dynamics.motion.lanes.structure import Structure

PAIR = Structure(1, False, True, False, True, True)
STRUCTURES = {
    "pair": PAIR,
    "pair, state alone": Structure(1, False, True, False, False, False),
    "coupled": Structure(2, True, True, False, True, True),
    "torsion as printed": Structure(2, False, False, False, True, True),
}


class Counted:
    """A number that counts what is done to it."""

    done: ClassVar[Counter[str]] = Counter()

    def __init__(self, value: float) -> None:
        self.value = value

    def _with(self, other: Any, name: str) -> "Counted":
        Counted.done[name] += 1
        return Counted(self.value)

    def __add__(self, other: Any) -> "Counted":
        return self._with(other, "add")

    def __sub__(self, other: Any) -> "Counted":
        return self._with(other, "subtract")

    def __mul__(self, other: Any) -> "Counted":
        return self._with(other, "multiply")

    __radd__, __rmul__ = __add__, __mul__

    def pick(self, other: Any) -> "Counted":
        """Stand for min and max."""
        return self._with(other, "pick")

    def __ne__(self, other: object) -> bool:
        return True

    __hash__ = None  # type: ignore[assignment]


@pytest.mark.parametrize("name", STRUCTURES)
def test_as_many_are_counted_as_a_step_does(name: str) -> None:
    # The source itself is run, on numbers that count: an independent way to the same figure.
    structure = STRUCTURES[name]
    module: dict[str, Any] = {"min": lambda a, b: a.pick(b), "max": lambda a, b: a.pick(b)}
    exec(advance_source(structure, WIDTH), module)
    Counted.done = Counter()
    room = [Counted(1.0) for _ in range(WIDTH * len(structure.row))]
    module["advance"](room, [Counted(1.0)] * (9 * structure.meshes), 1)
    assert Counted.done.total() == WIDTH * operations(structure)


def test_tangent_and_statistics_cost_operations() -> None:
    assert operations(STRUCTURES["pair, state alone"]) < operations(PAIR) < operations(STRUCTURES["coupled"])
