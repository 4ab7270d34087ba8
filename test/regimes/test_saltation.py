"""The saltation matrix against the exact flow of a one-sided oscillator, and against its own law."""

from math import cos, log, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import brentq

from seat_gear_dynamics.regimes.spectrum import CrossingError, saltation, spectrum

Array = NDArray[np.float64]

FORCE, FREQUENCY, DAMPING, DAMPER = 1.0, 0.8, 0.05, 0.7


class Linear:
    """Exact flow of x″ + damping·x′ + stiffness·x = cos 0.8t."""

    def __init__(self, stiffness: float, damping: float) -> None:
        self.matrix = np.array([[0.0, 1.0], [-stiffness, -damping]])
        self.eigenvalues, self.modes = np.linalg.eig(self.matrix)
        self.inverse = np.linalg.inv(self.modes)
        self.forced = np.linalg.solve(1j * FREQUENCY * np.eye(2) - self.matrix, np.array([0, FORCE]))

    def rates(self, t: float, state: Array) -> Array:
        return np.asarray(self.matrix @ state + [0, FORCE * cos(FREQUENCY * t)])

    def tangent(self, time: float) -> Array:
        return np.asarray(np.real(self.modes * np.exp(self.eigenvalues * time) @ self.inverse))

    def move(self, t: float, state: Array, until: float) -> Array:
        begin, end = (np.real(self.forced * np.exp(1j * FREQUENCY * at)) for at in (t, until))
        return np.asarray(end + self.tangent(until - t) @ (state - begin))


FREE, CONTACT = Linear(1.0, 2 * DAMPING), Linear(4.0, 2 * DAMPING + DAMPER)
"""Beyond the stop there is three times as much spring again, and a damper that acts at once."""


class OneSided:
    """Exact flow of the oscillator with a stop at h = x − amplitude·sin(FREQUENCY·t) = 0; contact where h > 0."""

    def __init__(self, amplitude: float = 0.0) -> None:
        self.amplitude = amplitude

    def gap(self, t: float, state: Array) -> float:
        return float(state[0] - self.amplitude * sin(FREQUENCY * t))

    def flow(
        self, t: float, state: Array, until: float, *, scan: float = 0.05, corrected: bool = True
    ) -> tuple[Array, Array, float]:
        """Return the state at `until`, the tangent map from t to it, and the time spent in contact."""
        tangent, touched, side = np.eye(2), 0.0, CONTACT if self.gap(t, state) > 0 else FREE
        while t < until:
            ahead, crossed = min(t + scan, until), False
            if (self.gap(ahead, side.move(t, state, ahead)) > 0) != (side is CONTACT):
                ahead, crossed = self._crossing(side, t, state, ahead), True
            tangent = side.tangent(ahead - t) @ tangent
            touched += (ahead - t) * (side is CONTACT)
            t, state = ahead, side.move(t, state, ahead)
            if crossed:
                side, jump = self._across(side, t, state)
                tangent = jump @ tangent if corrected else tangent
        return state, tangent, touched

    def _crossing(self, side: Linear, t: float, state: Array, ahead: float) -> float:
        # A billionth later, because at a crossing just made the gap is zero up to rounding.
        return float(brentq(lambda at: self.gap(at, side.move(t, state, at)), t + 1e-9, ahead, xtol=1e-15, rtol=1e-15))

    def _across(self, side: Linear, t: float, state: Array) -> tuple[Linear, Array]:
        other = FREE if side is CONTACT else CONTACT
        # The spring beyond the stop starts at x = 0, so where the stop moves the spring's force jumps as well.
        rate = -self.amplitude * FREQUENCY * cos(FREQUENCY * t)
        return other, saltation(side.rates(t, state), other.rates(t, state), [1.0, 0.0], rate)


@pytest.mark.parametrize("amplitude", [0.0, 0.3])
@pytest.mark.parametrize("seed", range(4))
def test_tangents_through_contacts_are_the_differences_of_the_exact_flow(amplitude: float, seed: int) -> None:
    oscillator = OneSided(amplitude)
    start = np.random.default_rng(seed).normal(size=2)
    _, tangent, touched = oscillator.flow(0.0, start, 12.0)
    assert 0 < touched < 12
    step = 1e-5
    differences = []
    for direction in np.eye(2):
        ahead, behind = (oscillator.flow(0.0, start + sign * step * direction, 12.0)[0] for sign in (1, -1))
        differences.append((ahead - behind) / (2 * step))
    # Central differences: third derivatives of order 10 to 100 times step², and 1e-15 of the crossings over step.
    assert np.column_stack(differences) == pytest.approx(tangent, abs=1e-7)
    # Left out, the jumps of the force are missed by far more: the comparison above is able to fail.
    assert abs(oscillator.flow(0.0, start, 12.0, corrected=False)[1] - tangent).max() > 1e-2


@given(st.floats(0.01, 100), st.floats(-10, 10))
def test_a_damper_that_acts_at_once_has_a_matrix_that_does_not_depend_on_the_speed(speed: float, pull: float) -> None:
    # S = [[1, 0], [−c, 1]] on entering contact, and its inverse on leaving. The rate of 10 over a speed of 0.01 costs
    # three digits of the 1e-16.
    entering = saltation([speed, pull], [speed, pull - DAMPER * speed], [1.0, 0.0])
    assert entering == pytest.approx(np.array([[1, 0], [-DAMPER, 1]]), abs=1e-12)
    leaving = saltation([-speed, pull + DAMPER * speed], [-speed, pull], [1.0, 0.0])
    assert leaving @ entering == pytest.approx(np.eye(2), abs=1e-12)


def test_the_sum_of_exponents_through_contacts_is_the_mean_trace() -> None:
    # Each crossing keeps area (det S = 1), so only damping shrinks it: 2ζ always, and the damper's while in contact.
    oscillator, period, clock = OneSided(), 2 * pi / FREQUENCY, {"t": 0.0, "touched": 0.0}
    state = np.array([0.1, 0.2])

    def advance(tangent: Array) -> Array:
        nonlocal state
        state, through, touched = oscillator.flow(clock["t"], state, clock["t"] + period)
        clock["t"] += period
        clock["touched"] += touched
        return through @ tangent

    found = spectrum(advance, np.eye(2), 16, interval=period)
    expected = -2 * DAMPING - DAMPER * clock["touched"] / clock["t"]
    # Rounding of 16 periods of a hundred matrix products each.
    assert found.sum == pytest.approx(expected, abs=1e-9)


vectors = st.lists(st.floats(-10, 10), min_size=3, max_size=3).map(np.array)


@given(vectors, vectors, vectors, st.floats(-10, 10))
def test_the_rate_before_is_carried_into_the_rate_behind(
    before: Array, after: Array, normal: Array, normal_rate: float
) -> None:
    # Two points of one orbit, one step of time apart, stay so: with time as a coordinate, S·(f⁻, 1) = (f⁺, 1).
    speed, behind = normal @ before + normal_rate, normal @ after + normal_rate
    if not (abs(speed) > 1e-2 and speed * behind > 0):
        return
    extended = saltation(np.append(before, 1), np.append(after, 1), np.append(normal, normal_rate))
    # Products of numbers up to 300 over a speed of at least 0.01.
    assert extended @ np.append(before, 1) == pytest.approx(np.append(after, 1), abs=1e-8)
    plain = saltation(before, after, normal, normal_rate)
    assert extended[:3, :3] == pytest.approx(plain, rel=1e-9, abs=1e-9)


def test_a_bouncing_ball_has_the_known_matrix_and_the_differences_of_its_flight() -> None:
    gravity, restitution, speed = 9.81, 0.6, -3.0
    reset = np.diag([1.0, -restitution])
    found = saltation([speed, -gravity], [-restitution * speed, -gravity], [1.0, 0.0], reset=reset)
    # di Bernardo et al. 2008: [[−e, 0], [−g(1 + e)/v⁻, −e]].
    expected = [[-restitution, 0], [-gravity * (1 + restitution) / speed, -restitution]]
    assert found == pytest.approx(np.array(expected), abs=1e-12)

    def flight(height: float, rate: float, time: float) -> Array:
        fall = (rate + (rate**2 + 2 * gravity * height) ** 0.5) / gravity
        up, left = -restitution * (rate - gravity * fall), time - fall
        return np.array([up * left - gravity * left**2 / 2, up - gravity * left])

    # From 1 m at rest, to 0.3 s after: before the first and behind it the tangent grows by the time of flight.
    fall = (2 / gravity) ** 0.5
    matrix = saltation([-gravity * fall, -gravity], [restitution * gravity * fall, -gravity], [1.0, 0.0], reset=reset)
    tangent = np.array([[1, 0.3], [0, 1]]) @ matrix @ np.array([[1, fall], [0, 1]])
    step = 1e-5
    differences = np.column_stack(
        [
            (flight(1 + step, 0, fall + 0.3) - flight(1 - step, 0, fall + 0.3)) / (2 * step),
            (flight(1, step, fall + 0.3) - flight(1, -step, fall + 0.3)) / (2 * step),
        ]
    )
    assert tangent == pytest.approx(differences, abs=1e-8)


@given(vectors, vectors)
def test_a_rate_that_does_not_jump_needs_no_correction_even_when_grazing(rate: Array, normal: Array) -> None:
    if normal.any():
        assert (saltation(rate, rate, normal) == np.eye(3)).all()


@pytest.mark.parametrize("speed", [0.0, 1e-12, -1e-12])
def test_grazing_is_said_and_is_no_number(speed: float) -> None:
    with pytest.raises(CrossingError, match="The surface is grazed: its speed is"):
        saltation([speed, 1.0], [speed, 3.0], [1.0, 0.0])


def test_near_grazing_the_matrix_grows_as_one_over_the_speed() -> None:
    # A force that jumps by 2: S has 2/v below the diagonal.
    for speed in (1e-2, 1e-4, 1e-6):
        assert saltation([speed, 1.0], [speed, 3.0], [1.0, 0.0])[1, 0] == pytest.approx(2 / speed)


def test_a_moving_surface_is_grazed_where_it_moves_along() -> None:
    with pytest.raises(CrossingError, match="grazed"):
        saltation([0.5, 1.0], [0.5, 3.0], [1.0, 0.0], -0.5)
    assert saltation([0.0, 1.0], [0.0, 3.0], [1.0, 0.0], -0.5)[1, 0] == pytest.approx(-4)


def test_a_motion_that_does_not_come_out_behind_slides() -> None:
    with pytest.raises(CrossingError, match=r"met with speed 1 but left with -0\.5: the motion slides"):
        saltation([1.0, 0.0], [-0.5, 0.0], [1.0, 0.0])


def test_arguments_that_make_no_crossing_are_refused() -> None:
    with pytest.raises(ValueError, match=r"shapes \(2,\), \(3,\) and \(2,\); expected one shape"):
        saltation([1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0])
    with pytest.raises(ValueError, match="not finite"):
        saltation([float("nan"), 0.0], [1.0, 0.0], [1.0, 0.0])
    with pytest.raises(ValueError, match="not finite"):
        saltation([1.0, 0.0], [1.0, 0.0], [1.0, 0.0], float("inf"))
    with pytest.raises(ValueError, match="normal of a crossing is zero"):
        saltation([1.0, 0.0], [1.0, 1.0], [0.0, 0.0])
    with pytest.raises(ValueError, match=r"The reset has shape \(3, 3\); expected \(2, 2\)"):
        saltation([1.0, 0.0], [1.0, 1.0], [1.0, 0.0], reset=np.eye(3))


def test_golden_value() -> None:
    found = saltation([0.4, -1.2, 0.3], [0.4, -2.0, 0.9], [1.0, 0.5, 0.0], 0.7)
    assert found == pytest.approx(np.array([[1, 0, 0], [-1.6, 0.2, 0], [1.2, 0.6, 1]]), abs=1e-12)
    assert log(np.linalg.det(found)) == pytest.approx(log(0.2))
