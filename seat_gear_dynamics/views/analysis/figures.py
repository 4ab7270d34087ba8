"""Every figure of a report, with its title, what it shows, and the tables behind it."""

from collections.abc import Iterator
from math import isfinite
from typing import Any, NamedTuple

from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.views.analysis import banded
from seat_gear_dynamics.views.analysis.words import bands_words
from seat_gear_dynamics.views.figures.detection import detection_figure
from seat_gear_dynamics.views.figures.dwell import dwell_figure, dwell_title
from seat_gear_dynamics.views.figures.order_spectrum import order_spectrum_figure

_NEAREST = (
    " Time counts beside the load of the map that is nearest, in or out of a band by the load at hand; edges are those "
    "in the middle of the loads at which the drive was there."
)


class Drawn(NamedTuple):
    """A figure of a report."""

    name: str
    """Of its file, without an ending."""
    section: str
    """Heading it stands under."""
    caption: str
    tables: tuple[str, ...]
    """Names of the tables behind it."""
    figure: Any


def figures(found: Analysis) -> Iterator[Drawn]:
    """Yield the figures of a report one after the other, so that only one is held at a time."""
    moving = found.judged_by.follows_load
    counted = _NEAREST if moving else ""
    yield Drawn(
        "histories",
        "Time histories",
        "Speed of s1 with its forbidden bands, the warning level, load and both mesh forces. Lines are means over a "
        "bin of time, shades reach from the smallest to the largest value in it.",
        ("histories", "warnings"),
        banded.histories(found),
    )
    chart = "" if found.map is None else " Behind it the regime map: every node runs from rest at static deflection."
    chart += " Hatched: the forbidden bands." if moving else ""
    yield Drawn(
        "trajectory",
        "Speed and load",
        f"Where the drive was; dots are larger the longer it stayed.{chart}",
        ("trajectory", *(("regime_map",) if found.map is not None else ())),
        banded.trajectory(found),
    )
    yield Drawn(
        "bands",
        "Bands",
        "How long the drive stayed in which stretch of speed, and the mesh forces there; "
        f"{bands_words(found)}.{counted}",
        ("bands",),
        banded.band_stays(found),
    )
    if found.warned:
        yield Drawn(
            "detection",
            "Warnings against bands and regimes",
            "Left: each stay in a forbidden band with the time to the first ERROR; 0 where ERROR stood already. Right: "
            "how long which level stood while which regime was stated.",
            ("detection", "false_warnings", "regimes_by_level"),
            detection_figure(found),
        )
    shaded = f" Shaded: the bands at {found.load:.0f} N·m." if moving and isfinite(found.load) else ""
    yield Drawn(
        "bifurcation",
        "Bifurcation over the recorded speeds",
        "Section points of s1_s2 at mesh phase 0, run-up and run-down apart; a dwell counts with the direction from "
        f"which it was reached. The model's sweep carries its state from speed to speed.{shaded}",
        ("bifurcation", *(("bifurcation_model",) if found.sweep is not None else ())),
        banded.bifurcation(found),
    )
    yield from _dwells(found)


def _dwells(found: Analysis) -> Iterator[Drawn]:
    for number, dwell in enumerate(found.drawn, start=1):
        yield Drawn(
            f"dwell_{number}",
            "Dwells",
            f"Dwell {number}: {dwell_title(dwell)}. Dashed lines mark half the backlash.",
            (f"dwell_{number}_portrait", f"dwell_{number}_section"),
            dwell_figure(found, dwell),
        )
    if any(motion.spectra for motion in found.motions):
        numbers = [n for n, dwell in enumerate(found.drawn, start=1) if _has_spectrum(found, dwell)]
        yield Drawn(
            "order_spectrum",
            "Order spectrum",
            "Mesh forces over the shaft angle of s1. A log holds forces as statistics of 20 ms, too coarse for mesh "
            "orders, so these are the model's, run along each dwell's recorded speed and load.",
            tuple(f"dwell_{n}_order_spectrum" for n in numbers),
            order_spectrum_figure(found.train, found.motions),
        )


def _has_spectrum(found: Analysis, dwell: object) -> bool:
    return any(motion.dwell is dwell and motion.spectra for motion in found.motions)
