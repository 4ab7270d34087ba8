"""From dwells to a fitted train: observe, leave out what is irregular, fit, say what is sure, once more."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.studies.identification.confidence import Confidence, confidence, partners
from seat_gear_dynamics.studies.identification.fit import STEP, Problem, Solution, solve
from seat_gear_dynamics.studies.identification.model_observables import Drives, Predicted, predict
from seat_gear_dynamics.studies.identification.observables import Dwell, Observed, observe, whitened
from seat_gear_dynamics.studies.identification.parameters import DEFAULT, Candidate, Parameter, chosen
from seat_gear_dynamics.studies.identification.waveform import Sensor

Array = NDArray[np.float64]

LEAST_DWELLS = 3
"""Dwells below which nothing is fitted."""
FLOOR = 0.005
"""Share of a dwell's largest observable that is added to every standard error: a force sensor of class 0.5."""
_REGULAR = 0.5  # share of the variance at mesh orders and halves, below which a record counts as irregular
_APART = 6.0  # times the median dwell's rms residual, beyond which a dwell is on another branch
_ROUNDS = 3  # fits after which a dwell that is far is not let in and out any longer
_RECORD, _MODEL = "irregular in the record", "irregular in the model"
Tell = Callable[[str, int, int], None]


@dataclass(frozen=True, eq=False)
class Estimate:
    """One free parameter after the fit, SI units."""

    parameter: Parameter
    start: float
    value: float
    """`start` where it is held because the record does not tell it."""
    interval: tuple[float, float] | None
    """95 %, by the Jacobian of all free parameters; None where the parameter is not identified."""
    bootstrap: tuple[float, float] | None
    """95 %, by drawing dwells."""
    held: bool
    """Whether it was held at its start for the last fit."""
    confused_with: tuple[str, ...]
    """Parameters that the record cannot tell from it."""


@dataclass(frozen=True, eq=False)
class Fitted(Plottable, figure="identification:plot_identification", table="identification:identification_table"):
    """What was measured and what the model says of it, before and after."""

    sensor: Sensor
    drives: Drives
    observed: tuple[Observed, ...]
    before: Predicted
    after: Predicted
    left_out: tuple[str, ...]
    """Why each dwell was left out of the fit; empty texts for those that were not."""
    estimates: tuple[Estimate, ...]
    confidence: Confidence
    """Of all free parameters together, before any was held."""
    solution: Solution
    """Of the last fit."""
    searches: tuple[int, int]
    """Searches that ended as good as the best of the first fit, and how many there were."""
    train: GearTrain
    noise: float

    @property
    def used(self) -> NDArray[np.bool_]:
        """Dwells that the fit used, (d,)."""
        return np.array([not reason for reason in self.left_out])

    @property
    def residual_scale(self) -> float:
        """Standard deviation of the last fit's whitened residuals: 1 where the record errs as stated."""
        count, free = self.solution.jacobian.shape
        return float(np.linalg.norm(self.solution.residual) / np.sqrt(max(count - free, 1)))


def identify(
    train: GearTrain,
    dwells: Sequence[Dwell],
    sensor: Sensor,
    *,
    free: Sequence[str] = DEFAULT,
    noise: float = 0.0,
    floor: float = FLOOR,
    seed: int = 1,
    candidates: int = 32,
    searches: int = 3,
    tell: Tell | None = None,
) -> Fitted:
    """Fit the parameters `free` (keys of PARAMETERS) of `train` to what `sensor` showed in `dwells`.

    `noise` is the sensor's standard deviation in its unit, the start where it is free; `floor` the share of a dwell's
    largest observable added to its errors. Dwells whose record or whose model is irregular (chaotic, quasi-periodic,
    of a period above 12) are left out: at a fit, a step beside it, and at all fits after. So are those that stay far
    from a fit of all others. What is left out is looked at after each fit, until no dwell has to go. Parameters that
    the record does not tell are held at their start, the least certain first, and the rest fitted again. `tell` gets
    (stage, done, in all). Raises ValueError, a sentence, where fewer than LEAST_DWELLS dwells are regular, and as
    `observe`, `chosen` and `solve`.

    Limits: P12 alone is measured and fitted. The model's form, masses, supports and transmission error are taken as
    given; an error in them goes into the parameters, and no interval knows of it.
    """
    parameters = chosen(free)
    _enough(len(dwells), "the record")
    teeth = train.meshes[0].driver.teeth
    start = Candidate(train, _first_noise(noise, free, dwells))
    observed = tuple(observe(dwell, teeth, noise=start.noise) for dwell in dwells)
    drives = Drives(
        np.array([d.speed for d in dwells]),
        np.array([d.load for d in dwells]),
        tuple(len(o.names) - 4 for o in observed),
    )
    work = _Work(start, parameters, drives, sensor, observed, floor)
    return work.run(seed, candidates, searches, tell or (lambda stage, done, total: None))


def _irregular(left_out: Sequence[str]) -> list[bool]:
    return [reason in (_RECORD, _MODEL) for reason in left_out]


def _first_noise(noise: float, free: Sequence[str], dwells: Sequence[Dwell]) -> float:
    """Return the start of the noise; a logarithm cannot start at 0."""
    if not (noise >= 0 and np.isfinite(noise)):
        raise ValueError(f"The sensor's noise is {noise!r}, expected a finite number of at least 0.")
    return 0.05 * float(np.median([d.value.std() for d in dwells])) if "noise" in free and not noise else noise


def _enough(count: int, where: str) -> None:
    if count < LEAST_DWELLS:
        raise ValueError(
            f"There are {count} dwells that can be fitted in {where}, expected at least {LEAST_DWELLS}: hold the bench "
            f"at more speeds and loads, each for some seconds, outside the chaotic bands."
        )


class _Work:
    """The state of one identification."""

    def __init__(
        self,
        start: Candidate,
        parameters: Sequence[Parameter],
        drives: Drives,
        sensor: Sensor,
        observed: Sequence[Observed],
        floor: float,
    ) -> None:
        self._start, self._parameters, self._drives, self._sensor = start, tuple(parameters), drives, sensor
        self._observed, self._floor = tuple(observed), floor
        self._dwell = np.repeat(np.arange(len(observed)), drives.sizes)
        self._measured = np.concatenate([o.value for o in observed])
        self._searches = (0, 0)

    def run(self, seed: int, candidates: int, searches: int, tell: Tell) -> Fitted:
        before = self._said(self._start)
        left_out = self._judged([before])
        known = {p.name: self._start.value(p.name) for p in self._parameters}
        # Each turn but the last leaves out a dwell more, so that there are no more of them than dwells.
        while True:
            found, left_out = self._fitted(known, left_out, seed, candidates, searches, tell)
            known = dict(zip(known, np.exp(found.x).tolist(), strict=True))
            sure = confidence(found, self._problem(self._parameters, left_out), self._rows(left_out), seed=seed)
            settled = self._settled(found, sure, left_out, before, seed, tell)
            again = self._judged([settled.after], kept=left_out)
            if _irregular(again) == _irregular(left_out):
                return settled
            left_out, candidates, searches = again, 0, 1

    def _fitted(
        self, known: dict[str, float], left_out: tuple[str, ...], seed: int, candidates: int, searches: int, tell: Tell
    ) -> tuple[Solution, tuple[str, ...]]:
        """Fit until no dwell that is used is irregular at the solution, or at the points of its Jacobian."""
        for round in count():
            stage = "fit" if round == 0 else f"fit {round + 1}"
            wide = (candidates, searches) if round == 0 else (0, 1)
            found = self._fit(self._parameters, known, left_out, seed, *wide, partial(tell, stage))
            first = not self._searches[1]
            self._searches = (found.agreeing, found.searches) if first else self._searches
            known = dict(zip(known, np.exp(found.x).tolist(), strict=True))
            # The start may be far off, and what it said is not kept.
            again = self._judged(self._around(found.x), found, kept=() if first else left_out)
            grown = _irregular(again) != _irregular(left_out)
            if again == left_out or (round + 1 >= _ROUNDS and not grown):
                break
            left_out = again
        return found, left_out

    def _around(self, x: Array) -> list[Predicted]:
        """Return what the model says at `x`, the logarithms of all parameters, and a step off it along each."""
        steps = STEP * np.eye(len(x))
        names = [p.name for p in self._parameters]
        asked = [self._start.with_values(names, np.exp(each).tolist()) for each in (x, *(x + steps), *(x - steps))]
        return predict(asked, self._drives, self._sensor)

    def _settled(
        self, found: Solution, sure: Confidence, left_out: tuple[str, ...], before: Predicted, seed: int, tell: Tell
    ) -> Fitted:
        """Hold what is not identified, least certain first, fit the rest again, and put everything together."""
        kept, last, own, joint = list(self._parameters), found, sure, sure
        while len(kept) > 1 and not own.identified.all():
            worst = int(np.argmax(np.where(own.identified, -1.0, own.half_width)))
            values = {p.name: float(np.exp(x)) for p, x in zip(kept, last.x, strict=True)}
            stage = f"fit, {kept.pop(worst).name} held"
            known = {p.name: values[p.name] for p in kept}
            last = self._fit(kept, known, left_out, seed, 0, 1, partial(tell, stage))
            own = confidence(last, self._problem(kept, left_out), self._rows(left_out), seed=seed)
        values = {p.name: float(np.exp(x)) for p, x in zip(kept, last.x, strict=True)}
        estimates = tuple(self._estimate(k, p, values, joint, own, kept) for k, p in enumerate(self._parameters))
        best = self._start.with_values(list(values), list(values.values()))
        after = self._said(best)
        return Fitted(
            self._sensor, self._drives, self._observed, before, after, left_out, estimates, joint, last,
            self._searches, best.train,
            best.noise,
        )  # fmt: skip

    def _estimate(
        self, index: int, parameter: Parameter, values: dict[str, float], joint: Confidence, own: Confidence,
        kept: Sequence[Parameter],
    ) -> Estimate:  # fmt: skip
        start = self._start.value(parameter.name)
        value = values.get(parameter.name, start)
        interval = bootstrap = None
        if joint.identified[index] and parameter in kept and own.identified[kept.index(parameter)]:
            k = kept.index(parameter)
            # What is held is not known: the parameters that stay carry its share.
            half = max(own.half_width[k], joint.half_width[index])
            interval = (float(value * np.exp(-half)), float(value * np.exp(half)))
            bootstrap = (float(value * np.exp(own.bootstrap[k, 0])), float(value * np.exp(own.bootstrap[k, 1])))
        confused = () if interval else tuple(partners(joint, [p.name for p in self._parameters], index))
        return Estimate(parameter, start, value, interval, bootstrap, parameter.name not in values, confused)

    def _fit(
        self, parameters: Sequence[Parameter], known: dict[str, float], left_out: tuple[str, ...], seed: int,
        candidates: int, searches: int, progress: Callable[[int, int], None] | None,
    ) -> Solution:  # fmt: skip
        names = [p.name for p in parameters]
        rows = np.array([not left_out[d] for d in self._dwell])

        def said(points: Array) -> Array:
            asked = [self._start.with_values(names, np.exp(x).tolist()) for x in points]
            return np.array([each.value[rows] for each in predict(asked, self._drives, self._sensor)])

        start = np.log([known[name] for name in names])
        reach = np.log([p.reach for p in parameters])
        return solve(
            said, self._problem(parameters, left_out), start, reach=reach, seed=seed, candidates=candidates,
            searches=searches, progress=progress,
        )  # fmt: skip

    def _problem(self, parameters: Sequence[Parameter], left_out: tuple[str, ...]) -> Problem:
        rows = np.array([not left_out[d] for d in self._dwell])
        whitener = np.zeros((len(rows), len(rows)))
        for d, observed in enumerate(self._observed):
            own = np.ix_(self._dwell == d, self._dwell == d)
            whitener[own] = whitened(observed, self._floor)
        bounds = np.log([[p.low, p.high] for p in parameters])
        return Problem(self._measured[rows], whitener[np.ix_(rows, rows)], bounds[:, 0], bounds[:, 1])

    def _rows(self, left_out: tuple[str, ...]) -> Array:
        """Return the dwell of each observable that is used."""
        return np.array([d for d in self._dwell if not left_out[d]], dtype=float)

    def _said(self, candidate: Candidate) -> Predicted:
        return predict([candidate], self._drives, self._sensor)[0]

    def _judged(
        self, said: Sequence[Predicted], found: Solution | None = None, *, kept: Sequence[str] = ()
    ) -> tuple[str, ...]:
        """Return why each dwell is left out; raise ValueError where too few are not.

        The first of `said` is at the fit `found`; a dwell has to be regular in all of them. What was irregular before,
        in `kept`, stays so: such a dwell follows the parameters into chaos and out of it, and would pin them there.
        """
        regular = np.all([each.regular for each in said], axis=0)
        reasons = [
            _RECORD if o.regular < _REGULAR else "" if calm else _MODEL
            for o, calm in zip(self._observed, regular, strict=True)
        ]
        reasons = [old if old in (_RECORD, _MODEL) else new for old, new in zip(kept or reasons, reasons, strict=True)]
        if found is not None:
            for d in self._far(said[0], reasons):
                reasons[d] = "far from a fit of the others"
        _enough(reasons.count(""), "regular motion")
        return tuple(reasons)

    def _far(self, said: Predicted, reasons: Sequence[str]) -> list[int]:
        """Return the dwells whose residual stands out, at most a quarter of those that are regular."""
        rms = np.full(len(reasons), np.nan)
        for d, observed in enumerate(self._observed):
            own = self._dwell == d
            apart = whitened(observed, self._floor) @ (said.value[own] - self._measured[own])
            rms[d] = np.sqrt(np.mean(apart**2)) if not reasons[d] else np.nan
        limit = _APART * max(1.0, float(np.nanmedian(rms)))
        worst = [int(d) for d in np.argsort(-np.nan_to_num(rms)) if rms[d] > limit]
        return worst[: reasons.count("") // 4]
