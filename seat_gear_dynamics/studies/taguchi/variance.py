"""Analysis of variance of an additive model of factor levels: effects, F tests, pooling, prediction with an interval.

Sources: Phadke, Quality Engineering Using Robust Design (1989), chapter 3 (additive model, pooling, prediction error);
Ross, Taguchi Techniques for Quality Engineering (1988) (interval of a confirmation run); Roy, A Primer on the Taguchi
Method (1990) (contribution net of error).
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from seat_gear_dynamics.studies.taguchi.orthogonal_arrays import is_orthogonal

Array = NDArray[np.float64]
Levels = NDArray[np.int64]


@dataclass(frozen=True)
class Source:
    """One line of the table: a factor, the error or the total."""

    name: str
    degrees_of_freedom: int
    sum_of_squares: float
    contribution: float
    """Share of the total sum of squares, 0 to 1."""
    net_contribution: float | None = None
    """The same after as much error variance is taken off as the degrees of freedom carry (Roy); can be negative."""
    f: float | None = None
    """Mean square over the error's; None for pooled factors and where the error has no degrees of freedom or is 0."""
    p: float | None = None
    """Probability of at least this F by chance, if the error were normal and independent."""
    pooled: bool = False
    """True for a factor that is counted into the error."""

    @property
    def mean_square(self) -> float | None:
        """Sum of squares over degrees of freedom; None without any."""
        return self.sum_of_squares / self.degrees_of_freedom if self.degrees_of_freedom else None

    def as_dict(self) -> dict[str, Any]:
        """Return the line as plain values."""
        return {
            "source": self.name,
            "degrees_of_freedom": self.degrees_of_freedom,
            "sum_of_squares": self.sum_of_squares,
            "mean_square": self.mean_square,
            "F": self.f,
            "p": self.p,
            "contribution": self.contribution,
            "net_contribution": self.net_contribution,
            "pooled": self.pooled,
        }


@dataclass(frozen=True)
class Prediction:
    """What the additive model says of one combination of levels."""

    value: float
    standard_error: float | None
    """Of the difference between one confirmation run and `value`; None without error degrees of freedom."""
    degrees_of_freedom: int
    """Those of the error."""
    confidence: float

    @property
    def interval(self) -> tuple[float, float] | None:
        """Bounds within which one confirmation run is expected with `confidence`; None without a standard error."""
        if self.standard_error is None:
            return None
        half = float(t_distribution.ppf((1 + self.confidence) / 2, self.degrees_of_freedom)) * self.standard_error
        return self.value - half, self.value + half

    def contains(self, confirmed: float) -> bool | None:
        """Return whether `confirmed` lies within the interval; None where there is none."""
        bounds = self.interval
        return None if bounds is None else bounds[0] <= confirmed <= bounds[1]

    def as_dict(self) -> dict[str, Any]:
        """Return the prediction as plain values; bounds are None where there is no interval."""
        low, high = self.interval or (None, None)
        return {"value": self.value, "low": low, "high": high, "confidence": self.confidence}


@dataclass(frozen=True)
class Analysis:
    """The additive model of one quantity, fitted by least squares."""

    mean: float
    """The overall mean, of runs on every level equally often."""
    effects: Mapping[str, tuple[float, ...]]
    """Mean of each level of each factor."""
    factors: tuple[Source, ...]
    error: Source
    total: Source
    orthogonal: bool
    """False where runs are missing: sums of squares then overlap and do not add up to the total."""
    _covariance: Array = field(repr=False, compare=False)
    _basis: "_Basis" = field(repr=False, compare=False)

    @property
    def pooled(self) -> tuple[str, ...]:
        """Names of the factors that are counted into the error."""
        return tuple(source.name for source in self.factors if source.pooled)

    @property
    def best_levels(self) -> dict[str, int]:
        """The level of the highest mean of each factor, pooled ones too, counted from 0; the lower one of equals."""
        return {name: int(np.argmax(means)) for name, means in self.effects.items()}

    def as_dict(self) -> dict[str, Any]:
        """Return the analysis as plain values."""
        return {
            "mean": self.mean,
            "orthogonal": self.orthogonal,
            "pooled": list(self.pooled),
            "variance": [source.as_dict() for source in (*self.factors, self.error, self.total)],
            "effects": {name: list(means) for name, means in self.effects.items()},
        }

    def predict(self, levels: Mapping[str, int], *, runs: int = 1, confidence: float = 0.95) -> Prediction:
        """Return what the model says of these `levels` (counted from 0) and how far `runs` repeats may lie from it.

        Mean + Σ (level mean − mean) over the factors that are not pooled. The variance is the error's times
        (1/n₀ + 1/runs), 1/n₀ = 1/n + Σ (1/n_level − 1/n) for an orthogonal array (Phadke; Ross, who writes the interval
        with F(1, ν) = t²(ν)). Raises ValueError for a confidence outside 0 to 1. Limit: an interval of an additive
        model says nothing of interactions, which is what a confirmation run is for.
        """
        if not 0 < confidence < 1:
            raise ValueError(f"The confidence is {confidence!r}, expected a number between 0 and 1, as in 0.95.")
        kept = [source.name for source in self.factors if not source.pooled]
        value = self.mean + sum(self.effects[name][levels[name]] - self.mean for name in kept)
        if self.error.mean_square is None:
            return Prediction(value, None, 0, confidence)
        row = self._basis.row(kept, levels)
        spread = float(row @ self._covariance @ row) + 1 / runs
        return Prediction(value, sqrt(self.error.mean_square * spread), self.error.degrees_of_freedom, confidence)


@dataclass(frozen=True)
class _Basis:
    """Columns of the additive model, each factor's effects summing to 0 over its levels."""

    design: Levels
    names: tuple[str, ...]
    level_counts: tuple[int, ...]

    def columns(self, names: Collection[str]) -> Array:
        """Return the model's matrix for the mean and these factors, shape (runs, 1 + Σ (levels − 1))."""
        coded = [self._contrasts(i)[self.design[:, i]] for i, name in enumerate(self.names) if name in names]
        return np.column_stack([np.ones(len(self.design)), *coded])

    def row(self, names: Collection[str], levels: Mapping[str, int]) -> Array:
        """Return the row that such a matrix has for a run at `levels`."""
        coded = [self._contrasts(i)[levels[name]] for i, name in enumerate(self.names) if name in names]
        return np.concatenate([np.ones(1), *coded])

    def _contrasts(self, index: int) -> Array:
        count = self.level_counts[index]
        return np.vstack([np.eye(count - 1), -np.ones(count - 1)])


def analyse(
    design: ArrayLike,
    values: ArrayLike,
    names: Sequence[str],
    *,
    level_counts: Sequence[int] | None = None,
    pooled: Collection[str] = (),
) -> Analysis:
    """Return the analysis of variance of `values`, shape (n,), over the levels in `design`, (n, factors), from 0.

    `level_counts` are the factors' numbers of levels (default: as `design` has them). `pooled` names the factors that
    are counted into the error: a choice to be stated, since taking the weakest lowers the error and raises every F.
    Repeated runs are repeated rows. Where rows are missing the sums of squares are those by which the residual grows
    when the factor is left out; for an orthogonal array they are the classical ones.

    Raises ValueError for shapes that do not fit, values that are not finite or are all equal, names that are unknown or
    repeated, and runs that do not determine every level. Limit: no interactions; they stand in the error, or, in a
    saturated array, in the factors.
    """
    basis = _checked(design, values, names, level_counts, pooled)
    y = np.asarray(values, dtype=float)
    kept = [name for name in names if name not in pooled]
    error_squares, _ = _fit(basis, kept, y)
    error_freedom = len(y) - basis.columns(kept).shape[1]
    error_variance = error_squares / error_freedom if error_freedom else None
    total = float(np.sum((y - y.mean()) ** 2))
    factors = []
    for name, count in zip(names, basis.level_counts, strict=True):
        others = [other for other in kept if other != name]
        squares = _fit(basis, others, y)[0] - _fit(basis, [*others, name], y)[0]
        factors.append(_source(name, count - 1, squares, total, error_variance, error_freedom, name in pooled))
    matrix = basis.columns(kept)
    return Analysis(
        mean=float(_fit(basis, kept, y)[1][0]),
        effects={name: _level_means(basis, kept, name, y) for name in names},
        factors=tuple(factors),
        error=Source("error", error_freedom, error_squares, error_squares / total),
        total=Source("total", len(y) - 1, total, 1.0),
        orthogonal=is_orthogonal(basis.design),
        _covariance=np.asarray(np.linalg.inv(matrix.T @ matrix), dtype=float),
        _basis=basis,
    )


def weakest_factors(analysis: Analysis, *, share: float = 0.5) -> tuple[str, ...]:
    """Return the factors of smallest mean square whose pooling gives the error `share` of all degrees of freedom.

    Phadke's rule of thumb (share 0.5): the bottom half. From the weakest up, until the next one would exceed the share.
    The choice looks at the data, so F and p of what remains are too good; they rank, they do not prove.
    """
    freedom, chosen = analysis.error.degrees_of_freedom, list(analysis.pooled)
    candidates = [source for source in analysis.factors if not source.pooled]
    for source in sorted(candidates, key=lambda s: s.sum_of_squares / s.degrees_of_freedom):
        freedom += source.degrees_of_freedom
        if freedom > share * analysis.total.degrees_of_freedom:
            break
        chosen.append(source.name)
    return tuple(source.name for source in analysis.factors if source.name in chosen)


def _source(
    name: str, freedom: int, squares: float, total: float, variance: float | None, error_freedom: int, pooled: bool
) -> Source:
    if pooled or not variance:
        return Source(name, freedom, squares, squares / total, pooled=pooled)
    f = squares / freedom / variance
    net = (squares - freedom * variance) / total
    return Source(name, freedom, squares, squares / total, net, f, float(f_distribution.sf(f, freedom, error_freedom)))


def _fit(basis: _Basis, names: Collection[str], y: Array) -> tuple[float, Array]:
    """Return the residual sum of squares and the coefficients of the additive model of these factors."""
    matrix = basis.columns(names)
    coefficients = np.asarray(np.linalg.lstsq(matrix, y, rcond=None)[0], dtype=float)
    return float(np.sum((y - matrix @ coefficients) ** 2)), coefficients


def _level_means(basis: _Basis, kept: Sequence[str], name: str, y: Array) -> tuple[float, ...]:
    """Return the mean of each level of `name`, with the other kept factors on each of their levels equally often."""
    index = basis.names.index(name)
    modelled = [other for other in basis.names if other in kept or other == name]
    coefficients = _fit(basis, modelled, y)[1]
    start = 1 + sum(basis.level_counts[basis.names.index(other)] - 1 for other in modelled[: modelled.index(name)])
    own = coefficients[start : start + basis.level_counts[index] - 1]
    return tuple(float(coefficients[0] + effect) for effect in (*own, -own.sum()))


def _checked(
    design: ArrayLike,
    values: ArrayLike,
    names: Sequence[str],
    level_counts: Sequence[int] | None,
    pooled: Collection[str],
) -> _Basis:
    """Return the model's basis, or raise ValueError in a sentence."""
    levels, y = np.asarray(design, dtype=np.int64), np.asarray(values, dtype=float)
    if y.ndim != 1 or levels.shape != (len(y), len(names)) or not len(y):
        raise ValueError(
            f"The design has shape {levels.shape}, the values {y.shape} and there are {len(names)} names; expected "
            f"(runs, factors), (runs,) and a name for each factor."
        )
    if len(set(names)) != len(names) or not set(pooled) <= set(names):
        raise ValueError(
            f"The factors are {list(names)}, pooled are {list(pooled)}; expected different names, and pooled ones "
            f"among them."
        )
    if not np.isfinite(y).all() or np.ptp(y) == 0:
        raise ValueError("The values are not all finite, or all the same; there is no variance to analyse.")
    counts = tuple(level_counts) if level_counts is not None else tuple(int(n) + 1 for n in levels.max(axis=0))
    basis = _Basis(levels, tuple(names), counts)
    matrix = basis.columns(names)
    if np.linalg.matrix_rank(matrix) < matrix.shape[1]:
        raise ValueError(
            f"The {len(y)} runs do not determine the {matrix.shape[1]} means of the additive model; expected runs on "
            f"every level of every factor: add runs or leave out a factor."
        )
    return basis
