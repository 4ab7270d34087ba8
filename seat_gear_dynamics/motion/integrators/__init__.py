"""Integrators beside the production march: fixed steps, step halving as the paper has it, and event-locating steps."""

from seat_gear_dynamics.motion.integrators.event_locating import EventLocating
from seat_gear_dynamics.motion.integrators.field import right_hand_side
from seat_gear_dynamics.motion.integrators.fixed_step import FixedStep
from seat_gear_dynamics.motion.integrators.integrate import METHODS, Method, integrate_time
from seat_gear_dynamics.motion.integrators.landing import contact_jump
from seat_gear_dynamics.motion.integrators.propagate import Growth, Propagation, growths, propagators
from seat_gear_dynamics.motion.integrators.step_halving import StepHalving
from seat_gear_dynamics.motion.integrators.trajectory import ContactChanges, Counts, StepRefusedError, Trajectory

__all__ = [
    "METHODS",
    "ContactChanges",
    "Counts",
    "EventLocating",
    "FixedStep",
    "Growth",
    "Method",
    "Propagation",
    "StepHalving",
    "StepRefusedError",
    "Trajectory",
    "contact_jump",
    "growths",
    "integrate_time",
    "propagators",
    "right_hand_side",
]
