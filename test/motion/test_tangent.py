"""The growth of the tangent that rides along with the motion."""

from collections.abc import Callable
from math import pi

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import Inputs, March, System, integrate

Array = NDArray[np.float64]
MakeTrain = Callable[..., GearTrain]


def least_decay(train: GearTrain, mesh: int) -> float:
    """Return the largest real part of the eigenvalues of one mesh's linear state matrix, per unit of τ."""
    pair = train.meshes[mesh]
    gears = (pair.driver, pair.driven)
    mass = np.array([m for g in gears for m in (g.mass, g.mass, g.equivalent_mass)])
    stiff = np.array([k for g in gears for k in (g.support_stiffness, g.support_stiffness, g.torsional_stiffness)])
    zeta = np.array(
        [z for g in gears for z in (g.support_damping_ratio, g.support_damping_ratio, g.torsional_damping_ratio)]
    )
    s, c = np.sin(pair.driver.pressure_angle), np.cos(pair.driver.pressure_angle)
    w = np.array([-s, c, 1, s, -c, 1])
    stiffness = np.diag(stiff) + pair.mean_model_stiffness * np.outer(w, w)
    damping = np.diag(2 * zeta * np.sqrt(stiff * mass)) + pair.damping * np.outer(w, w)
    state = np.block([[np.zeros((6, 6)), np.eye(6)], [-stiffness / mass[:, None], -damping / mass[:, None]]])
    return float(np.linalg.eigvals(state).real.max() / train.derived_time_scale)


@pytest.mark.parametrize("frequency", [1.0, -0.7])
def test_exponents_of_a_linear_train_are_the_largest_real_parts_of_its_eigenvalues(
    make_train: MakeTrain, steady: Callable[..., GearTrain], frequency: float
) -> None:
    described = {"*damping_ratio": 0.3, "*.torsional_stiffness": 2e7, "*.error_amplitude": [0.01, 0]}
    train = steady(make_train(described))
    response = integrate(System(train).at(frequency=frequency, load=600.0), transient=400, periods=900)
    assert response.windows[0].contact_loss == response.windows[1].contact_loss == 0
    # The norm of a decaying oscillation swings about its decay: the slope of a fit sees the decay alone.
    found = np.polyfit(response.period * np.arange(900), response.growth.cumsum(axis=0), 1)[0]
    assert found == pytest.approx([least_decay(train, 0), least_decay(train, 1)], rel=0.01)
    assert np.all(found < 0)


def test_exponent_does_not_depend_on_the_step(train: GearTrain) -> None:
    system = System(train).at(frequency=0.5, load=600.0)
    coarse = integrate(system, transient=0, periods=50)
    fine = integrate(system, transient=0, periods=50, target_steps=1024)
    assert fine.growth.sum(axis=0) == pytest.approx(coarse.growth.sum(axis=0), abs=1e-3)


def test_tangent_grows_as_two_neighbouring_motions_part(train: GearTrain) -> None:
    # Light load, so that teeth rattle: the state of P12 is disturbed by 1e-10 and both motions are followed.
    inputs, period = Inputs(1.0, 20.0), 2 * pi
    first, second = March(train, load=20.0), March(train, load=20.0)
    disturbed = second.state
    for own in (slice(0, 6), slice(12, 18)):
        disturbed[own] += 1e-10 * np.array([0.5, 0.3, 0.7, -0.2, 0.4, 0.6])
    second.state = disturbed
    apart: list[float] = []
    sections: list[Array] = []
    for n in range(1, 41):
        for march, collect in ((first, sections.append), (second, None)):
            march.advance((march.tau, inputs), ((n - 1e-4) * period, inputs), collect)
        apart.append(float(np.log(np.linalg.norm((second.state - first.state).reshape(4, 6)[::2]))))
    growth = np.concatenate(sections)[:, 3]
    # The first periods turn both into the direction of fastest growth.
    assert apart[-1] - apart[9] == pytest.approx(growth[10:].sum(), abs=0.5)
    assert growth[10:].sum() > 2


def test_growth_at_standstill_is_no_overflow(train: GearTrain) -> None:
    # No section comes at standstill; the tangent decays over 100 000 units of time and must not reach zero or NaN.
    march, still, turning = March(train, load=600.0), Inputs(0.0, 600.0), Inputs(1.0, 600.0)
    march.advance((0.0, still), (1e5, still))
    sections: list[Array] = []
    begin = march.tau
    march.advance((begin, turning), (begin + 13.0, turning), sections.append)
    growth = np.concatenate(sections)[:, 3:]
    assert np.all(np.isfinite(growth))
    assert np.all(growth[0] < 0)
