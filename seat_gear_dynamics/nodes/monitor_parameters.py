"""The monitor's parameters, and the alarm's settings from them."""

from collections.abc import Mapping
from typing import Any

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.nodes.parameters import Parameter
from seat_gear_dynamics.sensing import AlarmSettings

PARAMETERS = (
    Parameter("autostart", True, "configure and activate by itself at start; false: wait to be told"),
    Parameter("system", "", "system description (YAML file); empty: the packaged height adjuster", change="setup"),
    Parameter(
        "map",
        "",
        "regime map (file of seat-gear map) whose bands follow the load; packaged: the packaged machine's; "
        "empty: the published bands, at every load",
        change="setup",
    ),
    Parameter(
        "input",
        "topics",
        "where speed and load come from",
        choices=("topics", "joint_states"),
        change="setup",
    ),
    Parameter(
        "joint", "seat_height", "joint whose velocity and effort are speed and load, with joint_states", change="setup"
    ),
    Parameter(
        "input_deadline",
        0.0,
        "deadline asked of the inputs' publishers, s; 0: none; one that offers no such deadline is not heard",
        0.0,
        60.0,
        change="setup",
    ),
    Parameter("section_points", 256, "section points kept and published", 1, 10000, change="setup"),
    Parameter("publish_rate", 50.0, "mesh state and force, Hz", 1.0, 1000.0, change="run"),
    Parameter(
        "warning_rate", 10.0, "warning, trip signal and section when nothing changes, Hz", 1.0, 100.0, change="run"
    ),
    Parameter(
        "input_timeout",
        0.5,
        "time without a usable speed after which the warning is STALE and the model restarts, s",
        0.05,
        60.0,
        change="run",
    ),
    Parameter(
        "load_timeout",
        2.0,
        "time without a usable load after which the warning is STALE, s",
        0.05,
        600.0,
        change="run",
    ),
    Parameter("margin_rpm", 40.0, "WARN when closer to a forbidden band than this, r/min", 0.0, 1000.0, change="run"),
    Parameter("horizon", 1.0, "WARN when the acceleration reaches a band within this, s", 0.0, 60.0, change="run"),
    Parameter("hysteresis_rpm", 4.0, "a band is left only when this far outside, r/min", 0.0, 100.0, change="run"),
    Parameter("debounce", 0.03, "time a worse level has to last, s", 0.0, 10.0, change="run"),
    Parameter("hold", 0.3, "time a better level has to last, s", 0.0, 60.0, change="run"),
    Parameter("state_period", 1.0, "time between two messages of the model's state, s", 0.1, 600.0, change="run"),
)


def alarm_settings(values: Mapping[str, Any]) -> AlarmSettings:
    """Return what the alarm takes of the monitor's parameters, in SI units."""
    return AlarmSettings(
        margin=values["margin_rpm"] * RPM,
        horizon=values["horizon"],
        hysteresis=values["hysteresis_rpm"] * RPM,
        debounce=values["debounce"],
        hold=values["hold"],
    )
