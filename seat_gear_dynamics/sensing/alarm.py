"""The alarm: from speed, load and regime to a warning level, pure logic with time as an argument."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from seat_gear_dynamics.gears import ForbiddenBand, GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes import Regime
from seat_gear_dynamics.sensing import approach
from seat_gear_dynamics.sensing.bands import Bands, BandSource, PublishedBands
from seat_gear_dynamics.sensing.evidence import Evidence, Level, Motion, closeness, together, warns, weigh
from seat_gear_dynamics.sensing.latch import Latch
from seat_gear_dynamics.sensing.track import Track

_SURE = 3.0  # standard errors: noise crosses a border this far away once in some hundred samples
_FIRM = 4.0  # standard errors of a fit: ten of them a second, each without common samples, cross it once in an hour
_RECORD = 0.5  # s; the points that a judgement of the motion looks at are about so old
# By what they ask of a person: STALE says less than OK does, and stops no trip.
_BY_SEVERITY = (Level.STALE, Level.OK, Level.WARN, Level.ERROR)
_SEVERITY = {level: severity for severity, level in enumerate(_BY_SEVERITY)}


@dataclass(frozen=True)
class AlarmSettings:
    """How cautious the alarm is; speeds in rad/s of s1, times in s."""

    margin: float = 40 * RPM
    """WARN when closer to a band than this."""
    horizon: float = 1.0
    """WARN when the present acceleration reaches a band within this time."""
    hysteresis: float = 4 * RPM
    """A band is left only when this far outside it, and the margin likewise; more where the speed is noisier."""
    debounce: float = 0.03
    """A worse level has to last this long before it is shown."""
    hold: float = 0.3
    """A better level has to last this long before it is shown."""
    slope_window: float = 0.3
    """Acceleration is the least-squares slope of the speed over this time."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not isfinite(value) or value < 0:
                raise ValueError(f"The alarm's {name} is {value!r}, expected a finite number of at least 0.")
        if self.slope_window == 0:
            raise ValueError("The alarm's slope_window is 0 s, expected more than 0: a slope needs two samples.")


@dataclass(frozen=True)
class Verdict:
    """What the alarm says at a moment."""

    level: Level
    reason: str
    in_band: bool
    """Inside a forbidden band (with hysteresis and debounce): the trip signal."""
    band: ForbiddenBand | None
    """The band that the speed is in or nearest to."""
    distance: float | None
    """From |speed| to that band's nearest edge, rad/s; negative inside."""
    time_to_band: float | None
    """Until a band is reached if speed and load go on as they do, s; 0 inside, None when none is ahead."""
    calm_speed: float | None
    """The nearest speed outside every band and its margin, with the sign of the present speed, rad/s."""
    evidence: tuple[Evidence, ...] = ()
    """Every sign of danger, the weightiest first; of this moment, before debounce and hold."""
    danger: float | None = None
    """Probability of danger that all evidence gives together; None where nothing was judged."""
    probability: float | None = None
    """Of chaos here, by the map; None without one."""
    odds: str = ""
    """What speaks for and against chaos of the running model, in log-odds; empty where it was not seen."""
    bands: str = ""
    """Whose bands it was judged by: the label of their source, `published` or `map 0123456789ab`."""


class Alarm:
    """Follows one drive and keeps the warning level steady.

    Bands hold for |speed|: the model is the same in both directions. Outside what the source of the bands covers
    nothing is known, and the level is STALE. Where a speed is noisier than the hysteresis suits, the end of a fitted
    line stands for it; so it does for a noisy load (`Track`).
    """

    def __init__(
        self,
        bands: BandSource | Sequence[ForbiddenBand],
        *,
        covered_speed: float | None = None,
        settings: AlarmSettings | None = None,
    ) -> None:
        """Take a source of bands, or bands that hold at every load up to `covered_speed` (rad/s)."""
        self.source: BandSource = _source(bands, covered_speed)
        self.settings = settings or AlarmSettings()
        self.reset()

    @classmethod
    def for_train(cls, train: GearTrain, settings: AlarmSettings | None = None) -> "Alarm":
        """Return an alarm on the published bands of `train`."""
        return cls(PublishedBands.of(train), settings=settings)

    def reset(self) -> None:
        """Forget the past; the next update is taken as it is."""
        window = self.settings.slope_window
        self._speed, self._load = Track(window), Track(window, held=True)
        self._inside: ForbiddenBand | None = None
        self._near = False
        self._chaotic_since: float | None = None
        # One latch for the trip signal and one for each severity above the least: that it is at least so bad.
        self._tripped, *self._at_least = (Latch(self.settings.debounce, self.settings.hold) for _ in Level)

    def update(
        self,
        t: float,
        speed: float,
        load: float,
        regime: Regime,
        scatter: float | None = None,
        *,
        settled: bool = True,
    ) -> Verdict:
        """Return the verdict at time `t` (s) for `speed` (rad/s of s1), `load` (N·m) and the motion's `regime`.

        `scatter` is that of the last section points, see `scatter_of`, and evidence where the regime is undecided;
        the motion of a model that is not `settled` since it was put at rest is no evidence.
        """
        if self._speed.last is not None and t < self._speed.last:
            self.reset()  # a clock that stepped back: its old times mean nothing any more
        self._speed.add(t, abs(speed))
        if self.source.follows_load:
            self._load.add(t, load)
        magnitude, torque = self._drive(abs(speed), load)
        bands = self.source.at(torque)
        ahead = self._time_to_band(bands, magnitude, torque)
        self._track(bands, magnitude)
        chance = self.source.probability(magnitude, torque)
        motion = self._weigh(t, regime, scatter, chance, settled=settled)
        signs = [*_from_motion(magnitude, torque, regime, motion), *_from_map(magnitude, torque, chance)]
        evidence = _weightiest_first([*self._from_bands(bands, magnitude, ahead), *signs])
        level, reason = self._judge(magnitude, torque, evidence)
        found, level = level, self._steady(t, level)
        in_band = self._tripped.update(t, self._inside is not None)
        if (found, self._inside is not None) != (level, in_band):
            reason = f"{reason} (holding {level.name})"
        band = self._inside or approach.nearest(bands, magnitude)
        away = approach.distance(band, magnitude) if band else None
        calm = self.calm_speed(magnitude, load=torque, rattling=regime.name == "chaotic")
        signed = None if calm is None else (-1.0 if speed < 0 else 1.0) * calm
        danger, odds = together(evidence), motion.words if motion.seen else ""
        source = self.source.label
        return Verdict(level, reason, in_band, band, away, ahead, signed, evidence, danger, chance, odds, source)

    def stale(self, reason: str) -> Verdict:
        """Return the verdict for missing inputs; the next update starts afresh."""
        self.reset()
        return Verdict(Level.STALE, reason, False, None, None, None, None, bands=self.source.label)

    def calm_speed(self, magnitude: float, *, load: float = 0.0, rattling: bool = False) -> float | None:
        """Return the |speed| nearest to `magnitude`, rad/s, outside every band by the margin; None if there is none.

        `load` is the one at hand, N·m, for bands that follow it. Where the drive is `rattling` at `magnitude` itself,
        that speed is none either, whatever the bands say, nor are those within the margin of it.
        """
        margin, highest = self.settings.margin, self.source.covered_speed
        near = any(band.low - margin < magnitude < band.high + margin for band in self.source.at(load))
        if not (near or rattling) and 0 <= magnitude <= highest:
            return magnitude
        blocked = [(band.low - margin, band.high + margin) for band in self.source.at(load)]
        if rattling:
            blocked.append((magnitude - margin, magnitude + margin))
        candidates = [magnitude, highest, *(edge for pair in blocked for edge in pair)]
        calm = [c for c in candidates if 0 <= c <= highest and not any(low < c < high for low, high in blocked)]
        return min(calm, key=lambda c: abs(c - magnitude), default=None)

    def acceleration(self) -> float:
        """Return the least-squares slope of |speed| over the slope window, rad/s²; 0 while it cannot be known."""
        return self._speed.slope()

    def _drive(self, magnitude: float, load: float) -> tuple[float, float]:
        """Return |speed| and load to judge by: as measured, or fitted where they are noisy."""
        if self.source.follows_load and self._load.noise:
            load = self._load.fitted
        return (max(self._speed.fitted, 0.0) if self._noisy() else magnitude), load

    def _noisy(self) -> bool:
        """Return whether the hysteresis is too small for the speed's noise; beyond the margin it is no noise."""
        return self.settings.hysteresis < _SURE * self._speed.noise <= self.settings.margin

    def _slack(self) -> float:
        """Return how far outside a band is left, rad/s."""
        return self.settings.hysteresis + (_FIRM * self._speed.error if self._noisy() else 0.0)

    def _time_to_band(self, bands: Bands, magnitude: float, load: float) -> float | None:
        slope = self._slope()
        change = self._load.sure_slope() if self.source.follows_load and self._load.spans_half else 0.0
        if change:
            rates = (slope, change)
            return approach.time_to_moving_band(self.source, magnitude, load, rates, self.settings.horizon)
        return approach.time_to_band(bands, magnitude, slope)

    def _slope(self) -> float:
        """Return the slope of |speed| to look ahead by, rad/s²."""
        if not self._speed.spans_half:
            return 0.0  # a slope of the first few samples is their noise
        begun = self._speed.begun()
        if begun is not None:
            return begun
        return self._speed.sure_slope() if self._noisy() else self._speed.slope()

    def _track(self, bands: Bands, magnitude: float) -> None:
        """Follow being inside a band and near one, each left only beyond the hysteresis."""
        slack = self._slack()
        within = approach.containing(bands, magnitude)
        if within is None and self._inside is not None:
            within = approach.containing(self._bands_about(bands), magnitude, slack)
        self._inside = within
        closest = approach.nearest(bands, magnitude)
        reach = self.settings.margin + (slack if self._near else 0.0)
        self._near = closest is not None and approach.distance(closest, magnitude) <= reach

    def _bands_about(self, bands: Bands) -> Bands:
        """Return the bands at the load at hand and at what it may be within its noise."""
        off = _FIRM * self._load.error
        if not off:
            return bands
        return (*self.source.at(self._load.fitted - off), *self.source.at(self._load.fitted + off), *bands)

    def _weigh(self, t: float, regime: Regime, scatter: float | None, chance: float | None, *, settled: bool) -> Motion:
        """Return what the running model says, and follow how long it has said chaos, its start left out."""
        if regime.name != "chaotic" or not settled:
            self._chaotic_since = None
        elif self._chaotic_since is None:
            self._chaotic_since = t
        lasting = 0 if self._chaotic_since is None else int((t - self._chaotic_since) / _RECORD)
        return weigh(regime, chance, scatter, lasting=lasting, settled=settled)

    def _from_bands(self, bands: Bands, magnitude: float, ahead: float | None) -> list[Evidence]:
        """Return what place and course say: inside, or ahead and near."""
        if self._inside:
            low, high = self._inside.low / RPM, self._inside.high / RPM
            text = f"{magnitude / RPM:.0f} r/min is inside the forbidden band {low:.0f}-{high:.0f} r/min"
            nearness = self._nearness(approach.distance(self._inside, magnitude))
            return [Evidence("band", Level.ERROR, nearness, text)]
        found = []
        if ahead is not None and self.settings.horizon:
            level = Level.WARN if ahead <= self.settings.horizon else Level.OK
            text = f"a forbidden band is {ahead:.1f} s ahead at the present acceleration"
            found.append(Evidence("approach", level, closeness(ahead / self.settings.horizon), text))
        band = approach.nearest(bands, magnitude)
        return found if band is None else [*found, self._beside(magnitude, approach.distance(band, magnitude))]

    def _beside(self, magnitude: float, away: float) -> Evidence:
        """Return the evidence of a speed that is `away` (rad/s) from the nearest band."""
        text = f"{magnitude / RPM:.0f} r/min is {away / RPM:.0f} r/min from a forbidden band"
        if self._near:
            text = f"{magnitude / RPM:.0f} r/min is within {self.settings.margin / RPM:.0f} r/min of a forbidden band"
        return Evidence("band", Level.WARN if self._near else Level.OK, self._nearness(away), text)

    def _nearness(self, away: float) -> float:
        """Return the probability of danger for a distance from a band, rad/s."""
        if away <= 0 or not self.settings.margin:
            return closeness(0.0) if away <= 0 else 0.0
        return closeness(away / self.settings.margin)

    def _judge(self, magnitude: float, load: float, evidence: tuple[Evidence, ...]) -> tuple[Level, str]:
        if evidence and evidence[0].level == Level.ERROR:
            return Level.ERROR, evidence[0].text
        beyond = self.source.beyond(magnitude, load)
        if beyond is not None:
            return Level.STALE, beyond
        # A band ahead is named before one that is near: it is the more urgent.
        signs = sorted(evidence, key=lambda each: (-each.level, each.kind != "approach"))
        if signs and signs[0].level == Level.WARN:
            return Level.WARN, signs[0].text
        danger = together(evidence)
        if warns(danger):
            parts = "; ".join(f"{each.text} ({each.probability:.0%})" for each in signs if each.probability >= 0.01)
            return Level.WARN, f"no sign alone warns, together they make danger {danger:.0%} likely: {parts}"
        return Level.OK, f"{magnitude / RPM:.0f} r/min is clear of the forbidden bands"

    def _steady(self, t: float, level: Level) -> Level:
        """Return the level to show: changed only once it has been worse for `debounce` or better for `hold`.

        Each severity has its own latch, so that levels which alternate cannot keep each other from being shown.
        """
        severity, shown = _SEVERITY[level], 0
        for rank, latch in enumerate(self._at_least):
            shown += latch.update(t, severity > rank)
        return _BY_SEVERITY[shown]


def _source(bands: BandSource | Sequence[ForbiddenBand], covered_speed: float | None) -> BandSource:
    if not isinstance(bands, Sequence):
        return bands
    if covered_speed is None:
        raise ValueError("Bands were given without covered_speed; expected the speed up to which they were looked for.")
    return PublishedBands(bands, covered_speed)


def _weightiest_first(signs: list[Evidence]) -> tuple[Evidence, ...]:
    """Return the signs of danger, those that support a worse level first."""
    return tuple(sorted(signs, key=lambda each: -each.level))


def _from_map(magnitude: float, load: float, chance: float | None) -> list[Evidence]:
    if chance is None:
        return []
    level = Level.WARN if warns(chance) else Level.OK
    text = f"the map gives chaos a probability of {chance:.0%} at {magnitude / RPM:.0f} r/min and {load:.0f} N·m"
    return [Evidence("probability", level, chance, text)]


def _from_motion(magnitude: float, load: float, regime: Regime, motion: Motion) -> list[Evidence]:
    """Return what the running model says where it makes chaos likelier than it was before."""
    if not motion.seen or motion.odds <= motion.parts[0][1]:
        return []
    if motion.level == Level.ERROR:
        text = f"the motion is chaotic at {magnitude / RPM:.0f} r/min and {load:.0f} N·m: {regime.reason}"
    else:
        text = f"evidence of chaos is building: {regime.reason}"
    return [Evidence("motion", motion.level, motion.probability, text)]
