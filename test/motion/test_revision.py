"""The number that keeps cached code from outliving what it calls."""

from types import ModuleType

from numba import njit
from numba.extending import intrinsic

from seat_gear_dynamics.motion import kernel, stages, steps, vectors
from seat_gear_dynamics.motion.revision import revision


def module(source: str) -> ModuleType:
    made = ModuleType("made")
    made.__dict__.update(njit=njit, intrinsic=intrinsic)
    exec(source, made.__dict__)
    return made


def test_code_and_constants_count_and_comments_do_not() -> None:
    source = "LIMIT = 3\n@njit\ndef f(x):\n    return x + LIMIT\n"
    number = revision(module(source))
    assert revision(module(source)) == number
    assert revision(module("# more to say\n" + source)) == number
    assert revision(module(source.replace("x + LIMIT", "x * LIMIT"))) != number
    assert revision(module(source.replace("LIMIT = 3", "LIMIT = 4"))) != number


INTRINSIC = """
def emit(name):
    def typed(context, x):
        def code(context, builder, signature, arguments):
            return getattr(builder, name)(arguments[0], arguments[0])
        return x(x), code
    return intrinsic(typed)
double = emit("fadd")
"""


def test_what_emits_code_counts_and_holds_no_address() -> None:
    number = revision(module(INTRINSIC))
    assert revision(module(INTRINSIC)) == number
    assert revision(module(INTRINSIC.replace("arguments[0], arguments[0]", "arguments[0]"))) != number
    assert revision(module(INTRINSIC.replace("return x(x)", "return x(x, x)"))) != number


def test_a_function_taken_from_another_module_does_not_count() -> None:
    source = "LIMIT = 3\n"
    assert revision(module(source + "from os.path import join\n")) == revision(module(source))


def test_the_march_is_compiled_anew_when_anything_that_it_calls_changes() -> None:
    (closed_over,) = (cell.cell_contents for cell in steps.march.py_func.__closure__)
    assert closed_over == revision(kernel, stages, vectors)
    assert len({revision(each) for each in (kernel, stages, vectors)}) == 3
