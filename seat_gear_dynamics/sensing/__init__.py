"""The same model beside a running bench: virtual sensor and alarm, with time and data as arguments."""

from seat_gear_dynamics.sensing.alarm import Alarm, AlarmSettings, Verdict
from seat_gear_dynamics.sensing.bands import BandSource, MapBands, PublishedBands, map_path, packaged_map
from seat_gear_dynamics.sensing.evidence import Evidence, Level
from seat_gear_dynamics.sensing.reading import Accepted, Contact, ForceWindow, Reading
from seat_gear_dynamics.sensing.regime_watch import RegimeWatch
from seat_gear_dynamics.sensing.session import Change, Judgement, Session, warm_up
from seat_gear_dynamics.sensing.virtual_sensor import RejectedSampleError, VirtualSensor

__all__ = [
    "Accepted",
    "Alarm",
    "AlarmSettings",
    "BandSource",
    "Change",
    "Contact",
    "Evidence",
    "ForceWindow",
    "Judgement",
    "Level",
    "MapBands",
    "PublishedBands",
    "Reading",
    "RegimeWatch",
    "RejectedSampleError",
    "Session",
    "Verdict",
    "VirtualSensor",
    "map_path",
    "packaged_map",
    "warm_up",
]
