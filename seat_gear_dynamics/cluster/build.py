"""What the numbers of a machine depend on beside the question: code, libraries and processor, as names and values."""

import platform
from collections.abc import Iterable, Mapping
from functools import cache
from hashlib import sha256
from importlib import import_module
from pathlib import Path

Build = Mapping[str, str]

_LIBRARIES = ("numpy", "scipy", "numba", "llvmlite")
CODE = ("package", "sources", "python", *_LIBRARIES)
"""What must be the same for the same question to be asked, and answered by the same steps."""
MACHINE = ("processor", "C library")
"""What compiled code and elementary functions round by: it must be the same for answers equal to the last bit."""
_ROOMS = ("gears", "motion", "regimes", "cluster")


@cache
def build() -> Build:
    """Return the build of this process: a value for each name of CODE and MACHINE.

    Limit: an installed file that is edited after the first call is not seen, nor is one that was loaded before it was
    edited.
    """
    from seat_gear_dynamics import __version__

    return {
        "package": __version__,
        "sources": _sources(),
        "python": ".".join(platform.python_version_tuple()[:2]),
        **{name: str(import_module(name).__version__) for name in _LIBRARIES},
        "processor": _processor(),
        "C library": " ".join(platform.libc_ver()),
    }


def difference(expected: Build, found: Build, names: Iterable[str]) -> str | None:
    """Return in words the first of `names` in which two builds differ; None where they agree."""
    for name in names:
        if expected.get(name) != found.get(name):
            return f"{name} {found.get(name, 'unknown')}, expected {expected.get(name, 'unknown')}"
    return None


def _sources() -> str:
    """Return a short hash of the source of every room that numbers come from."""
    folder, digest = Path(__file__).parents[1], sha256()
    for path in sorted(path for room in _ROOMS for path in (folder / room).rglob("*.py")):
        digest.update(f"{path.relative_to(folder).as_posix()}\n".encode() + path.read_bytes())
    return digest.hexdigest()[:12]


def _processor() -> str:
    """Return the processor that numba compiles for: its name, and a short hash of the instructions it has."""
    binding, config = import_module("llvmlite.binding"), import_module("numba").config
    name = getattr(config, "CPU_NAME", None) or binding.get_host_cpu_name()
    features = getattr(config, "CPU_FEATURES", None) or binding.get_host_cpu_features().flatten()
    return f"{name}-{sha256(features.encode()).hexdigest()[:8]}"
