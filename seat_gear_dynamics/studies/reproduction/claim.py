"""A claim of the paper and what became of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Verdict = Literal["reproduced", "partly", "not reproduced"]


@dataclass(frozen=True)
class Claim:
    """One row of the reproduction table."""

    id: str
    """C1 to C15, as in the table of claims."""
    condition: str
    """Under which the paper claims it."""
    expected: str
    """What the paper says."""
    found: str
    """What this model gives, in words and numbers."""
    verdict: Verdict
    why: str
    """What the verdict rests on, and what a reader should know."""
    figures: Mapping[str, Any] = field(default_factory=dict)
    """The measured numbers behind `found`, plain values."""

    def as_dict(self) -> dict[str, Any]:
        """Return the row as plain values for JSON."""
        return {
            "id": self.id,
            "condition": self.condition,
            "expected": self.expected,
            "found": self.found,
            "verdict": self.verdict,
            "why": self.why,
            "figures": dict(self.figures),
        }


def graded(whole: bool, part: bool) -> Verdict:
    """Return `reproduced` where the whole claim holds, `partly` where some of it does."""
    if whole:
        return "reproduced"
    return "partly" if part else "not reproduced"
