"""Continuation on curves known in closed form, and the Duffing oscillator's response through both folds.

Duffing: x″ + 2ζx′ + x + γx³ = P cos ωτ. With one harmonic of amplitude a the balance is the cubic in a² of Kovacic &
Brennan, "The Duffing Equation" (2011): a²·((1 - ω² + ¾γa²)² + (2ζω)²) = P².
"""

from dataclasses import dataclass
from itertools import islice, pairwise
from math import sqrt

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from seat_gear_dynamics.studies.harmonic_balance.branch import Motion
from seat_gear_dynamics.studies.harmonic_balance.continuation import Arc, Point, follow, start, step_along
from seat_gear_dynamics.studies.harmonic_balance.fourier import Basis, amplitudes, evaluate, from_amplitudes
from seat_gear_dynamics.studies.harmonic_balance.newton import NoSolutionError, solve
from seat_gear_dynamics.studies.harmonic_balance.tracing import _closes

Array = NDArray[np.float64]


class Circle:
    """x² + λ² = 1: folds at λ = ±1."""

    def evaluate(self, unknowns: Array, parameter: float) -> tuple[Array, Array, Array]:
        return np.array([unknowns[0] ** 2 + parameter**2 - 1]), np.array([[2 * unknowns[0]]]), np.array([2 * parameter])


class Cusp:
    """λ = x³ - x: folds at x = ±1/√3, where λ = ∓2/(3√3)."""

    def evaluate(self, unknowns: Array, parameter: float) -> tuple[Array, Array, Array]:
        x = unknowns[0]
        return np.array([x**3 - x - parameter]), np.array([[3 * x**2 - 1]]), np.array([-1.0])


class Edge:
    """sqrt(1 - λ) = x: the branch ends where λ reaches 1, beyond which there is nothing to evaluate."""

    def evaluate(self, unknowns: Array, parameter: float) -> tuple[Array, Array, Array]:
        if parameter > 1:
            raise ValueError(f"The parameter is {parameter}, expected at most 1.")
        return np.array([unknowns[0] - 2 + parameter]), np.array([[1.0]]), np.array([1.0])


def test_a_circle_is_followed_round_and_stays_one() -> None:
    arc = Arc(1.0, 1.0, longest=0.2)
    first = start(Circle(), np.array([1.1]), 0.0, arc)
    points = list(islice(follow(Circle(), first, -2.0, 2.0, arc), 60))
    # TOLERANCE of Newton's method on a residual of slope 2.
    assert all(p.unknowns[0] ** 2 + p.parameter**2 == pytest.approx(1.0, abs=1e-9) for p in points)
    angles = np.unwrap([np.arctan2(p.parameter, p.unknowns[0]) for p in points])
    assert np.all(np.diff(angles) > 0)
    assert angles[-1] - angles[0] > 2 * np.pi


def test_a_closed_branch_is_seen_to_close_when_it_has_gone_round_once() -> None:
    arc = Arc(1.0, 1.0, longest=0.2)
    first = start(Circle(), np.array([1.0]), 0.0, arc)
    motions = [Motion(None, p) for p in (first, *islice(follow(Circle(), first, -2.0, 2.0, arc), 60))]  # type: ignore[arg-type]
    angles = np.unwrap([np.arctan2(m.parameter, m.point.unknowns[0]) for m in motions])
    closed = next(n for n in range(4, len(motions)) if _closes(motions[:n], arc))
    assert angles[closed - 2] < 2 * np.pi <= angles[closed - 1]


def test_tangents_are_those_of_the_circle() -> None:
    arc = Arc(1.0, 1.0)
    for point in islice(follow(Circle(), start(Circle(), np.array([1.0]), 0.0, arc), -2.0, 2.0, arc), 20):
        assert point.tangent == pytest.approx([-point.parameter, point.unknowns[0]], abs=1e-8)


def test_both_folds_of_a_cubic_are_passed_and_the_range_ends_it_on_its_bound() -> None:
    arc = Arc(1.0, 1.0, longest=0.05)
    points = list(follow(Cusp(), start(Cusp(), np.array([-2.0]), -2.0, arc), -2.0, 2.0, arc))
    parameters = [p.parameter for p in points]
    turns = [b for a, b, c in zip(parameters, parameters[1:], parameters[2:], strict=False) if (b - a) * (c - b) < 0]
    # A parabola of curvature 6/√3·½ meets a step of 0.05 at most 0.05² from its vertex.
    assert turns == pytest.approx([2 / (3 * sqrt(3)), -2 / (3 * sqrt(3))], abs=0.01)
    assert parameters[-1] == 2.0
    assert points[-1].unknowns[0] == pytest.approx(brentq(lambda x: x**3 - x - 2, 1, 2))


def test_backward_is_the_same_way_back() -> None:
    arc = Arc(1.0, 1.0)
    first = start(Cusp(), np.array([2.0]), 4.0, arc, upward=False)
    assert first.tangent[-1] < 0
    assert list(follow(Cusp(), first, -1.0, 4.0, arc))[-1].parameter == -1.0


def test_a_parameter_that_leaves_its_possible_values_ends_the_branch_in_a_sentence() -> None:
    arc = Arc(1.0, 1.0)
    with pytest.raises(NoSolutionError, match="expected at most 1"):
        list(follow(Edge(), start(Edge(), np.array([1.5]), 0.5, arc), 0.0, 2.0, arc))


def test_newton_says_where_it_found_nothing() -> None:
    with pytest.raises(NoSolutionError, match="parameter 3"):
        solve(Circle(), np.array([1.0]), 3.0)


@dataclass(frozen=True)
class Duffing:
    """The oscillator's harmonic balance, by the alternating frequency-time scheme as the gears have it."""

    basis: Basis
    zeta: float = 0.02
    gamma: float = 0.5
    force: float = 0.06

    def evaluate(self, unknowns: Array, parameter: float) -> tuple[Array, Array, Array]:
        nu = self.basis.orders * parameter
        dynamic, turned = 1 - nu**2 + 2j * self.zeta * nu, amplitudes(unknowns)
        x = self.basis.values(unknowns)
        driven = np.where(self.basis.orders == 1, self.force, 0.0)
        spring = amplitudes(self.basis.coefficients(self.gamma * x**3))
        residual = dynamic * turned + spring - driven
        linear = from_amplitudes(dynamic[:, None] * amplitudes(np.eye(self.basis.size)))
        slope = self.basis.orders * (2j * self.zeta - 2 * nu) * turned
        jacobian = linear + self.basis.multiplication(3 * self.gamma * x**2)
        return from_amplitudes(residual), jacobian, from_amplitudes(slope)

    def squared_frequency(self, amplitude: float, sign: float) -> float:
        """Return ω² of the cubic at one amplitude: a quadratic in ω², its upper or lower root."""
        b = 2 * self.zeta**2 - 1 - 0.75 * self.gamma * amplitude**2
        c = (1 + 0.75 * self.gamma * amplitude**2) ** 2 - (self.force / amplitude) ** 2
        return -b + sign * sqrt(max(b**2 - c, 0.0))

    def folds(self) -> list[float]:
        """Return both frequencies at which dω/da is 0 on the cubic, the jump down first, by bisection."""
        step, least = 1e-6, 1e-3
        peak = brentq(
            lambda a: (
                (1 + 0.75 * self.gamma * a**2 - 2 * self.zeta**2) ** 2
                - ((1 + 0.75 * self.gamma * a**2) ** 2 - (self.force / a) ** 2)
            ),
            0.1,
            5.0,
        )
        found = []
        for sign in (-1.0, 1.0):
            grid = np.linspace(0.05, peak - least, 4000)

            def slope(a: float, sign: float = sign) -> float:
                return self.squared_frequency(a + step, sign) - self.squared_frequency(a - step, sign)

            valid = [a for a in grid if self.squared_frequency(a, sign) > 0.25]
            found += [
                sqrt(self.squared_frequency(brentq(slope, a, b), sign))
                for a, b in pairwise(valid)
                if slope(a) * slope(b) < 0
            ]
        return sorted(found, reverse=True)


ARC = Arc(0.2, 0.02)


def branch(problem: Duffing) -> list[Point]:
    first = start(problem, np.zeros(problem.basis.size), 0.5, ARC)
    return [first, *follow(problem, first, 0.5, 2.5, ARC)]


def turning(problem: Duffing, points: list[Point]) -> list[float]:
    """Return the parameters at which the branch turns, by bisection on the tangent."""
    found = []
    for a, b in pairwise(points):
        if a.tangent[-1] * b.tangent[-1] < 0:
            length = float((ARC.scaled(b.unknowns, b.parameter) - ARC.scaled(a.unknowns, a.parameter)) @ a.tangent)

            def rise(step: float, a: Point = a) -> float:
                return float(step_along(problem, a, step, ARC)[0].tangent[-1])

            found.append(step_along(problem, a, brentq(rise, 0.0, length), ARC)[0].parameter)
    return found


def test_one_harmonic_of_duffing_is_the_cubic() -> None:
    problem = Duffing(Basis(1, 16))
    points = branch(problem)
    assert points[-1].parameter == 2.5
    for point in points:
        a2 = float((point.unknowns[1:] ** 2).sum())
        w = point.parameter
        left = a2 * ((1 - w**2 + 0.75 * problem.gamma * a2) ** 2 + (2 * problem.zeta * w) ** 2)
        assert left == pytest.approx(problem.force**2, rel=1e-7)  # TOLERANCE over the force


def test_both_folds_of_duffing_are_those_of_the_cubic() -> None:
    problem = Duffing(Basis(1, 16))
    assert len(problem.folds()) == 2
    # brentq on differences of 1e-6: the fold's frequency is flat in the amplitude, so its error is their square.
    assert turning(problem, branch(problem)) == pytest.approx(problem.folds(), abs=1e-7)


def test_jump_down_is_near_the_published_approximation() -> None:
    # Brennan, Kovacic, Carrella & Waters 2008 (J. Sound Vib. 318, 1250-1261), jump-down frequency for small damping:
    # ω_d² = ½·(1 + sqrt(1 + 3γP²/(4ζ²))), whose neglected terms are of the order ζ².
    problem = Duffing(Basis(1, 16))
    approximate = sqrt((1 + sqrt(1 + 0.75 * problem.gamma * problem.force**2 / problem.zeta**2)) / 2)
    assert max(turning(problem, branch(problem))) == pytest.approx(approximate, rel=4 * problem.zeta**2)


def test_many_harmonics_of_duffing_are_its_integrated_motion() -> None:
    problem = Duffing(Basis(11, 64))
    low = next(p for p in branch(problem) if p.parameter > 0.9)
    found = solve(problem, low.unknowns, 0.9)
    x, rate = evaluate(found, 0.0)

    def motion(t: float, y: Array) -> list[float]:
        force = problem.force * np.cos(0.9 * t)
        return [y[1], force - 2 * problem.zeta * y[1] - y[0] - problem.gamma * y[0] ** 3]

    period = 2 * np.pi / 0.9
    times = np.linspace(0, period, 33)
    outside = solve_ivp(
        motion, (0, period), [float(x), float(rate) / period], rtol=1e-11, atol=1e-12, t_eval=times, method="DOP853"
    )
    # Odd harmonics fall by about a factor of 100 each: the first left out, the 13th, is below 1e-9.
    assert outside.y[0] == pytest.approx(evaluate(found, times / period)[0], abs=1e-8)
