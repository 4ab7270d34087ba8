"""Virtual sensor and rattle warning for car-seat height adjusters: real-time gear dynamics beside a test bench.

The names below are loaded when first used, so that `import seat_gear_dynamics` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seat_gear_dynamics.motion import System as System
    from seat_gear_dynamics.motion import load_system as load_system
    from seat_gear_dynamics.regimes import RegimeMap as RegimeMap
    from seat_gear_dynamics.regimes import simulate as simulate
    from seat_gear_dynamics.regimes import sweep as sweep
    from seat_gear_dynamics.sensing import Alarm as Alarm
    from seat_gear_dynamics.sensing import VirtualSensor as VirtualSensor

__version__ = "0.1.0"

_ROOMS = {
    "System": "motion",
    "load_system": "motion",
    "RegimeMap": "regimes",
    "simulate": "regimes",
    "sweep": "regimes",
    "Alarm": "sensing",
    "VirtualSensor": "sensing",
}
__all__ = ["Alarm", "RegimeMap", "System", "VirtualSensor", "__version__", "load_system", "simulate", "sweep"]


def __getattr__(name: str) -> Any:
    if name in _ROOMS:
        return getattr(import_module(f"{__name__}.{_ROOMS[name]}"), name)
    raise AttributeError(f"seat_gear_dynamics has no {name!r}; it offers {', '.join(__all__)}.")
