"""The main effects of a Taguchi study: mean signal-to-noise ratio against the levels of each factor."""

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import Any

from seat_gear_dynamics.studies.taguchi.result import Study
from seat_gear_dynamics.views.figures.style import LINE_COLOURS, Axes, chosen, in_style, new_figure

_MOST_LETTERS = 12  # of the levels of a factor that fit beside each other
_KEPT, _POOLED, _BEST = LINE_COLOURS[0], "#9A9A9A", LINE_COLOURS[1]


@dataclass(frozen=True)
class MainEffect:
    """What one panel shows."""

    name: str
    unit: str
    levels: Sequence[float]
    """Values of the levels in `unit`, shape (n,)."""
    ratios: Sequence[float]
    """Mean ratio of each level, dB, shape (n,)."""
    contribution: float
    """Share of the total sum of squares, 0 to 1."""
    pooled: bool
    """True for a factor that is counted into the error; drawn grey and broken."""


@in_style
def main_effects(effects: Sequence[MainEffect], *, mean: float, title: str) -> Any:
    """Return a figure with one panel for each factor, on one scale of dB; the best level is ringed.

    `mean` is the overall mean ratio, dB. Levels stand at equal distances, whatever their values. Raises ValueError
    without an effect, and where an effect has not as many ratios as levels.
    """
    if not effects:
        raise ValueError("There are 0 effects to draw, expected at least 1.")
    for effect in effects:
        if len(effect.levels) != len(effect.ratios):
            raise ValueError(
                f"{effect.name} has {len(effect.levels)} levels and {len(effect.ratios)} ratios; expected as many."
            )
    width = max(4.0, 1.5 * len(effects))
    figure, axes = new_figure(1, len(effects), width=width, height=3.2, sharey=True, squeeze=False)
    for panel, effect in zip(axes[0], effects, strict=True):
        _draw(panel, effect, mean)
    axes[0][0].set_ylabel("mean S/N ratio (dB)")
    figure.suptitle(title, fontsize=10, fontweight="bold")
    figure.supxlabel("level of the factor; above: share of the sum of squares; ringed: best level", fontsize=8)
    return figure


def plot_study(axes: Axes, study: Study, *, response: str = "") -> None:
    """Draw the main effects on `response`, by default the first one analysed, all factors side by side in one panel.

    Pooled factors are grey and broken; the best level is ringed. Raises ValueError where the response is not among
    those that carry an analysis.
    """
    analysed = {name: finding.analysis for name, finding in study.findings.items() if finding.analysis is not None}
    response = response or next(iter(analysed), response)
    analysis = chosen(response, analysed)
    first = 0
    ticks: dict[int, str] = {}
    for factor, source in zip(study.factors, analysis.factors, strict=True):
        ratios = analysis.effects[factor.name]
        places = list(range(first, first + len(ratios)))
        _draw_effect(axes, places, ratios, pooled=source.pooled)
        title = f"{fill(factor.name, 10)}\n{factor.unit}\n{source.contribution:.1%}"
        axes.annotate(
            title,
            (sum(places) / len(places), 1.0),
            (0, 4),
            xycoords=axes.get_xaxis_transform(),
            textcoords="offset points",
            ha="center",
            fontsize=7,
        )
        ticks |= {place: f"{level:.3g}" for place, level in zip(places, factor.levels, strict=True)}
        first += len(ratios) + 1
    axes.axhline(analysis.mean, color="#000000", linewidth=0.8, linestyle=":")
    axes.set_xticks(list(ticks), list(ticks.values()), rotation=90)
    axes.set(
        xlabel="level of the factor; above: its unit and share",
        ylabel=f"mean S/N ratio of {response}, dB",
    )


def _draw(panel: Axes, effect: MainEffect, mean: float) -> None:
    places = range(len(effect.levels))
    panel.axhline(mean, color="#000000", linewidth=0.8, linestyle=":")
    _draw_effect(panel, places, effect.ratios, pooled=effect.pooled)
    levels = [f"{value:.4g}" for value in effect.levels]
    panel.set_xticks(list(places), levels, rotation=90 if sum(map(len, levels)) > _MOST_LETTERS else 0)
    panel.set_xlim(-0.4, len(effect.levels) - 0.6)
    panel.set_xlabel(f"{effect.name}\n({effect.unit})")
    panel.set_title(f"{effect.contribution:.1%}{' pooled' if effect.pooled else ''}", fontweight="normal", fontsize=9)


def _draw_effect(axes: Axes, places: Sequence[int], ratios: Sequence[float], *, pooled: bool) -> None:
    best = max(range(len(ratios)), key=lambda index: ratios[index])
    axes.plot(
        places, ratios, color=_POOLED if pooled else _KEPT, linestyle="--" if pooled else "-", marker="o", markersize=4
    )
    axes.plot(places[best], ratios[best], marker="o", markersize=10, markerfacecolor="none", color=_BEST)
