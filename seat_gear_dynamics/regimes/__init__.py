"""What kind of motion it is: Poincaré section, largest Lyapunov exponent, classification of an operating point."""

from seat_gear_dynamics.regimes.classification import Regime, classify
from seat_gear_dynamics.regimes.exponent import Exponent, largest_exponent
from seat_gear_dynamics.regimes.section import find_period, recurrence
from seat_gear_dynamics.regimes.simulate import MeshForce, Simulation, simulate

__all__ = [
    "Exponent",
    "MeshForce",
    "Regime",
    "Simulation",
    "classify",
    "find_period",
    "largest_exponent",
    "recurrence",
    "simulate",
]
