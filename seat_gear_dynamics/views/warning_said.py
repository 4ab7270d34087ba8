"""What the values of a warning say of the forbidden bands, read back from their texts."""

import re
from collections.abc import Mapping

PUBLISHED = "published"
"""How a warning names the published bands as its source."""
_BAND = re.compile(r"([0-9]{1,6}(?:\.[0-9]{1,6})?)[-–]([0-9]{1,6}(?:\.[0-9]{1,6})?)")


def source_said(values: Mapping[str, str]) -> str:
    """Return the source of bands that the monitor goes by; the published ones where it names none."""
    return values.get("bands", PUBLISHED)


def band_said(values: Mapping[str, str]) -> tuple[float, float] | None:
    """Return the band that the monitor says to be nearest, r/min; None where that is no band."""
    found = _BAND.fullmatch(values.get("band (r/min)", ""))
    return None if found is None else (float(found[1]), float(found[2]))
