"""`seat-gear replay`: the monitor's outputs again from the log's inputs, or what they would have been."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.commands.texts import Texts

if TYPE_CHECKING:
    from seat_gear_dynamics.logs.analysis.rerun_result import Rerun

TEXTS = {
    "replay": Texts(
        "the monitor's outputs again from a log's inputs, compared bit for bit; with other parameters: what if",
        "seat-gear replay my_run --set meshes.s1_s2.damping_ratio=0.09",
    )
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("log", metavar="LOG", type=Path, help="bag directory or .mcap file")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter of the system by its path, in its unit, or of the monitor by its name; may be repeated",
    )
    parser.add_argument(
        "--map",
        type=Path,
        metavar="F.npz",
        help="judge warnings by this map, or `packaged` (default: published bands, or the packaged map if logged)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Replay and compare; exit code 1 where anything differs, unless other parameters were asked for."""
    from seat_gear_dynamics.commands.progress import progress
    from seat_gear_dynamics.gears import load_train
    from seat_gear_dynamics.gears.description import parse_train
    from seat_gear_dynamics.logs.analysis.band_source import band_source
    from seat_gear_dynamics.logs.analysis.rerun import rerun
    from seat_gear_dynamics.logs.analysis.what_if import monitor_settings, recorded_bands, split, with_values
    from seat_gear_dynamics.logs.reader import Bag
    from seat_gear_dynamics.sensing import MapBands

    system, monitor = split(arguments.set)
    bag = Bag(arguments.log)
    kept, logged = (bag.metadata or {}).get("system"), recorded_bands(bag)
    train = load_train(arguments.system) if arguments.system or not kept else parse_train(kept)
    settings, bands = monitor_settings(monitor), band_source(train, arguments.map, logged)
    if isinstance(bands, MapBands):  # published ones are those of the train that is replayed
        settings = settings._replace(bands=bands)
    if system:
        train = parse_train(with_values(train.text, system))
    other = settings.bands is not None and settings.bands.label != logged
    what_if = bool(arguments.system or arguments.set or other)
    with progress("replay", quiet=arguments.json) as tell:
        found = rerun(arguments.log, train, settings, tell)
    print(json.dumps(_values(found, what_if=what_if)) if arguments.json else "\n".join(_lines(found, what_if=what_if)))
    return 0 if what_if or found.identical else 1


def _values(found: "Rerun", *, what_if: bool) -> dict[str, Any]:
    from dataclasses import asdict
    from math import isfinite

    from seat_gear_dynamics.logs.analysis.what_if import other_bands
    from seat_gear_dynamics.views.colours import LEVEL_NAMES

    def finite(values: dict[str, float]) -> dict[str, float | None]:
        return {name: value if isfinite(value) else None for name, value in values.items()}

    logged, replayed = found.level_seconds
    return {
        "samples": found.samples,
        "messages": found.messages,
        "equal": found.equal,
        "identical": found.identical,
        "first_difference": found.first_difference,
        "begins": found.begins,
        "what_if": what_if,
        "topics": [asdict(each) for each in found.topics],
        "bands": {"logged": found.bands[0], "replayed": found.bands[1]},
        "other_bands": other_bands(*found.bands),
        "setting_changes": found.setting_changes,
        "thresholds": None if what_if else found.threshold_words,
        "damage": found.damage,
        "windows_before_log": found.windows_before_log,
        "silences": found.silences,
        "forces": {m: {"logged": finite(a), "replayed": finite(b)} for m, (a, b) in found.forces.items()},
        "level_seconds": {
            name: {"logged": logged.get(level, 0.0), "replayed": replayed.get(level, 0.0)}
            for level, name in enumerate(LEVEL_NAMES)
        },
    }


def _lines(found: "Rerun", *, what_if: bool) -> list[str]:
    from seat_gear_dynamics.logs.analysis.what_if import other_bands

    begins = "" if found.begins == "first input" else f", from the {found.begins} in the log on"
    lines = [f"{found.samples} samples replayed{begins}"]
    lines += [f"  {each.topic:32s}{each.equal:8d} of {each.messages} equal bit for bit" for each in found.topics]
    if found.windows_before_log:
        lines.append("  1 first force window began before the log's first force message and is not compared")
    if found.silences:
        lines.append(f"  {found.silences} warnings of silence are taken over from the log")
    different = other_bands(*found.bands)
    if different:
        lines.append(f"  {different}")
    if found.setting_changes:
        lines.append(f"  changes of the monitor's parameters in the log, which are followed: {found.setting_changes}")
    if found.damage:
        lines.append(f"  the log is damaged: {found.damage}")
    if what_if:
        lines += _what_if_lines(found)
    elif found.first_difference:
        lines.append(f"first difference: {found.first_difference}")
        lines += [found.threshold_words] if found.threshold_words else []
    return lines


def _what_if_lines(found: "Rerun") -> list[str]:
    from seat_gear_dynamics.views.colours import LEVEL_NAMES

    lines = [f"{'':24s}{'logged':>12s}{'what if':>12s}"]
    for mesh, (logged, replayed) in found.forces.items():
        lines += [f"{f'{mesh} {name}, N':24s}{logged[name]:12.1f}{replayed[name]:12.1f}" for name in logged]
    for level, name in enumerate(LEVEL_NAMES):
        before, after = (seconds.get(level, 0.0) for seconds in found.level_seconds)
        lines.append(f"{f'{name}, s':24s}{before:12.1f}{after:12.1f}")
    return lines
