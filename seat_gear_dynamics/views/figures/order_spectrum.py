"""Order spectra of the mesh forces in the longest dwells, with the orders at which the meshes are excited."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.logs.analysis import mesh_orders
from seat_gear_dynamics.logs.analysis.model import DwellMotion
from seat_gear_dynamics.logs.analysis.order_spectrum import OrderSpectrum
from seat_gear_dynamics.views.colours import MESH_COLOURS
from seat_gear_dynamics.views.figures.dwell import dwell_title
from seat_gear_dynamics.views.figures.style import Axes, in_style, new_figure

_FLOOR = 1e-2  # N; what lies below is rounding and window


@in_style
def order_spectrum_figure(train: GearTrain, motions: Sequence[DwellMotion]) -> Any:
    """Return the figure: a row a dwell, amplitude over order of s1; triangles above mark the mesh orders."""
    shown = [motion for motion in motions if motion.spectra]
    figure, axes = new_figure(
        max(len(shown), 1), 1, width=10.5, height=0.8 + 2.1 * max(len(shown), 1), sharex=True, squeeze=False
    )
    for panel, motion in zip(axes[:, 0], shown, strict=False):
        _draw(panel, train, motion)
    if not shown:
        axes[0, 0].text(0.5, 0.5, "no dwell is long enough", transform=axes[0, 0].transAxes, ha="center")
    axes[-1, 0].set_xlabel("order: events per revolution of s1")
    handles = [axes[0, 0].plot([], [], color=colour)[0] for colour in MESH_COLOURS]
    marks = [axes[0, 0].plot([], [], "v", color=colour, markersize=4)[0] for colour in MESH_COLOURS]
    names = [f"{m.name}{what}" for what in ("", ", mesh orders") for m in train.meshes]
    figure.legend([*handles, *marks], names, ncols=4, loc="outside upper right", frameon=False)
    return figure


def plot_spectrum(axes: Axes, found: OrderSpectrum) -> None:
    """Draw one spectrum, amplitude over order of s1."""
    axes.semilogy(found.orders, np.maximum(found.amplitude, _FLOOR), color=MESH_COLOURS[0], linewidth=0.8)
    axes.set(xlabel="order: events per revolution of s1", ylabel="amplitude of the force, N")
    axes.set_xlim(0, float(found.orders[-1]))
    axes.set_ylim(bottom=_FLOOR)


def _draw(axes: Axes, train: GearTrain, motion: DwellMotion) -> None:
    highest, most = 0.0, _FLOOR
    for spectrum in motion.spectra.values():
        highest, most = float(spectrum.orders[-1]), max(most, float(spectrum.amplitude.max()))
    for row, (mesh, spectrum) in enumerate(motion.spectra.items()):
        colour = MESH_COLOURS[row]
        axes.semilogy(spectrum.orders, np.maximum(spectrum.amplitude, _FLOOR), color=colour, linewidth=0.8)
        orders = mesh_orders(train, highest)[mesh]
        axes.plot(orders, np.full(len(orders), most * (3 if row else 6)), "v", color=colour, markersize=4)
    axes.set_ylim(_FLOOR, most * 15)
    axes.set_xlim(0, highest)
    axes.set_ylabel("amplitude, N")
    axes.set_title(f"{dwell_title(motion.dwell)}; model: {motion.regime.label}", loc="left", fontsize=8.5)
