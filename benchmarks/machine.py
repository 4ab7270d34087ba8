"""Which machine, and which software on it: what has to stand beside figures that others are to compare with."""

import platform
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from os import cpu_count, getloadavg
from pathlib import Path
from typing import Any

import llvmlite.binding  # type: ignore[import-untyped]  # what numba compiles with

PEERS = ("heyoka", "jitcode")


def description() -> dict[str, Any]:
    """Return the machine and its software as plain values; `load_average` is of the last minute."""
    features = llvmlite.binding.get_host_cpu_features()
    return {
        "processor": _processor(),
        "compiled_for": llvmlite.binding.get_host_cpu_name(),
        "vector_bits": 512 if features.get("avx512f") else 256 if features.get("avx2") else 128,
        "processors": cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "load_average": getloadavg()[0],
        "packages": {name: _version(name) for name in ("numpy", "scipy", "numba", "llvmlite", *PEERS)},
    }


def same_machine(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Return whether two descriptions are of one kind of machine with the same Python and packages."""
    names = ("processor", "compiled_for", "vector_bits", "processors", "system", "python", "packages")
    return all(one.get(name) == other.get(name) for name in names)


def installed(package: str) -> bool:
    """Return whether a package can be imported, without importing it."""
    return find_spec(package) is not None


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "unknown")
