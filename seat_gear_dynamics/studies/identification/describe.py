"""A fit in words, as plain values, and written into the text of a system description."""

import re
from typing import Any

import yaml

from seat_gear_dynamics.gears.units import RPM, to_si
from seat_gear_dynamics.studies.identification.identify import Estimate, Fitted

_SOURCE = "fit to a recorded bench, seat-gear calibrate LOG, docs/identification.md"
_DIGITS = 6
_DIMENSIONS = {
    "time_scale": "angular velocity",
    "damping": "number",
    "stiffness": "stiffness",
    "backlash": "length",
    "load_scale": "number",
}


def described(text: str, fitted: Fitted) -> str:
    """Return the description `text` (YAML) with the parameters that were fitted, marked as calibrated.

    Values stand in the unit that the description has for them, to six digits; those that were held stay as they were.
    A description of one parameter a line keeps its lines and comments, any other is written anew. The result opens
    with `load_system`. Limit: a published band or regime map belongs to the parameters before.
    """
    for each in fitted.estimates:
        if each.parameter.path and not each.held:
            text = _with_value(text, each)
    if not fitted.train.meshes[0].scale_to_mean or _kept(fitted, "stiffness"):
        return text
    return _with_flag(text, "meshes.s1_s2.scale_to_mean")


def values(fitted: Fitted) -> dict[str, Any]:
    """Return the fit as plain values, None where there is no number."""
    sure = fitted.confidence
    names = [each.parameter.name for each in fitted.estimates]
    return {
        "sensor": {"kind": fitted.sensor.kind, "gear": fitted.sensor.gear, "unit": fitted.sensor.unit},
        "dwells": len(fitted.observed),
        "dwells_used": int(fitted.used.sum()),
        "left_out": {str(d + 1): reason for d, reason in enumerate(fitted.left_out) if reason},
        "parameters": {each.parameter.name: _estimate(each) for each in fitted.estimates},
        "not_identified": [each.parameter.name for each in fitted.estimates if each.interval is None],
        "correlation": {
            a: {b: _finite(sure.correlation[i, j]) for j, b in enumerate(names)} for i, a in enumerate(names)
        },
        "singular_values": [float(s) for s in sure.singular_values],
        "condition": _finite(sure.condition),
        "weakest_direction": dict(zip(names, map(float, sure.weakest), strict=True)),
        "residual_scale": fitted.residual_scale,
        "cost": fitted.solution.cost,
        "searches_agreeing": fitted.searches[0],
        "searches": fitted.searches[1],
    }


def lines(fitted: Fitted) -> list[str]:
    """Return the fit in lines for a terminal."""
    sure = fitted.confidence
    found = [
        f"{int(fitted.used.sum())} of {len(fitted.observed)} dwells fitted, sensor: {_sensor(fitted)}",
        *_left_out(fitted),
        f"{'parameter':12s}{'start':>12s}{'fitted':>12s}  {'95 % interval':27s}{'by drawing dwells':27s}",
    ]
    for each in fitted.estimates:
        name, unit = each.parameter.name, each.parameter.unit
        row = f"{name:12s}{each.start:12.5g}{each.value:12.5g}  "
        if each.interval is None or each.bootstrap is None:
            found.append(row + _unknown(each))
        else:
            found.append(
                f"{row}{_span(each.interval):27s}{_span(each.bootstrap):27s}{unit if unit != '1' else ''}".rstrip()
            )
    found.append(
        f"residuals are {fitted.residual_scale:.2g} of the stated errors; "
        f"condition of the Jacobian {sure.condition:.3g}; {fitted.searches[0]} of {fitted.searches[1]} searches agree"
    )
    return found


def _sensor(fitted: Fitted) -> str:
    where = "mesh force of s1_s2" if fitted.sensor.kind == "force" else f"acceleration of {fitted.sensor.gear}"
    return f"{where}, {fitted.sensor.unit}"


def _left_out(fitted: Fitted) -> list[str]:
    drives = fitted.drives
    return [
        f"left out: dwell {d + 1}, {drives.speed[d] / RPM:.0f} r/min at {drives.load[d]:.0f} N·m: {reason}"
        for d, reason in enumerate(fitted.left_out)
        if reason
    ]


def _unknown(each: Estimate) -> str:
    beside = f", nor it from {' and '.join(each.confused_with)}" if each.confused_with else ""
    kept = "; held at its start" if each.held else ""
    return f"not identified: the record does not tell it{beside}{kept}"


def _span(interval: tuple[float, float]) -> str:
    return f"{interval[0]:.5g} to {interval[1]:.5g}"


def _estimate(each: Estimate) -> dict[str, Any]:
    return {
        "path": each.parameter.path or None,
        "unit": each.parameter.unit,
        "start": each.start,
        "value": each.value,
        "interval": each.interval,
        "bootstrap": each.bootstrap,
        "identified": each.interval is not None,
        "held": each.held,
        "confused_with": list(each.confused_with),
    }


def _finite(number: float) -> float | None:
    return float(number) if abs(number) < float("inf") else None


def _kept(fitted: Fitted, name: str) -> bool:
    return all(each.held for each in fitted.estimates if each.parameter.name == name)


def _with_value(text: str, each: Estimate) -> str:
    document = yaml.safe_load(text)
    entry = _entry(document, each.parameter.path)
    unit = str(entry["unit"])
    number = each.value / to_si(each.parameter.path, 1.0, unit, _DIMENSIONS[each.parameter.name])
    return _replaced(text, each.parameter.path, f"{number:.{_DIGITS}g}", float(f"{number:.{_DIGITS}g}"))


def _with_flag(text: str, path: str) -> str:
    return text if _entry(yaml.safe_load(text), path)["value"] is True else _replaced(text, path, "true", True)


def _entry(document: Any, path: str) -> dict[str, Any]:
    for key in path.split("."):
        document = document[key]
    found: dict[str, Any] = document
    return found


def _replaced(text: str, path: str, written: str, value: float | bool) -> str:
    """Return the description with one value replaced: in its line where it has one, else in a document written anew."""
    lines, stack = text.split("\n"), [""]
    for number, line in enumerate(lines):
        if match := re.match(r"^( *)(\w+):", line):
            depth = len(match[1]) // 2
            stack = [*stack[:depth], match[2]]
            if ".".join(stack) == path and re.search(r"\{value: [^,]*, .*provenance: \w+, source: .*\}", line):
                lines[number] = _line(line, written)
                return "\n".join(lines)
    document = yaml.safe_load(text)
    _entry(document, path).update(value=value, provenance="calibrated", source=_SOURCE)
    anew: str = yaml.safe_dump(document, allow_unicode=True, sort_keys=False)
    return anew


def _line(line: str, written: str) -> str:
    changed = re.sub(r"(\{value: )[^,]*", lambda m: m[1] + written, line, count=1)
    changed = re.sub(r"provenance: \w+", "provenance: calibrated", changed, count=1)
    return re.sub(r'source: (".*"|[^}]*)\}', lambda _: f'source: "{_SOURCE}"}}', changed, count=1)
