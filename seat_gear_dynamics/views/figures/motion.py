"""One motion in the paper's form: time history, phase portrait and Poincaré section side by side (Figs 9-10, 12-14)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.views.figures.style import LINE_COLOURS, new_figure

Array = NDArray[np.float64]


def draw_motion(tau: Array, delta: Array, rate: Array, section: Array, *, title: str, half_backlash: float) -> Any:
    """Return the figure of one mesh's motion.

    `tau` (n,), `delta` and `rate` (n,) in units of b_c and of b_c per τ, `section` (m, 2) in the same units;
    `half_backlash` in b_c marks where teeth part.
    """
    figure, axes = new_figure(1, 3, width=10.5, height=3.4)
    time, portrait, poincare = axes
    time.plot(tau, delta, color=LINE_COLOURS[0], linewidth=0.9)
    time.axhline(half_backlash, color="#7F7F7F", linewidth=0.8, linestyle="--")
    time.axhline(-half_backlash, color="#7F7F7F", linewidth=0.8, linestyle="--")
    time.set(xlabel="dimensionless time τ", ylabel="δ/b_c", title="time history")
    portrait.plot(delta, rate, color=LINE_COLOURS[0], linewidth=0.6)
    portrait.axvline(half_backlash, color="#7F7F7F", linewidth=0.8, linestyle="--")
    portrait.set(xlabel="δ/b_c", ylabel="dδ/dτ / b_c", title="phase portrait")
    poincare.plot(section[:, 0], section[:, 1], ".", color=LINE_COLOURS[1], markersize=3, markeredgewidth=0)
    poincare.set(xlabel="δ/b_c", ylabel="dδ/dτ / b_c", title="Poincaré section")
    _give_room(poincare, section, np.column_stack([delta, rate]))
    figure.suptitle(title)
    return figure


def _give_room(axes: Any, section: Array, portrait: Array) -> None:
    """Keep a single point from filling its axes: show at least a twentieth of the portrait's extent."""
    for k, setter in enumerate((axes.set_xlim, axes.set_ylim)):
        low, high = float(section[:, k].min()), float(section[:, k].max())
        least = 0.05 * float(np.ptp(portrait[:, k]))
        margin = max(0.08 * (high - low), (least - (high - low)) / 2)
        setter(low - margin, high + margin)
