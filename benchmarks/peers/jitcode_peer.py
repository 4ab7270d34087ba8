"""JiTCODE: the equations written as symbols, compiled by a C compiler, integrated by SciPy's compiled integrators.

As its documentation has it, `integrate` is called for each time whose state is wanted, here the end of each period.
"""

import warnings
from collections.abc import Sequence
from importlib import import_module
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.pair import Pair, harmonics, slope, value
from benchmarks.peers.task import Run, Task

Array = NDArray[np.float64]

INTEGRATORS = ("dopri5", "dop853")
"""Its explicit integrators that are compiled; vode and lsoda want a Jacobian, which f(δ) does not have at its ends."""


class JitCode:
    """One motion after the other, by one of INTEGRATORS; raises ImportError where JiTCODE is absent."""

    def __init__(self, task: Task, settings: Sequence[float], integrator: str, *, form: str = "printed") -> None:
        self.settings = settings
        self._task, self._pair, self._integrator = task, task.pair(form), integrator
        self._ode = compiled(self._pair)

    def prepare(self, setting: float) -> Run:
        """Return the run at a tolerance, relative and absolute."""

        def run() -> Array:
            return np.array([self._one(float(frequency), setting) for frequency in self._task.frequencies])

        return run

    def _one(self, frequency: float, tolerance: float) -> Array:
        ode = self._ode
        ode.set_parameters(frequency)
        ode.set_integrator(self._integrator, rtol=tolerance, atol=tolerance, nsteps=10**7)
        ode.set_initial_value(self._pair.rest, 0.0)
        state = self._pair.rest
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that a solver thinks the problem stiff, or was given few steps
            for end in 2 * pi / frequency * np.arange(1, self._task.periods + 1):
                state = ode.integrate(end)
        return np.asarray(state)


def compiled(pair: Pair) -> Any:
    """Return the compiled equations; the frequency is their parameter."""
    jitcode: Any = import_module("jitcode")
    se: Any = import_module("symengine")
    n, omega = pair.coordinates, se.Symbol("Omega")
    q, v = ([jitcode.y(k * n + i) for i in range(n)] for k in (0, 1))
    turning = [(se.Symbol(f"C{k}"), se.Symbol(f"S{k}")) for k in range(1, harmonics((pair.kappa, pair.error)) + 1)]
    first = turning[0]
    helpers = [(first[0], se.cos(omega * jitcode.t)), (first[1], se.sin(omega * jitcode.t))]
    for (c0, s0), (c, s) in pairwise(turning):
        helpers += [(c, c0 * first[0] - s0 * first[1]), (s, s0 * first[0] + c0 * first[1])]
    delta, rate, force, h = se.Symbol("delta"), se.Symbol("rate"), se.Symbol("force"), pair.half_backlash
    helpers += [
        (delta, _closed(pair, q) - value(pair.error, turning)),
        (rate, _closed(pair, v) - omega * slope(pair.error, turning)),
        # f(δ) without a branch: δ less its part within the backlash.
        (
            force,
            value(pair.kappa, turning) * (delta - (se.Abs(delta + h) - se.Abs(delta - h)) / 2)
            + pair.mesh_damping * rate,
        ),
    ]
    numbers = zip(pair.drive.tolist(), pair.stiffness.tolist(), pair.damping.tolist(), pair.gain.tolist(), strict=True)
    pushed = [d - k * q[i] - c * v[i] - g * force for i, (d, k, c, g) in enumerate(numbers)]
    ode = jitcode.jitcode([*v, *pushed], helpers=helpers, control_pars=[omega], verbose=False)
    # What is common stands in the helpers already; to simplify the rest would need sympy too.
    ode.generate_f_C(simplify=False, do_cse=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        ode.compile_C()
    return ode


def _closed(pair: Pair, coordinates: Sequence[Any]) -> Any:
    return sum(w * x for w, x in zip(pair.closing.tolist(), coordinates, strict=True))
