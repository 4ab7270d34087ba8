"""The monitor with a model that halts inside a band until a file is there: `python halting_monitor.py FILE ...`."""

import sys
from pathlib import Path
from time import monotonic, sleep

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.nodes.monitor import main
from seat_gear_dynamics.sensing import Reading, VirtualSensor
from seat_gear_dynamics.sensing.reading import Accepted

_INSIDE = 1700 * RPM
_PATIENCE = 60.0  # s

_advance = VirtualSensor.advance


def halt(sensor: VirtualSensor, sample: Accepted) -> Reading:
    """Wait for the file, then advance as ever."""
    begin = monotonic()
    while sample.speed > _INSIDE and not go.exists() and monotonic() - begin < _PATIENCE:
        sleep(0.01)
    return _advance(sensor, sample)


go = Path(sys.argv[1])
VirtualSensor.advance = halt  # type: ignore[method-assign, assignment]
sys.exit(main(sys.argv[2:]))
