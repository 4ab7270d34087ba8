"""Lyapunov spectra of maps and flows against analytic values and the literature's."""

from math import cos, log, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from seat_gear_dynamics.regimes.spectrum import Spectrum, along_flow, along_map, spectrum

Array = NDArray[np.float64]


def henon(count: int) -> Spectrum:
    advance = along_map(
        lambda s: np.array([1 - 1.4 * s[0] ** 2 + s[1], 0.3 * s[0]]),
        lambda s: np.array([[-2.8 * s[0], 1.0], [0.3, 0.0]]),
        [0.1, 0.1],
    )
    return spectrum(advance, np.eye(2), count, discard=100)


def test_henon_map_has_the_published_spectrum_whose_sum_is_the_logarithm_of_its_contraction() -> None:
    # 0.41922 and −1.62319 (Sprott 2003, Chaos and Time-Series Analysis); the determinant is −0.3 everywhere.
    found = henon(8000)
    assert found.values == pytest.approx([0.41922, -1.62319], abs=4 * float(found.errors.max()))
    assert found.errors.max() < 0.01
    assert found.sum == pytest.approx(log(0.3), abs=1e-12)


def test_delayed_logistic_map_has_the_published_spectrum() -> None:
    # x(n + 1) = 2.27·x(n)·(1 − x(n − 1)): 0.18312 and −1.24199 (Sprott 2003).
    advance = along_map(
        lambda s: np.array([2.27 * s[0] * (1 - s[1]), s[0]]),
        lambda s: np.array([[2.27 * (1 - s[1]), -2.27 * s[0]], [1.0, 0.0]]),
        [0.5, 0.4],
    )
    found = spectrum(advance, np.eye(2), 8000, discard=100)
    assert (abs(found.values - [0.18312, -1.24199]) < 4 * found.errors).all()
    assert found.errors.max() < 0.03


def lorenz(t: float, s: Array) -> Array:
    x, y, z = s
    return np.array([10 * (y - x), 28 * x - y - x * z, x * y - 8 / 3 * z])


def lorenz_jacobian(t: float, s: Array) -> Array:
    x, y, z = s
    return np.array([[-10.0, 10.0, 0.0], [28 - z, -1.0, -x], [y, x, -8 / 3]])


def test_lorenz_flow_has_the_published_spectrum_and_the_sum_of_its_constant_divergence() -> None:
    # 0.9056, 0, −14.5723 (Sprott 2003); the trace of the Jacobian is −41/3 everywhere. Runge-Kutta of step 0.01 keeps
    # the sum to (14.6·0.01)⁵/120/0.01 = 5e-5 per unit of time in each direction.
    advance = along_flow(lorenz, lorenz_jacobian, [1.0, 1.0, 20.0], interval=0.5, steps=50)
    found = spectrum(advance, np.eye(3), 800, interval=0.5, discard=40)
    assert (abs(found.values - [0.9056, 0, -14.5723]) < 4 * found.errors).all()
    assert found.errors.max() < 0.02
    assert found.sum == pytest.approx(-41 / 3, abs=3e-4)


def test_uedas_oscillator_has_the_published_spectrum_per_unit_of_time() -> None:
    # x″ + 0.05·x′ + x³ = 7.5·cos t: 0.1034 and −0.1534 beside the zero of time itself (Sprott 2003). One interval is a
    # period of the excitation, so this is the stroboscopic map's spectrum over 2π.
    advance = along_flow(
        lambda t, s: np.array([s[1], 7.5 * cos(t) - 0.05 * s[1] - s[0] ** 3]),
        lambda t, s: np.array([[0.0, 1.0], [-3 * s[0] ** 2, -0.05]]),
        [2.5, 0.0],
        interval=2 * pi,
        steps=100,
    )
    found = spectrum(advance, np.eye(2), 600, interval=2 * pi, discard=50)
    assert (abs(found.values - [0.1034, -0.1534]) < 4 * found.errors).all()
    assert found.errors.max() < 0.01
    # Step 0.063, fastest turn √(3·3.5²) = 6: ((6·0.063)⁶/144)/0.063 = 3e-4 at the ends of the swing, less elsewhere.
    assert found.sum == pytest.approx(-0.05, abs=3e-4)


def van_der_pol(t: float, s: Array) -> Array:
    return np.array([s[1], (1 - s[0] ** 2) * s[1] - s[0]])


def test_a_limit_cycle_has_a_zero_exponent_and_one_that_is_its_mean_divergence() -> None:
    advance = along_flow(
        van_der_pol,
        lambda t, s: np.array([[0.0, 1.0], [-2 * s[0] * s[1] - 1, 1 - s[0] ** 2]]),
        [2.0, 0.0],
        interval=0.5,
        steps=25,
    )
    found = spectrum(advance, np.eye(2), 400, interval=0.5, discard=60)
    # Along the cycle a tangent is as long as the velocity, between 0.2 and 2.7: its logarithm over 200 units of time.
    assert found.values[0] == pytest.approx(0, abs=log(2.7 / 0.2) / 200)
    mean = solve_ivp(
        lambda t, s: [*van_der_pol(t, s[:2]), 1 - s[0] ** 2], (0, 200), [*cycle_point(), 0.0], rtol=1e-9, atol=1e-9
    )
    # Both are means over 200 units and 30 cycles; parts of one cycle are left, of divergence 1 to −3 over half a cycle.
    assert found.sum == pytest.approx(mean.y[2, -1] / 200, abs=2 * 3 / 200)


def cycle_point() -> Array:
    return np.asarray(solve_ivp(van_der_pol, (0, 60), [2.0, 0.0], rtol=1e-9, atol=1e-9).y[:, -1])


@settings(max_examples=25)
@given(st.lists(st.floats(-2, 2), min_size=9, max_size=9), st.floats(0.1, 10))
def test_a_constant_matrix_has_the_logarithms_of_its_eigenvalues(entries: list[float], interval: float) -> None:
    rates = np.sort(entries[:3])[::-1] + np.array([0.5, 0.0, -0.5])  # apart, so that directions separate
    basis = np.eye(3) + 0.2 * np.array(entries).reshape(3, 3) / 2
    matrix = basis @ np.diag(np.exp(rates)) @ np.linalg.inv(basis)
    found = spectrum(lambda z: matrix @ z, np.eye(3), 32, interval=interval, discard=200)
    # 200 steps of at least a half in separation leave exp(−100) of the wrong direction, and rounding.
    assert found.values * interval == pytest.approx(rates, abs=1e-9)
    assert found.errors * interval == pytest.approx(0, abs=1e-9)


def test_the_sum_is_the_mean_logarithm_of_the_volume_of_any_map() -> None:
    rng = np.random.default_rng(0)
    matrices = rng.normal(size=(100, 4, 4))
    steps = iter(matrices)
    found = spectrum(lambda z: next(steps) @ z, np.eye(4), 100)
    # 100 = 8·12 + 4: exponents leave out the oldest four.
    assert found.growth.sum(axis=1) == pytest.approx(np.log(abs(np.linalg.det(matrices))), abs=1e-10)
    assert found.sum == pytest.approx(np.log(abs(np.linalg.det(matrices[4:]))).mean(), abs=1e-10)


def test_fewer_directions_give_the_largest_exponents() -> None:
    matrices = np.random.default_rng(1).normal(size=(64, 3, 3))

    def first(k: int) -> Array:
        steps = iter(matrices)
        return spectrum(lambda z: next(steps) @ z, np.eye(3)[:, :k], 64).values

    assert first(1) == pytest.approx(first(3)[:1], abs=1e-10)
    assert first(2) == pytest.approx(first(3)[:2], abs=1e-10)


@pytest.mark.parametrize("interval", [0.25, 6.0])
def test_exponents_of_the_stroboscopic_map_are_the_period_times_those_of_the_flow(interval: float) -> None:
    # A linear flow, whose map over one interval is an exponential of a diagonal matrix.
    rates = np.array([-0.2, -0.5])
    of_map = spectrum(along_map(lambda s: s, lambda s: np.diag(np.exp(rates * interval)), [0.0]), np.eye(2), 16)
    flow = along_flow(lambda t, s: rates * s, lambda t, s: np.diag(rates), [1.0, 1.0], interval=interval, steps=200)
    of_flow = spectrum(flow, np.eye(2), 16, interval=interval)
    # Runge-Kutta of step 0.03 and less on rates of 0.5: (0.5·0.03)⁵/120/0.03 < 1e-9.
    assert of_map.values == pytest.approx(interval * of_flow.values, abs=1e-8)


def test_state_and_time_go_on_from_interval_to_interval() -> None:
    # x′ = t·x: log x = t²/2, integrated over unequal cuts of the same stretch.
    def growth(interval: float, steps: int, count: int) -> float:
        flow = along_flow(
            lambda t, s: t * s, lambda t, s: np.array([[t]]), [1.0], interval=interval, steps=steps, begin=1.0
        )
        return float(spectrum(flow, np.eye(1), count, interval=interval).growth.sum())

    assert growth(0.05, 10, 40) == pytest.approx((3**2 - 1) / 2, abs=1e-9)
    assert growth(0.1, 20, 20) == pytest.approx(growth(0.05, 10, 40), abs=1e-12)


@pytest.mark.parametrize("tangent", [np.zeros(2), np.zeros((2, 0)), np.eye(3)[:2]])
def test_tangents_of_other_shapes_are_refused(tangent: Array) -> None:
    with pytest.raises(ValueError, match=r"expected \(d, k\) with k from 1 to d"):
        spectrum(lambda z: z, tangent, 16)


def test_arguments_that_make_no_spectrum_are_refused() -> None:
    with pytest.raises(ValueError, match="The 2 tangents are not independent"):
        spectrum(lambda z: z, np.ones((3, 2)), 16)
    with pytest.raises(ValueError, match="Asked for 15 intervals after 0"):
        spectrum(lambda z: z, np.eye(2), 15)
    with pytest.raises(ValueError, match="Asked for 16 intervals after -1"):
        spectrum(lambda z: z, np.eye(2), 16, discard=-1)
    with pytest.raises(ValueError, match="The interval is 0"):
        spectrum(lambda z: z, np.eye(2), 16, interval=0)
    with pytest.raises(ValueError, match=r"Interval 0 returned tangents of shape \(2, 1\); expected \(2, 2\)"):
        spectrum(lambda z: z[:, :1], np.eye(2), 16)
    with pytest.raises(ValueError, match="Asked for 0 steps"):
        along_flow(lorenz, lorenz_jacobian, [1.0, 1.0, 1.0], interval=0.5, steps=0)


def test_a_direction_that_collapses_and_a_motion_that_diverges_are_said_and_not_counted() -> None:
    with pytest.raises(ArithmeticError, match="In interval 0 tangent 1 collapsed"):
        spectrum(lambda z: np.diag([1.0, 0.0]) @ z, np.eye(2), 16)
    steps = iter([1.0, 1.0, 1.0, float("nan")])
    with pytest.raises(ArithmeticError, match="In interval 3 the tangents stopped being finite"):
        spectrum(lambda z: next(steps) * z, np.eye(2), 16)


def test_golden_value() -> None:
    # Sixteen steps of the Hénon map: too few for the chaos of its rounding to show.
    found = spectrum(
        along_map(
            lambda s: np.array([1 - 1.4 * s[0] ** 2 + s[1], 0.3 * s[0]]),
            lambda s: np.array([[-2.8 * s[0], 1.0], [0.3, 0.0]]),
            [0.1, 0.1],
        ),
        np.eye(2),
        16,
    )
    assert found.values == pytest.approx([0.36025258381264463, -1.56422538813858], abs=1e-9)
