"""What a Taguchi study consists of: factors, experiments, runs, and what they say of each response."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.studies.taguchi.orthogonal_arrays import OrthogonalArray
from seat_gear_dynamics.studies.taguchi.variance import Analysis, Prediction

Setting = Mapping[str, float]


@dataclass(frozen=True)
class Factor:
    """What is varied, and to which values."""

    name: str
    unit: str
    levels: tuple[float, ...]
    start: int = 0
    """The level at which the study starts, that of the present design; counted from 0."""

    def __post_init__(self) -> None:
        if len(set(self.levels)) != len(self.levels) or len(self.levels) < 2 or not all(map(isfinite, self.levels)):
            raise ValueError(f"The levels of {self.name} are {self.levels}, expected two or more different numbers.")
        if not 0 <= self.start < len(self.levels):
            raise ValueError(f"The start of {self.name} is level {self.start}, expected 0 to {len(self.levels) - 1}.")

    def as_dict(self) -> dict[str, Any]:
        """Return the factor as plain values, levels in its unit."""
        start = self.levels[self.start]
        return {"name": self.name, "unit": self.unit, "levels": list(self.levels), "start": start}


@dataclass(frozen=True)
class Outcome:
    """One experiment: a run of the inner array under one condition of the outer one."""

    noise: Setting
    values: Mapping[str, float]
    """Responses by name; empty where there are none."""
    failure: str | None = None
    """Why there are none."""


@dataclass(frozen=True)
class Run:
    """One combination of control levels under all noise conditions."""

    levels: Mapping[str, int]
    """Counted from 0."""
    setting: Setting
    outcomes: tuple[Outcome, ...]
    ratios: Mapping[str, float]
    """Signal-to-noise ratio of each response, dB; empty where any of the experiments failed."""

    @property
    def failures(self) -> tuple[str, ...]:
        """What the failed experiments said."""
        return tuple(outcome.failure for outcome in self.outcomes if outcome.failure is not None)

    def mean(self, response: str) -> float | None:
        """Return the mean of a response over the noise conditions; None where any of the experiments failed."""
        return None if self.failures else float(np.mean([outcome.values[response] for outcome in self.outcomes]))

    def as_dict(self) -> dict[str, Any]:
        """Return the run as plain values: setting, ratios (dB), means over the noise conditions, failures."""
        means = {response: self.mean(response) for response in self.ratios}
        ratios, failures = dict(self.ratios), list(self.failures)
        return {"setting": dict(self.setting), "ratios": ratios, "means": means, "failures": failures}


@dataclass(frozen=True)
class Finding:
    """What the study says of one response."""

    response: str
    analysis: Analysis | None
    """None where the runs do not carry one; `reason` then says why."""
    reason: str | None
    start: Run
    """The present design."""
    predicted_start: Prediction | None
    best: Run | None
    """The confirmation run, at the best level of every factor."""
    predicted: Prediction | None

    @property
    def confirmed(self) -> float | None:
        """Ratio of the confirmation run, dB; None where it failed or there was none."""
        return None if self.best is None else self.best.ratios.get(self.response)

    @property
    def within(self) -> bool | None:
        """Whether the confirmation run lies within the prediction's interval; None where either is missing."""
        if self.predicted is None or self.confirmed is None:
            return None
        return self.predicted.contains(self.confirmed)

    @property
    def gain(self) -> float | None:
        """Ratio of the confirmation run over that of the present design, dB; what the optimisation is worth."""
        start = self.start.ratios.get(self.response)
        return None if self.confirmed is None or start is None else self.confirmed - start

    def as_dict(self) -> dict[str, Any]:
        """Return the finding as plain values, ratios in dB, shares between 0 and 1."""
        return {
            "reason": self.reason,
            **({} if self.analysis is None else self.analysis.as_dict()),
            "best": None if self.best is None else self.best.as_dict(),
            "predicted": None if self.predicted is None else self.predicted.as_dict(),
            "confirmed": self.confirmed,
            "within": self.within,
            "start": self.start.as_dict(),
            "predicted_start": None if self.predicted_start is None else self.predicted_start.as_dict(),
            "gain": self.gain,
        }


@dataclass(frozen=True)
class Study(Plottable, figure="main_effects:plot_study", table="studies:effects_table"):
    """A finished study: what was run, and what it says of each response."""

    array: OrthogonalArray
    noise_array: OrthogonalArray | None
    """None for a study without noise factors."""
    factors: tuple[Factor, ...]
    noise: tuple[Factor, ...]
    runs: tuple[Run, ...]
    findings: Mapping[str, Finding]
    confidence: float

    @property
    def diverged(self) -> tuple[int, ...]:
        """Numbers, from 1, of the runs that are left out of the analysis because an experiment of theirs failed."""
        return tuple(number for number, run in enumerate(self.runs, 1) if run.failures)

    def as_dict(self) -> dict[str, Any]:
        """Return the study as plain values for JSON; ratios in dB, levels as values in their factor's unit."""
        return {
            "array": self.array.name,
            "noise_array": None if self.noise_array is None else self.noise_array.name,
            "factors": [factor.as_dict() for factor in self.factors],
            "noise": [factor.as_dict() for factor in self.noise],
            "runs": [run.as_dict() for run in self.runs],
            "diverged": list(self.diverged),
            "responses": {name: finding.as_dict() for name, finding in self.findings.items()},
        }
