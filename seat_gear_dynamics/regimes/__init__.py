"""What kind of motion it is: section, exponents, classification, bifurcation, basins, regime map and bands."""

from seat_gear_dynamics.regimes.attractors import Attractor, attractors
from seat_gear_dynamics.regimes.basins import Basins, basins
from seat_gear_dynamics.regimes.classification import Regime, classify, warm_up
from seat_gear_dynamics.regimes.exponent import Exponent, largest_exponent
from seat_gear_dynamics.regimes.regime_map import MapError, RegimeMap
from seat_gear_dynamics.regimes.section import find_period, recurrence
from seat_gear_dynamics.regimes.simulate import MeshForce, Simulation, simulate
from seat_gear_dynamics.regimes.spectrum import CrossingError, Spectrum, saltation, spectrum
from seat_gear_dynamics.regimes.sweep import Row, Sweep, intervals, sweep, sweep_rows
from seat_gear_dynamics.regimes.tolerance import Tolerances, with_tolerances
from seat_gear_dynamics.regimes.winding import winding_number
from seat_gear_dynamics.regimes.zero_one import ZeroOne, zero_one

__all__ = [
    "Attractor",
    "Basins",
    "CrossingError",
    "Exponent",
    "MapError",
    "MeshForce",
    "Regime",
    "RegimeMap",
    "Row",
    "Simulation",
    "Spectrum",
    "Sweep",
    "Tolerances",
    "ZeroOne",
    "attractors",
    "basins",
    "classify",
    "find_period",
    "intervals",
    "largest_exponent",
    "recurrence",
    "saltation",
    "simulate",
    "spectrum",
    "sweep",
    "sweep_rows",
    "warm_up",
    "winding_number",
    "with_tolerances",
    "zero_one",
]
