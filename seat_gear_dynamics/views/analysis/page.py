"""The report as one HTML file: figures inlined, no script, no request to any host, light and dark."""

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.analysis import Analysis
from seat_gear_dynamics.views.analysis.style_sheet import STYLE
from seat_gear_dynamics.views.analysis.words import (
    DETECTION_WORDS,
    band_notices,
    bands_words,
    counted,
    detection_values,
    outputs_words,
    seam_words,
    state_notices,
    stretch_words,
    warning_time,
)


class Picture(NamedTuple):
    """A figure that has been saved."""

    path: Path
    """PNG"""
    section: str
    caption: str
    tables: tuple[str, ...]


def page(found: Analysis, pictures: Sequence[Picture], *, version: str, tables: str = "tables") -> str:
    """Return the report's HTML; `tables` is the folder of the tables beside it, `version` the software's.

    Everything is in the page but the tables; nothing is loaded from anywhere. Raises OSError where a picture is gone.
    """
    name = escape(found.provenance.log.name)
    parts = [f"<h1>{name}</h1>", _lead(found), _tiles(found), _notices(found)]
    sections = list(dict.fromkeys(picture.section for picture in pictures))
    parts.append(_contents([*sections, "Topics", "Provenance"]))
    for section in sections:
        parts.append(f'<section id="{_anchor(section)}"><h2>{escape(section)}</h2>')
        parts += [_picture(each, tables) for each in pictures if each.section == section]
        parts += [_section_table(found, section), "</section>"]
    parts += [_topics(found), _provenance(found, version)]
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta name="color-scheme" content="light dark"><title>{name}: analysis</title><style>{STYLE}</style></head>'
        f"<body><main>\n{chr(10).join(part for part in parts if part)}\n</main></body></html>\n"
    )


def _lead(found: Analysis) -> str:
    topics = ", ".join(f"<code>{escape(topic)}</code>" for topic in found.provenance.drive_topics)
    return (
        f'<p class="lead">{found.duration:.1f} s of {escape(found.train.name)}. Speed and load from {topics}; '
        f"{outputs_words(found)}; {escape(bands_words(found))}. Forces are the model's at load scale "
        f"{found.train.model.load_scale:g}.</p>"
    )


def _tiles(found: Analysis) -> str:
    forbidden = sum(stay.seconds for stay in found.bands if stay.stretch.forbidden)
    largest = [stay.forces["s1_s2"].max for stay in found.bands if isfinite(stay.forces["s1_s2"].max)]
    tiles = [
        ("in forbidden bands", f"{forbidden:.1f} s", f"{forbidden / found.duration:.0%}" if found.duration else ""),
        *(_warning_tiles(found) if found.warned else [("warnings", "–", "the log has none")]),
        ("largest force of s1_s2", f"{max(largest):.0f} N" if largest else "–", "of the model"),
    ]
    cells = (f"<div><b>{value}</b><span>{label}</span><small>{note}</small></div>" for label, value, note in tiles)
    return f'<div class="tiles">{"".join(cells)}</div>'


def _warning_tiles(found: Analysis) -> list[tuple[str, str, str]]:
    values, levels = detection_values(found.detection), warning_time(found)
    return [
        ("ERROR stood", f"{levels['ERROR']:.1f} s", counted(values["errors"], "time")),
        ("stays missed", f"{values['missed']} of {values['stays']}", "in a band, without any ERROR"),
        ("time to ERROR", _milliseconds(values["delay_median"]), f"at most {_milliseconds(values['delay_max'])}"),
        ("ERROR outside bands", str(values["false"]), f"{values['false_that_state_chaos']} with chaos stated"),
    ]


def _milliseconds(seconds: float | None) -> str:
    return "–" if seconds is None else f"{1e3 * seconds:.0f} ms"


def _notices(found: Analysis) -> str:
    notices = state_notices(found)
    if found.damage:
        notices.append(f"Not all of the log could be read. {found.damage}")
    kept = found.provenance.log_system_hash
    if kept is not None and kept != found.provenance.system_hash:
        notices.append("The parameters used here are not those that the log was recorded with.")
    notices += band_notices(found)
    if seams := seam_words(found):
        notices.append(f"The model was {seams}.")
    if len(found.restarts) > 1:
        often = f"{len(found.restarts) - 1} times" if len(found.restarts) < 1000 else "1000 times or more"
        notices.append(f"The model was restarted {often} on the way; the first at {found.restarts[1][0]:.1f} s.")
    if found.map is not None and not found.map.belongs_to(found.train):
        notices.append("The regime map is of other parameters than those used here.")
    return "".join(f'<p class="notice">{escape(notice)}</p>' for notice in notices)


def _contents(sections: Iterable[str]) -> str:
    links = (f'<a href="#{_anchor(section)}">{escape(section)}</a>' for section in sections)
    return f"<nav>{' '.join(links)}</nav>"


def _anchor(section: str) -> str:
    return section.lower().replace(" ", "-")


def _picture(picture: Picture, tables: str) -> str:
    data = b64encode(picture.path.read_bytes()).decode()
    links = ", ".join(f'<a href="{tables}/{name}.csv">{name}.csv</a>' for name in picture.tables)
    return (
        f'<figure><img alt="{escape(picture.caption)}" src="data:image/png;base64,{data}">'
        f"<figcaption>{escape(picture.caption)} <small>Behind it: {links}</small></figcaption></figure>"
    )


def _section_table(found: Analysis, section: str) -> str:
    if section == "Bands":
        return _bands(found)
    if section == "Dwells":
        return _dwells(found)
    return _detection(found) if section.startswith("Warnings") else ""


def _bands(found: Analysis) -> str:
    head = ["|speed|", "time, s", "visits", "longest, s", "mesh", "mean, N", "rms, N", "min, N", "max, N"]
    rows = []
    for stay in found.bands:
        for n, (mesh, force) in enumerate(stay.forces.items()):
            first = [stretch_words(stay), f"{stay.seconds:.1f}", str(stay.visits), f"{stay.longest:.1f}"]
            numbers = [_number(value) for value in (force.mean, force.rms, force.min, force.max)]
            rows.append([*(first if n == 0 else [""] * 4), mesh, *numbers])
    return table(head, rows)


def _dwells(found: Analysis) -> str:
    labels = {id(motion.dwell): motion.regime.label for motion in found.motions}
    head = ["from, s", "for, s", "r/min", "N·m", "regime stated", "model's", "s1_s2 mean, N", "rms, N", "max, N"]
    rows = []
    for dwell in found.dwells.longest(40):
        stated = ", ".join(f"{name} {share:.0%}" for name, share in dwell.regimes.items()) or "–"
        mean, _, most, rms = dwell.force[0].tolist()
        begin = [f"{dwell.begin:.1f}", f"{dwell.seconds:.1f}", f"{dwell.speed / RPM:.0f}", f"{dwell.load:.0f}"]
        rows.append([*begin, stated, labels.get(id(dwell), "–"), _number(mean), _number(rms), _number(most)])
    more = found.dwells.count - len(rows)
    note = f"<p><small>and {more} shorter dwells, in dwells.csv</small></p>" if more > 0 else ""
    return (table(head, rows) + note) if rows else "<p>The drive never stood long enough for a dwell.</p>"


def _detection(found: Analysis) -> str:
    columns = {"against the bands": found.detection}
    if found.map_detection is not None:
        columns["against the chaos of the map's own nodes"] = found.map_detection
    values = [detection_values(each) for each in columns.values()]
    rows = [[words, *(_short(each[name]) for each in values)] for name, words in DETECTION_WORDS.items()]
    return table(["", *columns], rows)


def _topics(found: Analysis) -> str:
    rows = [[f.topic, str(f.count), _number(1e3 * f.period), _number(1e3 * f.longest_gap)] for f in found.flows]
    body = table(["topic", "messages", "median period, ms", "longest gap, ms"], rows)
    return f'<section id="topics"><h2>Topics</h2>{body}</section>'


def _provenance(found: Analysis, version: str) -> str:
    p = found.provenance
    rows = [
        ["log", str(p.log)],
        *([f"file {name}", f"{size} bytes, sha256 {digest}"] for name, size, digest in p.files),
        ["recorded by version", p.log_version or "another program"],
        *([f"noted in the log: {what}", value] for what, value in p.notes),
        ["bands that the log's warnings name", ", ".join(found.stated_bands) or "none"],
        ["bands used here", found.judged_by.label],
        ["parameters in the log", p.log_system_hash or "none"],
        ["parameters used here", p.system_hash],
        ["analysed by version", version],
    ]
    text = escape(p.system_text)
    return (
        f'<section id="provenance"><h2>Provenance</h2>{table(["", ""], rows)}'
        f"<details><summary>Parameters used here</summary><pre>{text}</pre></details></section>"
    )


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return an HTML table of texts."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def _number(value: float) -> str:
    return f"{value:.1f}" if isfinite(value) else "–"


def _short(value: Any) -> str:
    if value is None:
        return "–"
    return f"{value:.3f} s" if isinstance(value, float) else str(value)
