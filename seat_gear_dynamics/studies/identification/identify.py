"""From dwells to a fitted train: observe, leave out what is irregular, fit, say what is sure, once more."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.studies.identification.confidence import Confidence, confidence, partners
from seat_gear_dynamics.studies.identification.fit import Problem, Solution, solve
from seat_gear_dynamics.studies.identification.model_observables import Drives, Predicted, predict
from seat_gear_dynamics.studies.identification.observables import Dwell, Observed, observe
from seat_gear_dynamics.studies.identification.parameters import DEFAULT, Candidate, Parameter, chosen
from seat_gear_dynamics.studies.identification.waveform import Sensor

Array = NDArray[np.float64]

LEAST_DWELLS = 3
"""Dwells below which nothing is fitted."""
FLOOR = 0.005
"""Share of a dwell's largest observable that is added to every standard error: a force sensor of class 0.5."""
_REGULAR = 0.5  # share of the variance at mesh orders and halves, below which a record counts as irregular
_APART = 6.0  # times the median dwell's rms residual, beyond which a dwell is on another branch
_ROUNDS = 3
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
class Fitted:
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
    of a period above 12) are left out, and those that stay far from a fit of all others; what is left out is looked
    at again after each of up to three fits. Parameters that the record does not tell are held at their start, the
    least certain first, and the rest fitted again. `tell` gets (stage, done, in all). Raises ValueError, a sentence,
    where fewer than LEAST_DWELLS dwells are regular, and as `observe`, `chosen` and `solve`.

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
        left_out = self._judged(before)
        known = {p.name: self._start.value(p.name) for p in self._parameters}
        for round in range(_ROUNDS):
            wide = (candidates, searches) if round == 0 else (0, 1)
            found = self._fit(self._parameters, known, left_out, seed, *wide, lambda d, n: tell("fit", d, n))
            self._searches = (found.agreeing, found.searches) if round == 0 else self._searches
            known = dict(zip(known, np.exp(found.x).tolist(), strict=True))
            after = self._said(self._start.with_values(list(known), list(known.values())))
            again = self._judged(after, found)
            if again == left_out or round == _ROUNDS - 1:
                break
            left_out = again
        sure = confidence(found, self._problem(self._parameters, left_out), self._rows(left_out), seed=seed)
        return self._settled(found, sure, left_out, before, seed)

    def _settled(
        self, found: Solution, sure: Confidence, left_out: tuple[str, ...], before: Predicted, seed: int
    ) -> Fitted:
        """Hold what is not identified, least certain first, fit the rest again, and put everything together."""
        kept, last, own, joint = list(self._parameters), found, sure, sure
        while len(kept) > 1 and not own.identified.all():
            worst = int(np.argmax(np.where(own.identified, -1.0, own.half_width)))
            values = {p.name: float(np.exp(x)) for p, x in zip(kept, last.x, strict=True)}
            kept.pop(worst)
            known = {p.name: values[p.name] for p in kept}
            last = self._fit(kept, known, left_out, seed, 0, 1, None)
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

    def _judged(self, said: Predicted, found: Solution | None = None) -> tuple[str, ...]:
        """Return why each dwell is left out; raise ValueError where too few are not."""
        reasons = [
            "irregular in the record" if o.regular < _REGULAR else "" if regular else "irregular in the model"
            for o, regular in zip(self._observed, said.regular, strict=True)
        ]
        if found is not None:
            for d in self._far(said, reasons):
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


def whitened(observed: Observed, floor: float) -> Array:
    """Return W with WᵀW the inverse covariance of a dwell's observables, (m, m).

    `floor` times the largest observable is added to every standard error, in quadrature; correlations, which
    come from few parts, are shrunk towards none as if as many parts as observables had shown none.
    """
    deviation = observed.standard_error
    extra = floor * float(np.abs(observed.value).max())
    shrink = len(observed.parts) / (len(observed.parts) + len(observed.value))
    covariance = shrink * observed.covariance
    covariance[np.diag_indices_from(covariance)] = deviation**2 + extra**2
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))
