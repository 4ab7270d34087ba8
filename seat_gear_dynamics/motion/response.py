"""The response at one operating point: run in, then sampled period by period."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, nextafter, pi

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion.history import History, history
from seat_gear_dynamics.motion.march import LONGEST_STEP, Inputs, March, Window
from seat_gear_dynamics.motion.system import System
from seat_gear_dynamics.motion.tables import TARGET_STEPS
from seat_gear_dynamics.plotting import Plottable

Array = NDArray[np.float64]
_TOLD = 64  # mesh periods between two tellings of how far a motion is


@dataclass(frozen=True)
class Response(Plottable, figure="motion:plot_section", table="motions:response_table"):
    """A motion at a steady drive, after its run-in."""

    system: System
    section: Array
    """Stroboscopic Poincaré section of P12 at mesh phase 0, shape (periods, 2): δ/b_c and its rate."""
    growth: Array
    """Logarithmic growth of a tangent over each sampled period, shape (periods, 2) for P12 and P34."""
    windows: tuple[Window, Window]
    """Dimensionless force statistics of P12 and P34 over the sampled periods."""
    state: Array
    """Final state, (24,), at mesh phase 0."""
    force_unit: float
    """N per unit of dimensionless force."""

    def history(self, *, periods: int = 12) -> History:
        """Return the motion step by step over `periods` mesh periods more, from the final state on.

        The section of the history is that of as many periods as were sampled, further on.
        """
        return history(self.system, transient=0, periods=periods, sampled=len(self.section), state=self.state)

    @property
    def period(self) -> float:
        """The mesh period of P12 in units of τ."""
        return 2 * pi / abs(self.system.operating_point.frequency)


def integrate(
    system: System,
    *,
    transient: int = 600,
    periods: int = 400,
    state: Array | None = None,
    target_steps: int = TARGET_STEPS,
    longest_step: float = LONGEST_STEP,
    progress: Callable[[int, int], None] | None = None,
) -> Response:
    """Integrate `system` over `transient` mesh periods of P12, then sample `periods` more.

    Starts at static deflection, or at `state` (24,) with mesh phase 0. Raises ValueError at zero frequency (there is
    no mesh period) and DivergedError where the solution blows up. P34 is driven at z3/z2 of the frequency. `progress`
    is told (mesh periods done, in all); it changes no number.
    """
    point = system.operating_point
    if point.frequency == 0:
        raise ValueError("The frequency is 0, where there is no mesh period to sample; give a speed other than 0.")
    if transient < 0 or periods < 1:
        raise ValueError(f"Asked for {transient} transient and {periods} sampled periods; expected at least 0 and 1.")
    march = March(system.train, load=point.load, target_steps=target_steps, longest_step=longest_step)
    if state is not None:
        march.state = state
    inputs = Inputs(point.frequency, point.load)
    period = 2 * pi / abs(point.frequency)
    tell = progress or (lambda done, total: None)
    _through(march, inputs, transient, period, [], lambda done: tell(done, transient + periods))
    collected: list[Array] = []
    windows = _through(
        march, inputs, periods, period, collected, lambda done: tell(transient + done, transient + periods)
    )
    points = np.concatenate(collected)
    return Response(system, points[:, 1:3], points[:, 3:5], windows, march.state, march.force_unit)


def _through(
    march: March, inputs: Inputs, periods: int, period: float, met: list[Array], tell: Callable[[int], None]
) -> tuple[Window, Window]:
    """March through whole periods; half a step short of the end, so that rounding of τ cannot add a step."""
    if not periods:
        return Window(), Window()

    done = 0

    def collect(points: Array) -> None:
        nonlocal done
        met.append(points)
        done += len(points)
        tell(done)

    begin = march.tau
    slack = period / march.steps_per_period / 2**8  # less than half of the finest level's step
    end = begin + periods * period - slack
    first, second = march.advance((begin, inputs), (end, inputs), collect, room=_TOLD)
    while done < periods:  # creeping steps are not locked to the period: the last section is a step ahead
        step = (march.tau, inputs), (nextafter(march.tau, inf), inputs)
        more = march.advance(*step, collect)
        first, second = first.merged(more[0]), second.merged(more[1])
    return first, second
