"""What a benchmark finds: figures to read, and ratios within one run, which machines and days may be compared by."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from statistics import median
from typing import Any, Literal

Better = Literal["higher", "lower"]


@dataclass(frozen=True)
class Ratio:
    """One ratio, measured several times in one run."""

    values: tuple[float, ...]
    meaning: str
    better: Better = "higher"
    reach: float | None = None
    """What it is meant to reach; None: nothing in particular."""

    @property
    def median(self) -> float:
        """The middle of the repeats."""
        return median(self.values)

    @property
    def reached(self) -> bool | None:
        """Whether the median is what it is meant to be; None where nothing is asked."""
        if self.reach is None:
            return None
        return self.median >= self.reach if self.better == "higher" else self.median <= self.reach

    def as_dict(self) -> dict[str, Any]:
        """Return the ratio as plain values."""
        return {
            "median": self.median,
            "values": list(self.values),
            "better": self.better,
            "reach": self.reach,
            "reached": self.reached,
            "meaning": self.meaning,
        }

    @classmethod
    def from_dict(cls, stored: dict[str, Any]) -> "Ratio":
        """Return the ratio that `as_dict` stored; raises KeyError or TypeError for anything else."""
        return cls(tuple(map(float, stored["values"])), stored["meaning"], stored["better"], stored["reach"])


@dataclass(frozen=True)
class Findings:
    """What one benchmark found."""

    figures: dict[str, Any] = field(default_factory=dict)
    """Plain values, for people and for tables."""
    ratios: dict[str, Ratio] = field(default_factory=dict)
    skipped: str | None = None
    """Why there is nothing, or not all: a sentence."""

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as plain values."""
        ratios = {name: ratio.as_dict() for name, ratio in self.ratios.items()}
        return {"figures": self.figures, "ratios": ratios, "skipped": self.skipped}


def quotients(over: Iterable[float], under: Iterable[float]) -> tuple[float, ...]:
    """Return the quotients of two rows of repeats, pair by pair; raises ValueError where one is longer."""
    return tuple(float(a / b) for a, b in zip(over, under, strict=True))
