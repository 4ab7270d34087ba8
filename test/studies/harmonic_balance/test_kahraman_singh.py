"""The oscillator of Kahraman & Singh 1990 (J. Sound Vib. 142, 49-75): closed forms, free motion, integration.

x″ + 2ζx′ + f(x) = F_m + F_ah·Ω²·sin Ωτ with f the dead zone of half width 1. The paper's figures are not held here as
numbers; its one-term solution is, which is that of Comparin & Singh 1989 (J. Sound Vib. 134, 259-290).
"""

from collections.abc import Callable
from math import acos, asin, pi, sqrt

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from seat_gear_dynamics.motion import System
from seat_gear_dynamics.studies.harmonic_balance import Branch, pair, response_curve
from seat_gear_dynamics.studies.harmonic_balance.balance import Balance
from seat_gear_dynamics.studies.harmonic_balance.continuation import Arc, start
from seat_gear_dynamics.studies.harmonic_balance.first_motion import first_motion
from seat_gear_dynamics.studies.harmonic_balance.fourier import Basis
from seat_gear_dynamics.studies.harmonic_balance.integration import settle
from seat_gear_dynamics.studies.harmonic_balance.orbit import state_of_train
from seat_gear_dynamics.studies.harmonic_balance.tracing import Range, trace

Array = NDArray[np.float64]
MakeOscillator = Callable[[float, float, float], System]

ZETA, MEAN, ALTERNATING = 0.05, 0.1, 0.05


def ramp(mu: float) -> float:
    """Return G of the describing function of a dead zone's mean."""
    return 2 / pi * (mu * asin(mu) + sqrt(1 - mu**2)) if abs(mu) <= 1 else abs(mu)


def slope(mu: float) -> float:
    """Return H of the describing function of its alternating part."""
    return 2 / pi * (asin(mu) + mu * sqrt(1 - mu**2)) if abs(mu) <= 1 else float(np.sign(mu))


def describing(mean: float, size: float) -> tuple[float, float]:
    """Return (mean force, stiffness of the alternating part) of f(mean + size·sin θ)."""
    upper, lower = (1 - mean) / size, (-1 - mean) / size
    return mean + size / 2 * (ramp(upper) - ramp(lower)), 1 - (slope(upper) - slope(lower)) / 2


def one_term(system: System, low: float, high: float) -> Branch:
    made, conditions = pair(system.at(frequency=low))
    problem = Balance(made, conditions, Basis(1, 8192))
    arc = Arc(0.2, (high - low) / 200)
    first = start(problem, first_motion(system, problem, low), low, arc)
    return trace(problem, first, Range(low, high, arc))


@pytest.mark.parametrize("alternating", [0.05, 0.2])
def test_one_term_solution_is_the_published_closed_form(oscillator: MakeOscillator, alternating: float) -> None:
    branch = one_term(oscillator(ZETA, MEAN, alternating), 0.3, 1.6)
    assert {"no loss", "one-sided"} <= {m.contact_state for m in branch.motions}
    assert [b.kind for b in branch.bifurcations].count("fold") == 2
    for motion in branch.motions:
        size = sqrt(2) * motion.rms
        mean_force, stiffness = describing(motion.mean, size)
        w = motion.parameter
        inertia = size * sqrt((stiffness - w**2) ** 2 + (2 * ZETA * w) ** 2)
        # Sums over 8192 samples are exact to the third power of a cell times the slope, 1e-9; Newton to 1e-10.
        assert mean_force == pytest.approx(MEAN, abs=1e-8)
        assert inertia == pytest.approx(alternating * w**2, abs=1e-7)


def test_teeth_first_part_where_the_linear_response_reaches_the_mean_load(oscillator: MakeOscillator) -> None:
    def excess(w: float) -> float:
        return ALTERNATING * w**2 / sqrt((1 - w**2) ** 2 + (2 * ZETA * w) ** 2) - MEAN

    onset = brentq(excess, 0.3, 1.0)
    curve = response_curve(oscillator(ZETA, MEAN, ALTERNATING), onset - 1e-3, onset + 1e-3)
    for motion in curve.branches[0].motions:
        assert (motion.contact_state == "no loss") == (motion.parameter <= onset)


def free_frequency(size: float, mean: float) -> float:
    """Return the frequency of undamped free motion that dives `size` below rest: half a turn in contact, and a throw.

    In contact about 1 + F_m a harmonic motion of frequency 1; out of it a throw under the constant force F_m that does
    not reach the other flank.
    """
    contact = 2 * (pi - acos(mean / size))
    return 2 * pi / (contact + 2 * sqrt(size**2 - mean**2) / mean)


def test_lightly_damped_resonance_is_the_free_motion(oscillator: MakeOscillator) -> None:
    curve = response_curve(oscillator(0.005, MEAN, 0.02), 0.4, 0.95)
    largest = max(curve.branches[0].motions, key=lambda m: m.rms)
    size = float(largest.orbit.samples.max()) - 1 - MEAN
    # Damping and forcing, each of the order ζ of the force, cancel there but for their different shapes: order ζ².
    assert size > 4 * MEAN
    assert largest.parameter == pytest.approx(free_frequency(size, MEAN), rel=10 * 0.005**2)


def test_motions_are_those_of_the_oscillator_written_out(oscillator: MakeOscillator) -> None:
    curve = response_curve(oscillator(ZETA, MEAN, ALTERNATING), 0.65, 1.05, harmonics=64)

    def motion(w: float) -> Callable[[float, Array], list[float]]:
        def rates(t: float, y: Array) -> list[float]:
            force = y[0] - min(max(y[0], -1.0), 1.0)
            return [y[1], MEAN + ALTERNATING * w**2 * np.sin(w * t) - 2 * ZETA * y[1] - force]

        return rates

    for w in (0.75, 1.0):
        found = curve.motions_at(w)
        assert len(found) == (3 if w == 0.75 else 1)
        for member in found:
            period, phase = 2 * pi / w, np.linspace(0, 1, 41)
            begin = [float(member.orbit.deflection(0.0)), float(member.orbit.rate(0.0))]
            outside = solve_ivp(
                motion(w), (0, period), begin, t_eval=phase * period, rtol=1e-10, atol=1e-12, max_step=period / 500
            )
            # 64 harmonics of a motion whose harmonics fall with the fourth power; unstable ones grow it by up to 3.
            assert outside.y[0] == pytest.approx(member.orbit.deflection(phase), abs=2e-5)


def test_folds_of_the_published_parameters(oscillator: MakeOscillator) -> None:
    curve = response_curve(oscillator(ZETA, MEAN, ALTERNATING), 0.65, 0.9)
    # Golden, 32 harmonics; 64 give the same to 1e-5.
    assert [f.parameter for f in curve.folds] == pytest.approx([0.82846, 0.70803], abs=2e-5)


def test_integration_doubles_its_period_between_the_doublings(oscillator: MakeOscillator) -> None:
    system = oscillator(ZETA, MEAN, 0.2)
    curve = response_curve(system, 0.55, 0.64)
    low, high = (e.parameter for e in curve.bifurcations if e.kind == "period doubling")
    for frequency, single in ((low - 0.01, True), ((low + high) / 2, False), (high + 0.004, True)):
        at = system.at(frequency=frequency)
        # The lower branch; from rest integration may settle on the upper one, which is stable there too.
        motion = min(curve.motions_at(frequency), key=lambda m: m.rms)
        state = state_of_train(motion.orbit, at.static_state())
        state[14] += 1e-3
        recorded = settle(at, periods=4, transient=400, state=state, target_steps=272)
        # Within 400 periods a multiplier of 0.97 shrinks the disturbance, and one of -1.35 grows it to its end.
        assert (recorded.repeats(1) < 1e-4) == single
        assert recorded.repeats(2) < 1e-4
