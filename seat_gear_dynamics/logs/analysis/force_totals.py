"""Force statistics over many windows, summed one window at a time."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite, nan, sqrt

from seat_gear_dynamics.logs.analysis.batches import MESHES


class ForceTotals:
    """Mean, smallest, largest and rms of both mesh forces over windows of equal weight; those with NaN are left out."""

    def __init__(self) -> None:
        self._sums = [[0, 0.0, 0.0, inf, -inf] for _ in MESHES]

    def add(self, values: Sequence[float]) -> None:
        """Take one window: mean, min, max and rms of each mesh in turn, N."""
        for k, sums in enumerate(self._sums):
            mean, least, most, rms = values[4 * k : 4 * k + 4]
            if isfinite(mean) and isfinite(rms):
                sums[0] += 1
                sums[1] += mean
                sums[2] += rms * rms
                sums[3], sums[4] = min(sums[3], least), max(sums[4], most)

    def statistics(self) -> dict[str, dict[str, float]]:
        """Return mesh → mean, min, max, rms, N; NaN without a window."""
        return {mesh: _statistics(sums) for mesh, sums in zip(MESHES, self._sums, strict=True)}


def _statistics(sums: Sequence[float]) -> dict[str, float]:
    count, total, squares, least, most = sums
    if not count:
        return dict.fromkeys(("mean", "min", "max", "rms"), nan)
    return {"mean": total / count, "min": least, "max": most, "rms": sqrt(squares / count)}
