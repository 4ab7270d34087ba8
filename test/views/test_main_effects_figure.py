"""The figure of main effects: what is drawn, and what is refused."""

from pathlib import Path

import pytest

from seat_gear_dynamics.views.figures.main_effects import MainEffect, main_effects
from seat_gear_dynamics.views.figures.style import save

EFFECTS = [
    MainEffect("load", "N·m", (300.0, 600.0, 900.0), (1.0, 3.0, 2.0), 0.75, False),
    MainEffect("backlash", "µm", (10.0, 20.0), (2.1, 1.9), 0.01, True),
]


def test_every_factor_has_a_panel_with_its_levels_units_and_share() -> None:
    figure = main_effects(EFFECTS, mean=2.0, title="Main effects on vibration")
    panels = figure.axes
    assert [panel.get_xlabel() for panel in panels] == ["load\n(N·m)", "backlash\n(µm)"]
    assert [panel.get_title() for panel in panels] == ["75.0%", "1.0% pooled"]
    assert [label.get_text() for label in panels[0].get_xticklabels()] == ["300", "600", "900"]
    assert panels[0].get_ylabel() == "mean S/N ratio (dB)"
    assert panels[0].get_ylim() == panels[1].get_ylim()
    assert figure.get_suptitle() == "Main effects on vibration"


def test_the_ratios_are_drawn_and_the_best_is_ringed() -> None:
    for panel, effect in zip(main_effects(EFFECTS, mean=2.0, title="").axes, EFFECTS, strict=True):
        mean, curve, ring = panel.lines
        assert list(mean.get_ydata()) == [2.0, 2.0]
        assert list(curve.get_ydata()) == list(effect.ratios)
        assert list(ring.get_ydata()) == [max(effect.ratios)]
        assert list(ring.get_xdata()) == [effect.ratios.index(max(effect.ratios))]
        assert (curve.get_linestyle() == "--") == effect.pooled


def test_one_factor_is_enough_and_the_picture_is_written(tmp_path: Path) -> None:
    path = tmp_path / "effects.png"
    save(main_effects(EFFECTS[:1], mean=2.0, title="One"), path)
    assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("effects", "said"),
    [([], "0 effects to draw"), ([MainEffect("load", "N·m", (1.0, 2.0), (1.0,), 0.5, False)], "2 levels and 1 ratios")],
)
def test_effects_that_cannot_be_drawn_are_refused(effects: list[MainEffect], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        main_effects(effects, mean=0.0, title="")
