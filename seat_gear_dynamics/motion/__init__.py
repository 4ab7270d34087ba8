"""How the machine moves: the equations of motion, the compiled Runge-Kutta march and the response it gives."""

from seat_gear_dynamics.motion.coefficients import Coefficients, coefficients
from seat_gear_dynamics.motion.history import History, history
from seat_gear_dynamics.motion.march import Inputs, March, Window
from seat_gear_dynamics.motion.response import Response, integrate
from seat_gear_dynamics.motion.system import STATE_NAMES, OperatingPoint, System, load_system

__all__ = [
    "STATE_NAMES",
    "Coefficients",
    "History",
    "Inputs",
    "March",
    "OperatingPoint",
    "Response",
    "System",
    "Window",
    "coefficients",
    "history",
    "integrate",
    "load_system",
]
