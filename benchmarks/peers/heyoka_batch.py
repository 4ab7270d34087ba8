"""heyoka.py in batch mode: Taylor series of high order for several motions to an instruction.

The field of each lane is that of its own branch, held until its own event detection finds δ at an end of the backlash;
the event is terminal for this lane, and its callback puts the lane on the other branch. The series of one branch knows
nothing of the other: without events it would step over contact changes.
"""

from collections.abc import Callable, Sequence
from importlib import import_module
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.pair import Pair, slope, value
from benchmarks.peers.task import Run, Task

Array = NDArray[np.float64]

_FREQUENCY, _TOUCHES, _OFFSET = 0, 1, 2  # parameters of a lane: f(δ) = touches·δ − offset


class HeyokaBatch:
    """All motions, as many at a time as the machine's vectors hold; raises ImportError where heyoka is absent."""

    def __init__(self, task: Task, settings: Sequence[float], *, form: str = "printed") -> None:
        self.settings = settings
        self._task, self._pair = task, task.pair(form)
        hy: Any = import_module("heyoka")
        self.width = int(hy.recommended_simd_size())
        if len(task.frequencies) % self.width:
            raise ValueError(f"{len(task.frequencies)} motions do not fill batches of {self.width}; ask for others.")

    def prepare(self, setting: float) -> Run:
        """Return the run at a tolerance, which sets the order of the series too."""
        integrator = _integrator(self._pair, self.width, setting)
        batches = self._task.frequencies.reshape(-1, self.width)

        def run() -> Array:
            return np.vstack([self._batch(integrator, frequencies) for frequencies in batches])

        return run

    def _batch(self, integrator: Any, frequencies: Array) -> Array:
        pair = self._pair
        integrator.set_time(0.0)
        integrator.state[:] = pair.rest[:, None]
        start = float(pair.closing @ pair.rest[: pair.coordinates]) - float(value(pair.error, _at_start(pair)))
        flank = float(np.sign(start - np.clip(start, -pair.half_backlash, pair.half_backlash)))
        integrator.pars[_FREQUENCY] = frequencies
        integrator.pars[_TOUCHES], integrator.pars[_OFFSET] = abs(flank), flank * pair.half_backlash
        integrator.reset_cooldowns()
        # The first row of the grid is where the motion stands, the others are the ends of the periods.
        grid = 2 * pi / frequencies * np.arange(self._task.periods + 1)[:, None]
        *_, states = integrator.propagate_grid(grid)
        return np.asarray(states[-1].T)


def _integrator(pair: Pair, width: int, tolerance: float) -> Any:
    hy: Any = import_module("heyoka")
    n, h = pair.coordinates, pair.half_backlash
    q, v = ([hy.make_vars(f"{kind}{i}") for i in range(n)] for kind in "qv")
    angle = hy.par[_FREQUENCY] * hy.time
    turning = [(hy.cos(k * angle), hy.sin(k * angle)) for k in range(1, len(_at_start(pair)) + 1)]
    closing = pair.closing.tolist()
    delta = sum(w * x for w, x in zip(closing, q, strict=True)) - value(pair.error, turning)
    rate = sum(w * x for w, x in zip(closing, v, strict=True)) - hy.par[_FREQUENCY] * slope(pair.error, turning)
    beyond = hy.par[_TOUCHES] * delta - hy.par[_OFFSET]
    force = value(pair.kappa, turning) * beyond + pair.mesh_damping * rate
    numbers = zip(pair.drive.tolist(), pair.stiffness.tolist(), pair.damping.tolist(), pair.gain.tolist(), strict=True)
    pushed = [(v[i], d - k * q[i] - c * v[i] - g * force) for i, (d, k, c, g) in enumerate(numbers)]
    return hy.taylor_adaptive_batch(
        [*zip(q, v, strict=True), *pushed],
        np.zeros((2 * n, width)),
        tol=tolerance,
        pars=np.zeros((3, width)),
        t_events=[
            hy.t_event_batch(delta - flank * h, callback=_switch(flank, h), direction=hy.event_direction.any)
            for flank in (1, -1)
        ],
    )


def _switch(flank: int, half_backlash: float) -> Callable[[Any, int, int], bool]:
    def switch(integrator: Any, sign: int, lane: int) -> bool:
        touches = sign == flank
        integrator.pars[_TOUCHES, lane] = float(touches)
        integrator.pars[_OFFSET, lane] = flank * half_backlash if touches else 0.0
        return True

    return switch


def _at_start(pair: Pair) -> list[tuple[float, float]]:
    return [(1.0, 0.0)] * max(len(pair.kappa.cosine), len(pair.error.cosine))
