"""How far a drive is from its forbidden bands, and when it will be in one if it goes on as it does."""

from collections.abc import Sequence

from seat_gear_dynamics.gears import ForbiddenBand
from seat_gear_dynamics.sensing.bands import BandSource

_FAR = 3600.0  # s; a band farther ahead than this is not ahead: such an acceleration is noise
_STEPS = 50  # moments looked at along the way where the bands move
_HALVINGS = 12  # of such a step, to where a band is entered


def distance(band: ForbiddenBand, speed: float) -> float:
    """Return how far outside `band` a speed is, rad/s; negative inside by the way to the nearer edge."""
    return max(band.low - speed, speed - band.high)


def nearest(bands: Sequence[ForbiddenBand], speed: float) -> ForbiddenBand | None:
    """Return the band nearest to `speed` (rad/s, at least 0), None of none."""
    return min(bands, key=lambda band: distance(band, speed), default=None)


def containing(bands: Sequence[ForbiddenBand], speed: float, slack: float = 0.0) -> ForbiddenBand | None:
    """Return the last of `bands` that `speed` is in, each widened by `slack` (rad/s)."""
    return next((band for band in reversed(bands) if band.low - slack <= speed <= band.high + slack), None)


def time_to_band(bands: Sequence[ForbiddenBand], speed: float, acceleration: float) -> float | None:
    """Return when a drive enters the next of `bands` that stand still, s; 0 inside, None where none is ahead.

    `speed` (rad/s, at least 0) changes by `acceleration` (rad/s²).
    """
    if containing(bands, speed):
        return 0.0
    gaps = [band.low - speed if acceleration > 0 else speed - band.high for band in bands]
    times = [gap / abs(acceleration) for gap in gaps if 0 < gap < abs(acceleration) * _FAR]
    return min(times, default=None)


def time_to_moving_band(
    source: BandSource, speed: float, load: float, rates: tuple[float, float], horizon: float
) -> float | None:
    """Return when a drive enters a band while its load changes too, s; 0 inside, None where none is met in `horizon`.

    `rates` are those of |speed| (rad/s²) and load (N·m/s). Looked for at 50 moments up to `horizon` (s) and then by
    halving. Limit: a band that is crossed in less than a fiftieth of the horizon may be missed.
    """

    def inside(after: float) -> bool:
        return source.forbids(speed + rates[0] * after, load + rates[1] * after)

    if inside(0.0):
        return 0.0
    times = [horizon * (k + 1) / _STEPS for k in range(_STEPS)]
    late = next((after for after in times if inside(after)), None)
    if late is None:
        return None
    early = late - horizon / _STEPS
    for _ in range(_HALVINGS):
        middle = (early + late) / 2
        early, late = (early, middle) if inside(middle) else (middle, late)
    return late
