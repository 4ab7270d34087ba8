"""Every figure of a report, with its title, what it shows, and the tables behind it."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.views.figures.band_stays import band_stays_figure
from seat_gear_dynamics.views.figures.detection import detection_figure
from seat_gear_dynamics.views.figures.dwell import dwell_figure, dwell_title
from seat_gear_dynamics.views.figures.histories import histories_figure
from seat_gear_dynamics.views.figures.order_spectrum import order_spectrum_figure
from seat_gear_dynamics.views.figures.recorded_bifurcation import recorded_bifurcation_figure
from seat_gear_dynamics.views.figures.trajectory import trajectory_figure


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
    yield Drawn(
        "histories",
        "Time histories",
        "Speed of s1 with its forbidden bands, the warning level, load and both mesh forces. Lines are means over a "
        "bin of time, shades reach from the smallest to the largest value in it.",
        ("histories", "warnings"),
        histories_figure(found),
    )
    chart = "" if found.map is None else " Behind it the regime map: every node runs from rest at static deflection."
    yield Drawn(
        "trajectory",
        "Speed and load",
        f"Where the drive was; dots are larger the longer it stayed.{chart}",
        ("trajectory", *(("regime_map",) if found.map is not None else ())),
        trajectory_figure(found),
    )
    yield Drawn(
        "bands",
        "Bands",
        "How long the drive stayed in which stretch of speed, and the mesh forces there.",
        ("bands",),
        band_stays_figure(found),
    )
    yield Drawn(
        "detection",
        "Warnings against bands and regimes",
        "Left: each stay in a forbidden band with the time to the first ERROR; 0 where ERROR stood already. Right: how "
        "long which level stood while which regime was stated.",
        ("detection", "false_warnings", "regimes_by_level"),
        detection_figure(found),
    )
    yield Drawn(
        "bifurcation",
        "Bifurcation over the recorded speeds",
        "Section points of s1_s2 at mesh phase 0, run-up and run-down apart; a dwell counts with the direction from "
        "which it was reached. The model's sweep carries its state from speed to speed.",
        ("bifurcation", *(("bifurcation_model",) if found.sweep is not None else ())),
        recorded_bifurcation_figure(found),
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
