"""The paper's figures 5-6, 8-15, 17-18 in the paper's form, from a reproduction."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from seat_gear_dynamics.gears import Mesh
from seat_gear_dynamics.studies.reproduction.run import LITTLE_DAMPING, Reproduction
from seat_gear_dynamics.studies.reproduction.survey import Seen
from seat_gear_dynamics.views.figures.contact_force import CLEARANCE_CONDITIONS, LOAD_CONDITIONS, contact_force_figure
from seat_gear_dynamics.views.figures.motion import draw_motion
from seat_gear_dynamics.views.figures.response_curve import response_curve_figure
from seat_gear_dynamics.views.figures.style import (
    LINE_COLOURS,
    REGIME_COLOURS,
    Axes,
    in_style,
    is_narrow,
    legend_columns,
    new_figure,
)


def paper_figures(found: Reproduction) -> dict[str, tuple[str, Any]]:
    """Return file name -> (caption, figure), in the paper's order."""
    return dict(_figures(found))


def _figures(found: Reproduction) -> Iterator[tuple[str, tuple[str, Any]]]:
    for number, mesh in zip((5, 6), found.system.train.meshes, strict=True):
        yield f"fig{number:02d}", (f"Fig. {number}: mesh stiffness of {mesh.name}", stiffness_figure(mesh))
    sweeps = {xi: seen for xi, seen in found.over_frequency.items() if xi != LITTLE_DAMPING}
    first = min(sweeps)
    yield (
        "fig08",
        (
            "Fig. 8: bifurcation over the mesh frequency, 600 N·m, ξ 0.07",
            bifurcation_figure({"": (_frequency(sweeps[first]), sweeps[first])}, "dimensionless mesh frequency Ω"),
        ),
    )
    motions = dict(_motion_figures(found))
    yield "fig09", motions["Fig. 9"]
    yield "fig10", motions["Fig. 10"]
    panels = {f"ξ = {xi}": (_frequency(seen), seen) for xi, seen in sorted(sweeps.items())}
    yield (
        "fig11",
        (
            "Fig. 11: the same at four damping ratios",
            bifurcation_figure(panels, "dimensionless mesh frequency Ω"),
        ),
    )
    for number in (12, 13, 14):
        yield f"fig{number}", motions[f"Fig. {number}"]
    loads = [seen.point.load for seen in found.over_load]
    yield (
        "fig15",
        (
            "Fig. 15: bifurcation over the load at Ω = 1",
            bifurcation_figure({"": (loads, found.over_load)}, "load torque T4, N·m"),
        ),
    )
    for number, conditions, text in (
        (17, CLEARANCE_CONDITIONS, "effect of backlash on the contact force (conditions 4-6)"),
        (18, LOAD_CONDITIONS, "effect of load on the contact force (conditions 7-9)"),
    ):
        figure, _ = contact_force_figure(found.conditions, found.start_ups, conditions)
        yield f"fig{number}", (f"Fig. {number}: {text}", figure)
    curve, _ = response_curve_figure(found.announced.curve, found.announced.agreements)
    yield "response_curve", ("Announced: response curve by harmonic balance, 600 N·m, crosses are integrations", curve)


@in_style
def stiffness_figure(mesh: Mesh) -> Any:
    """Return the computed mesh stiffness over two mesh periods, and what the model keeps of it."""
    figure, axes = new_figure(width=7.0, height=3.4)
    computed = mesh.computed_stiffness
    phase = np.concatenate([computed.phase, computed.phase + 1])
    axes.plot(
        phase, np.tile(computed.values, 2) / 1e8, color=LINE_COLOURS[0], label="computed, potential-energy method"
    )
    label = f"in the equations: {mesh.stiffness_harmonics} harmonics"
    if mesh.scale_to_mean:
        label += f", scaled to {mesh.mean_stiffness:.4g} N/m"
    axes.plot(phase, mesh.stiffness.value(phase) / 1e8, color=LINE_COLOURS[1], linestyle="--", label=label)
    axes.set(xlabel="mesh phase, periods", ylabel="mesh stiffness, 10⁸ N/m", ylim=(0, None))
    narrow = is_narrow(figure)
    figure.legend(loc="outside upper left", ncols=1 if narrow else 2, fontsize=7 if narrow else 8)
    return figure


@in_style
def bifurcation_figure(panels: Mapping[str, tuple[Sequence[float], Sequence[Seen]]], xlabel: str) -> Any:
    """Return section points over a parameter, a panel each for title -> (values, what was seen), colours by regime."""
    figure, axes = new_figure(
        len(panels), 1, width=7.5, height=1.2 + 2.6 * len(panels) ** 0.9, sharex=True, sharey=True, squeeze=False
    )
    for axis, (title, (values, seen)) in zip(axes[:, 0], panels.items(), strict=True):
        _scatter(axis, values, seen)
        axis.set(title=title, ylabel="δ / b_c at mesh phase 0")
    axes[-1, 0].set_xlabel(xlabel)
    met = {each.regime.name for _, found in panels.values() for each in found if each.regime}
    present: list[str] = [name for name in REGIME_COLOURS if name in met]
    handles = [axes[0, 0].plot([], [], "s", color=REGIME_COLOURS[name], markersize=6)[0] for name in present]
    figure.legend(handles, present, loc="outside upper right", ncols=legend_columns(figure))
    return figure


def _scatter(axis: Axes, values: Sequence[float], seen: Sequence[Seen]) -> None:
    for name, colour in REGIME_COLOURS.items():
        own = [(v, s.section[:, 0]) for v, s in zip(values, seen, strict=True) if s.regime and s.regime.name == name]
        if own:
            x = np.concatenate([np.full(len(points), value) for value, points in own])
            y = np.concatenate([points for _, points in own])
            size = 3.5 if name == "periodic" else 1.6
            axis.plot(x, y, ".", color=colour, markersize=size, markeredgewidth=0, rasterized=True)


def _frequency(seen: Sequence[Seen]) -> list[float]:
    return [s.point.frequency for s in seen]


def _motion_figures(found: Reproduction) -> Iterator[tuple[str, tuple[str, Any]]]:
    for name, (system, history) in found.motions.items():
        point, mesh = system.operating_point, system.train.meshes[0]
        caption = (
            f"{name}: Ω {point.frequency:.3g}, T4 {point.load:.4g} N·m, ξ {mesh.damping_ratio:g}, "
            f"b {mesh.backlash * 1e6:.3g} µm"
        )
        figure = draw_motion(
            history.tau,
            history.delta[:, 0],
            history.rate[:, 0],
            history.section,
            title=caption,
            half_backlash=mesh.backlash / 2 / system.train.model.displacement_scale,
        )
        yield name, (caption, figure)
