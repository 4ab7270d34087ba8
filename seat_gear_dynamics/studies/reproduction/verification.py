"""C11 to C13: the rigid verification model of section 4, as claims."""

from collections.abc import Mapping

from seat_gear_dynamics.studies.contact_verification import Finding
from seat_gear_dynamics.studies.reproduction.claim import Claim, Verdict

_TEXTS = {
    "C11": ("Table 3, conditions 4-6", "Table 4: min, max, avg, rms of the P12 force; the maximum jumps at 30 µm"),
    "C12": ("Table 3, conditions 7-9", "teeth separate at 100 N·m, rarely at 300, not at 600"),
    "C13": (
        "Table 3, conditions 1-3 and 10, 6, 11",
        "an effect of eccentricity and of speed, of which the paper shows nothing",
    ),
}
_TOLD = ("min", "max", "avg", "rms", "10 µm")
"""What of C11 goes into a sentence: Table 4's own columns and the jump; all else is in the numbers."""
_VERDICTS: Mapping[str, Verdict] = {"reproduced": "reproduced", "partly reproduced": "partly"}


def as_claim(finding: Finding) -> Claim:
    """Return a finding of the verification model as a row of the reproduction.

    What the paper gives no figure for is `partly`: the trend is there, and nothing to hold it against.
    """
    condition, expected = _TEXTS[finding.claim]
    testable = not finding.verdict.startswith("not testable")
    verdict: Verdict = _VERDICTS.get(finding.verdict, "not reproduced") if testable else "partly"
    told = [row for row in finding.comparisons if isinstance(row.expected, float) and row.quantity.endswith(_TOLD)]
    rows = "; ".join(f"{row.quantity} {row.found:.4g} ({row.expected:.4g})" for row in told)
    return Claim(
        finding.claim,
        condition,
        expected,
        f"here (paper), N: {rows}" if rows else finding.reason.rstrip("."),
        verdict,
        finding.reason if rows else _why(finding),
        finding.as_dict(),
    )


def _why(finding: Finding) -> str:
    if finding.verdict.startswith("not testable"):
        return "the trend is computed, but the paper gives no figure to hold it against"
    return "the share of the time without contact is held against the paper's words"
