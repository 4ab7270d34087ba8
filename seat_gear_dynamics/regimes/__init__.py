"""What kind of motion it is: section, exponents, classification, bifurcation, basins, regime map and bands."""

from seat_gear_dynamics.regimes.attractors import Attractor, attractors
from seat_gear_dynamics.regimes.basins import Basins, basins
from seat_gear_dynamics.regimes.classification import Regime, classify
from seat_gear_dynamics.regimes.exponent import Exponent, largest_exponent
from seat_gear_dynamics.regimes.regime_map import MapError, RegimeMap
from seat_gear_dynamics.regimes.section import find_period, recurrence
from seat_gear_dynamics.regimes.simulate import MeshForce, Simulation, simulate
from seat_gear_dynamics.regimes.sweep import Row, Sweep, intervals, sweep, sweep_rows
from seat_gear_dynamics.regimes.tolerance import Tolerances, with_tolerances

__all__ = [
    "Attractor",
    "Basins",
    "Exponent",
    "MapError",
    "MeshForce",
    "Regime",
    "RegimeMap",
    "Row",
    "Simulation",
    "Sweep",
    "Tolerances",
    "attractors",
    "basins",
    "classify",
    "find_period",
    "intervals",
    "largest_exponent",
    "recurrence",
    "simulate",
    "sweep",
    "sweep_rows",
    "with_tolerances",
]
