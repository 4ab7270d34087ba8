"""The Runge-Kutta coefficients against the order conditions and against SciPy's."""

import numpy as np
import pytest
from scipy.integrate import RK45

from seat_gear_dynamics.motion.integrators.tableau import DORMAND_PRINCE, RUNGE_KUTTA_4, Tableau

METHODS = {"Runge-Kutta 4": RUNGE_KUTTA_4, "Dormand-Prince": DORMAND_PRINCE}


def conditions(t: Tableau) -> list[tuple[int, np.ndarray, float]]:
    """Return (order, weights on b, wanted sum) of all 17 trees to order five (Hairer et al. 1993, table II.2.1)."""
    a, c = t.stages, t.nodes
    ac, ac2, aac = a @ c, a @ c**2, a @ a @ c
    return [
        (1, c**0, 1),
        (2, c, 1 / 2),
        (3, c**2, 1 / 3),
        (3, ac, 1 / 6),
        (4, c**3, 1 / 4),
        (4, c * ac, 1 / 8),
        (4, ac2, 1 / 12),
        (4, aac, 1 / 24),
        (5, c**4, 1 / 5),
        (5, c**2 * ac, 1 / 10),
        (5, ac**2, 1 / 20),
        (5, c * ac2, 1 / 15),
        (5, a @ c**3, 1 / 20),
        (5, c * aac, 1 / 30),
        (5, a @ (c * ac), 1 / 40),
        (5, a @ ac2, 1 / 60),
        (5, a @ aac, 1 / 120),
    ]


def highest_order(t: Tableau, weights: np.ndarray) -> int:
    """Return the order up to which all conditions hold."""
    failed = [order for order, sums, wanted in conditions(t) if abs(weights @ sums - wanted) > 1e-13]
    return min(failed, default=6) - 1


@pytest.mark.parametrize("name", METHODS)
def test_every_tableau_has_the_order_that_it_states(name: str) -> None:
    t = METHODS[name]
    assert highest_order(t, t.stages[-1]) == t.order


def test_the_embedded_method_of_dormand_and_prince_has_order_four() -> None:
    assert highest_order(DORMAND_PRINCE, DORMAND_PRINCE.stages[-1] - DORMAND_PRINCE.error) == 4


@pytest.mark.parametrize("name", METHODS)
def test_the_polynomial_inside_a_step_ends_in_the_step_and_begins_with_its_slope(name: str) -> None:
    t = METHODS[name]
    assert t.between.sum(axis=1) == pytest.approx(t.stages[-1], abs=1e-14)
    assert t.between[:, 0].tolist() == [1.0] + [0.0] * (len(t.nodes) - 1)


def test_dormand_and_prince_is_scipys() -> None:
    assert DORMAND_PRINCE.stages[:6, :5] == pytest.approx(RK45.A, abs=1e-15)
    assert DORMAND_PRINCE.stages[6, :6] == pytest.approx(RK45.B, abs=1e-15)
    assert DORMAND_PRINCE.error == pytest.approx(-RK45.E, abs=1e-15)
    assert DORMAND_PRINCE.between == pytest.approx(RK45.P, abs=1e-15)
