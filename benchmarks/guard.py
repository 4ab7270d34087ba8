"""The regression guard: the ratios of a run against those recorded last, and in words what changed.

A record stands in `recorded/`, one file for the short and one for the full form, with the machine that it was taken
on. A ratio has changed where the repeats of now and of then do not overlap: every one of now is better, or every one
worse, than all of then. That is what scatter within the runs can tell, and no more: a change need not be the code's
doing. Where both have one repeat only there is no scatter, and nothing is said. On another machine ratios may differ
for the machine's sake, and the words say that it is another.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from benchmarks.machine import same_machine
from benchmarks.ratio import Findings, Ratio

FOLDER = Path(__file__).with_name("recorded")
Verdict = Literal["better", "worse", "same", "unjudged", "new", "gone"]


@dataclass(frozen=True)
class Change:
    """What became of one ratio."""

    name: str
    verdict: Verdict
    factor: float | None
    """How many times better or worse the middle of now is than that of then, at least 1; None where one is missing."""
    now: Ratio | None
    then: Ratio | None

    @property
    def sentence(self) -> str:
        """The change in words."""
        if self.now is None:
            return f"{self.name}: recorded, but not measured now."
        if self.then is None:
            return f"{self.name}: {self.now.median:.4g}, not recorded before."
        changed = f"{self.verdict} by a factor of {self.factor:.3g}, beyond the scatter of the repeats"
        how = {
            "same": "as before, within the scatter of the repeats",
            "unjudged": "one repeat of each, so that no change can be told from scatter",
        }.get(self.verdict, changed)
        return f"{self.name}: {_told(self.now)}, was {_told(self.then)}: {how}."

    def as_dict(self) -> dict[str, Any]:
        """Return the change as plain values."""
        return {"name": self.name, "verdict": self.verdict, "factor": self.factor, "sentence": self.sentence}


def compare(now: Mapping[str, Ratio], then: Mapping[str, Ratio]) -> list[Change]:
    """Return what became of every ratio of now and of then, by name."""
    return [_change(name, now.get(name), then.get(name)) for name in sorted({*now, *then})]


def _change(name: str, now: Ratio | None, then: Ratio | None) -> Change:
    if now is None or then is None:
        return Change(name, "gone" if now is None else "new", None, now, then)
    gain = now.median / then.median if now.better == "higher" else then.median / now.median
    verdict: Verdict = "same" if len(now.values) + len(then.values) > 2 else "unjudged"
    if verdict == "same" and (min(now.values) > max(then.values) or max(now.values) < min(then.values)):
        verdict = "better" if gain > 1 else "worse"
    return Change(name, verdict, max(gain, 1 / gain), now, then)


def _told(ratio: Ratio) -> str:
    if len(ratio.values) == 1:
        return f"{ratio.median:.4g}"
    return f"{ratio.median:.4g} ({min(ratio.values):.4g} to {max(ratio.values):.4g})"


def ratios_of(benchmarks: Mapping[str, Findings]) -> dict[str, Ratio]:
    """Return the ratios of all benchmarks, named benchmark.ratio."""
    return {f"{name}.{key}": ratio for name, found in benchmarks.items() for key, ratio in found.ratios.items()}


def record_path(form: str, folder: Path = FOLDER) -> Path:
    """Return where the record of a form, `short` or `full`, stands."""
    return folder / f"{form}.json"


def write_record(path: Path, machine: dict[str, Any], ratios: Mapping[str, Ratio]) -> None:
    """Write a record; raises OSError where it cannot be."""
    stored = {"machine": machine, "ratios": {name: ratio.as_dict() for name, ratio in ratios.items()}}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(stored, indent=1) + "\n", encoding="utf-8")


def read_record(path: Path) -> tuple[dict[str, Any], dict[str, Ratio]] | None:
    """Return the machine and the ratios of a record; None where there is none, or none that can be read."""
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        return stored["machine"], {name: Ratio.from_dict(one) for name, one in stored["ratios"].items()}
    except (OSError, ValueError, KeyError, TypeError):
        return None


def report(
    machine: dict[str, Any], now: Mapping[str, Ratio], recorded: tuple[dict[str, Any], Mapping[str, Ratio]] | None
) -> tuple[list[Change], list[str]]:
    """Return the changes and what to tell people: those of the ratios that were measured now, and a summary."""
    if recorded is None:
        return [], ["There is no record to compare with; --record makes one."]
    machine_then, then = recorded
    measured = {name.partition(".")[0] for name in now}
    changes = compare(now, {name: ratio for name, ratio in then.items() if name.partition(".")[0] in measured})
    lines = [change.sentence for change in changes if change.verdict != "same"]
    counts = {verdict: sum(c.verdict == verdict for c in changes) for verdict in ("better", "worse", "same")}
    lines.append(f"{counts['same']} ratios as recorded, {counts['better']} better, {counts['worse']} worse.")
    lines += [_disturbed(when, one) for when, one in (("Now", machine), ("When recorded", machine_then)) if _busy(one)]
    if not same_machine(machine, machine_then):
        lines.append(
            f"Recorded on another machine or with other packages ({machine_then.get('processor')}, "
            f"{machine_then.get('processors')} processors, Python {machine_then.get('python')}): "
            f"read changes with care."
        )
    return changes, lines


def _busy(machine: dict[str, Any]) -> bool:
    """Return whether something else ran when a description was made, as it is before the first benchmark."""
    return float(machine.get("load_average", 0.0)) > 0.5


def _disturbed(when: str, machine: dict[str, Any]) -> str:
    return (
        f"{when} the machine was busy already, load {machine['load_average']:.1f} on {machine['processors']} "
        f"processors: others slow down more than scatter shows; measure on an idle one."
    )
