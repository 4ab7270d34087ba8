"""A number that changes with compiled code, so that a cached entry is never older than what it calls."""

from hashlib import sha256
from types import CodeType, FunctionType, ModuleType
from typing import Any

from numba.core.extending import _Intrinsic
from numba.core.registry import CPUDispatcher

_PLAIN = (bool, int, float, str, tuple)


def revision(*modules: ModuleType) -> int:
    """Return a number made from the compiled functions, what emits code for them, and plain constants of `modules`.

    numba's cache on disk looks at the file of the function it keeps, not at the files of the functions that one calls.
    An entry that closes over this number is compiled anew when any of them changes, because numba's key holds what a
    function closes over. Limits: a constant array is not looked at, nor what else a plain function closes over.
    """
    digest = sha256()
    for module in modules:
        for name, value in sorted(vars(module).items()):
            if isinstance(value, CPUDispatcher):
                told = sorted(value.targetoptions.items(), key=str)
                digest.update(repr((name, _told(value.py_func.__code__), told)).encode())
            elif isinstance(value, _Intrinsic):
                digest.update(repr((name, _told(value._defn.__code__))).encode())
            elif isinstance(value, FunctionType) and value.__module__ == module.__name__:
                digest.update(repr((name, _told(value.__code__))).encode())
            elif isinstance(value, _PLAIN) and not name.startswith("__"):
                digest.update(repr((name, value)).encode())
    return int.from_bytes(digest.digest()[:6], "big")


def _told(code: CodeType) -> tuple[Any, ...]:
    """Return what a function does, its inner functions included, whose own texts hold an address."""
    constants = tuple(_told(each) if isinstance(each, CodeType) else each for each in code.co_consts)
    return code.co_code, constants, code.co_names
