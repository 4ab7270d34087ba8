"""SciPy's RK45 on a right-hand side that numba compiled: what most people would write, with its slowest part mended."""

from collections.abc import Sequence
from math import pi
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.peers.pair import harmonics
from benchmarks.peers.task import Run, Task

Array = NDArray[np.float64]


class ScipyRk45:
    """One motion after the other; the dense output gives the ends of the periods."""

    def __init__(self, task: Task, settings: Sequence[float], *, form: str = "printed") -> None:
        self.settings = settings
        self._task, self._pair = task, task.pair(form)
        pair, count = self._pair, harmonics((self._pair.kappa, self._pair.error))
        rows = np.array([pair.closing, pair.stiffness, pair.damping, pair.gain, pair.drive])
        table = np.zeros((4, count))
        parts = (pair.kappa.cosine, pair.kappa.sine, pair.error.cosine, pair.error.sine)
        for row, part in zip(table, parts, strict=True):
            row[: len(part)] = part
        numbers = np.array([pair.mesh_damping, pair.half_backlash, pair.kappa.mean, pair.error.mean])
        self._arguments = (rows, table, numbers)

    def prepare(self, setting: float) -> Run:
        """Return the run at a tolerance, relative and absolute."""

        def run() -> Array:
            return np.array([self._one(float(frequency), setting) for frequency in self._task.frequencies])

        return run

    def _one(self, frequency: float, tolerance: float) -> Array:
        ends = 2 * pi / frequency * np.arange(1, self._task.periods + 1)
        found = solve_ivp(
            field,
            (0.0, ends[-1]),
            self._pair.rest,
            method="RK45",
            t_eval=ends,
            rtol=tolerance,
            atol=tolerance,
            args=(frequency, *self._arguments),
        )
        return np.asarray(found.y[:, -1])


def _field(t: float, state: Array, frequency: float, rows: Array, table: Array, numbers: Array) -> Array:
    n = rows.shape[1]
    c1, s1 = np.cos(frequency * t), np.sin(frequency * t)
    c, s, kappa, delta, rate = 1.0, 0.0, numbers[2], -numbers[3], 0.0
    for k in range(table.shape[1]):
        c, s = c * c1 - s * s1, s * c1 + c * s1
        kappa += table[0, k] * c + table[1, k] * s
        delta -= table[2, k] * c + table[3, k] * s
        rate -= frequency * (k + 1) * (table[3, k] * c - table[2, k] * s)
    for i in range(n):
        delta += rows[0, i] * state[i]
        rate += rows[0, i] * state[n + i]
    force = kappa * (delta - min(max(delta, -numbers[1]), numbers[1])) + numbers[0] * rate
    out = np.empty(2 * n)
    for i in range(n):
        out[i] = state[n + i]
        out[n + i] = rows[4, i] - rows[1, i] * state[i] - rows[2, i] * state[n + i] - rows[3, i] * force
    return out


field: Any = njit(_field)
"""field(t, state (2n,), frequency, rows (5, n), table (4, harmonics), numbers (4,)): d(state)/dτ, (2n,)."""
