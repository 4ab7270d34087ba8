"""Taguchi's method: orthogonal arrays, signal-to-noise ratios, analysis of variance, and a study of the gear train."""

from seat_gear_dynamics.studies.taguchi.orthogonal_arrays import (
    ARRAY_NAMES,
    OrthogonalArray,
    is_orthogonal,
    orthogonal_array,
    smallest_array,
)
from seat_gear_dynamics.studies.taguchi.result import Factor, Finding, Outcome, Run, Study
from seat_gear_dynamics.studies.taguchi.signal_to_noise import (
    larger_the_better,
    nominal_the_best,
    signed_nominal_the_best,
    smaller_the_better,
)
from seat_gear_dynamics.studies.taguchi.study import run_study
from seat_gear_dynamics.studies.taguchi.variance import Analysis, Prediction, Source, analyse, weakest_factors
from seat_gear_dynamics.studies.taguchi.variations import CONTROLS, NOISE, Variation
from seat_gear_dynamics.studies.taguchi.vibration_and_impact import (
    RESPONSES,
    experiment,
    responses_of,
    vibration_and_impact,
)

__all__ = [
    "ARRAY_NAMES",
    "CONTROLS",
    "NOISE",
    "RESPONSES",
    "Analysis",
    "Factor",
    "Finding",
    "OrthogonalArray",
    "Outcome",
    "Prediction",
    "Run",
    "Source",
    "Study",
    "Variation",
    "analyse",
    "experiment",
    "is_orthogonal",
    "larger_the_better",
    "nominal_the_best",
    "orthogonal_array",
    "responses_of",
    "run_study",
    "signed_nominal_the_best",
    "smaller_the_better",
    "smallest_array",
    "vibration_and_impact",
    "weakest_factors",
]
