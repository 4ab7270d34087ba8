"""The number that keeps cached code from outliving what it calls."""

from types import ModuleType

from numba import njit

from seat_gear_dynamics.motion.integrators.revision import revision


def module(source: str) -> ModuleType:
    made = ModuleType("made")
    made.__dict__["njit"] = njit
    exec(source, made.__dict__)
    return made


def test_code_and_constants_count_and_comments_do_not() -> None:
    source = "LIMIT = 3\n@njit\ndef f(x):\n    return x + LIMIT\n"
    number = revision(module(source))
    assert revision(module(source)) == number
    assert revision(module("# more to say\n" + source)) == number
    assert revision(module(source.replace("x + LIMIT", "x * LIMIT"))) != number
    assert revision(module(source.replace("LIMIT = 3", "LIMIT = 4"))) != number
