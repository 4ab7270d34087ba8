"""The compiled kernels: generated source wrapped into a module, compiled once and handed out."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import llvmlite.binding  # type: ignore[import-untyped]  # what numba compiles with
import numba
from numba.core.compiler_lock import global_compiler_lock

from seat_gear_dynamics.motion import vectors
from seat_gear_dynamics.motion.compiling import Announce
from seat_gear_dynamics.motion.lanes import period
from seat_gear_dynamics.motion.lanes.cache import kept_module
from seat_gear_dynamics.motion.lanes.source import advance_source
from seat_gear_dynamics.motion.lanes.structure import Structure
from seat_gear_dynamics.motion.revision import revision

WIDTH = 16
"""Lanes of a block: two of the widest vectors there are; a coupled train's rows then fit a first-level cache."""

_HEAD = '''\
"""Lane kernel; generated, and compiled for {cpu} by numba {numba}."""

from numba import njit

from seat_gear_dynamics.motion.lanes.period import lay_out, mark_diverged, rescale, take_section
from seat_gear_dynamics.motion.vectors import align_stack

# Multiplications and additions may be fused, in all lanes alike. No other licence: NaN and infinity must stay visible.
compiled = {{"cache": {cache}, "nogil": True, "error_model": "numpy", "fastmath": {{"contract"}}}}

'''

_MARCH = """\


@njit(
    "void(f8[::1], f8[::1], f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[:, ::1], i8, i8, i8, i8,"
    " f8[::1], f8[::1], f8[:, :, ::1], f8[:, ::1], b1[::1])",
    **compiled,
)
def march(lanes, excitation, first, second, runout, turning, base, parts, begin, periods,
          half_step, growth, sections, growths, diverged):
    varies = parts > 1 or second.shape[0] > 0 or runout.shape[0] > 0
    for period in range(periods):
        for part in range((begin + period) * parts, (begin + period + 1) * parts):
            if varies or period == 0:
                lay_out(excitation, first, second, runout, turning, base, part)
            if part == begin * parts:
                mark_diverged(lanes, {width}, {meshes}, excitation, 0, diverged)
            advance(lanes, excitation, base)
            if {tangent_rows}:
                rescale(lanes, {width}, {zq}, {zv}, {tangent_rows}, half_step, growth)
            if mark_diverged(lanes, {width}, {meshes}, excitation, 2 * base, diverged):
                return
        if sections.shape[0]:
            take_section(lanes, {width}, {meshes}, excitation, base, half_step, sections[period])
            growths[period, :] = growth
        growth[:] = 0.0
"""


@dataclass(frozen=True)
class Kernel:
    """A compiled kernel."""

    structure: Structure
    width: int
    """Lanes of a block."""
    march: Callable[..., None]
    """Marches a block through whole mesh periods; see its source."""
    dispatcher: Any
    """Numba's own object of the step, for those who look at its machine code."""


_kernels: dict[tuple[Structure, int], Kernel] = {}


def kernel(structure: Structure, *, width: int = WIDTH, announce: Announce | None = None) -> Kernel:
    """Return the compiled kernel of `structure` for blocks of `width` lanes.

    The first call on a machine compiles it, which takes some seconds; `announce` gets a sentence before that. Later
    processes load it from the cache. Safe to call from several threads.
    """
    with global_compiler_lock:  # two threads that want the same kernel must not both compile it
        key = structure, width
        if key not in _kernels:
            # What a kernel calls is linked into its machine code, so its text is part of what must not change.
            module = kept_module(
                kernel_source(structure, width, cache=True),
                kernel_source(structure, width, cache=False),
                rests_on=f"{inspect.getsource(period)}{revision(vectors)}",
                announce=announce,
            )
            _kernels[key] = Kernel(structure, width, module.march, module.advance)
        return _kernels[key]


def _processor() -> str:
    settings: Any = numba.config
    return str(settings.CPU_NAME or llvmlite.binding.get_host_cpu_name())


def kernel_source(structure: Structure, width: int, *, cache: bool) -> str:
    """Return the whole source of a kernel's module, with or without numba's cache."""
    head = _HEAD.format(cpu=_processor(), numba=numba.__version__, cache=cache)
    rows = structure.row
    definition = "def advance(lanes, excitation, count):\n"
    decorated = advance_source(structure, width).replace(
        definition, f'@njit("void(f8[::1], f8[::1], i8)", **compiled)\n{definition}    align_stack()\n'
    )
    return (
        head
        + decorated
        + _MARCH.format(
            width=width,
            meshes=structure.meshes,
            tangent_rows=4 * structure.tangent_meshes,
            zq=rows["ZQ0"],
            zv=rows["ZV0"],
        )
    )
