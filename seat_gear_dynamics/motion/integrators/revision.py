"""A number that changes with compiled code, so that a cached entry is never older than what it calls."""

from hashlib import sha256
from types import ModuleType

from numba.core.registry import CPUDispatcher

_PLAIN = (bool, int, float, str, tuple)


def revision(*modules: ModuleType) -> int:
    """Return a number made from the compiled functions and plain constants of `modules`.

    numba's cache on disk looks at the file of the function it keeps, not at the files of the functions that one calls.
    An entry that closes over this number is compiled anew when any of them changes, because numba's key holds what a
    function closes over. Limits: a constant array is not looked at.
    """
    digest = sha256()
    for module in modules:
        for name, value in sorted(vars(module).items()):
            if isinstance(value, CPUDispatcher):
                code = value.py_func.__code__
                told = sorted(value.targetoptions.items(), key=str)
                digest.update(repr((name, code.co_code, code.co_consts, code.co_names, told)).encode())
            elif isinstance(value, _PLAIN) and not name.startswith("__"):
                digest.update(repr((name, value)).encode())
    return int.from_bytes(digest.digest()[:6], "big")
