"""What a recovery kept and what it lost, for people and for programs."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from seat_gear_dynamics.logs.recovery.scan import Lost

_RANGES = 12  # shown for a file; JSON has all


@dataclass(frozen=True)
class TopicResult:
    """Messages of a topic. `lost` is None where nothing tells; `exact` where a checked summary does."""

    type: str
    kept: int
    lost: int | None
    exact: bool


@dataclass(frozen=True)
class FileResult:
    """A file of the log: bytes in all, where what was kept went, messages kept, byte ranges lost."""

    name: str
    size: int
    recovered_as: str | None
    messages: int
    lost: tuple[Lost, ...]

    @property
    def lost_bytes(self) -> int:
        """Bytes of all lost ranges."""
        return sum(lost.end - lost.begin for lost in self.lost)


@dataclass(frozen=True)
class Recovery:
    """A recovered log. `unproven`: stretches kept (with `unchecked`) or left out for want of a checksum."""

    log: Path
    output: Path
    topics: dict[str, TopicResult]
    files: tuple[FileResult, ...]
    unchecked: bool
    unproven: int
    notes: tuple[str, ...]
    verified_by: tuple[str, ...]

    @property
    def messages(self) -> int:
        """Messages kept."""
        return sum(topic.kept for topic in self.topics.values())

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        values = asdict(self) | {"log": str(self.log), "output": str(self.output), "messages": self.messages}
        values["files"] = [
            {**asdict(file), "lost": [lost._asdict() for lost in file.lost], "lost_bytes": file.lost_bytes}
            for file in self.files
        ]
        return values

    def lines(self) -> list[str]:
        """Return the summary for people."""
        lines = [f"{self.messages} messages recovered from {self.log}", f"{'topic':40s}{'kept':>10s}{'lost':>12s}"]
        for name, topic in sorted(self.topics.items()):
            lost = "unknown" if topic.lost is None else f"{'' if topic.exact or not topic.lost else '≥ '}{topic.lost}"
            lines.append(f"{name:40s}{topic.kept:10d}{lost:>12s}")
        for file in self.files:
            lines += _file_lines(file)
        lines += self.notes
        return [*lines, f"read back by: {', '.join(self.verified_by)}", f"log: {self.output}"]


def _file_lines(file: FileResult) -> list[str]:
    kept = f"{file.messages} messages" if file.recovered_as else "nothing"
    lines = [f"{file.name}: {kept} kept, {file.lost_bytes} of {file.size} bytes lost"]
    lines += [f"  bytes {lost.begin} to {lost.end - 1}: {lost.reason}" for lost in file.lost[:_RANGES]]
    if len(file.lost) > _RANGES:
        lines.append(f"  and {len(file.lost) - _RANGES} ranges more (--json has all)")
    return lines
