"""What was so: danger of place and of motion, from the noiseless trajectory and long noiseless runs of the model."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes.points import Diverged, Point, regime_of, respond
from seat_gear_dynamics.regimes.regime_map import NAMES, RegimeMap
from seat_gear_dynamics.sensing import BandSource
from seat_gear_dynamics.studies.warning_quality.run import Record
from seat_gear_dynamics.studies.warning_quality.scenarios import Scenario

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Answer = Literal["chaotic", "calm", "either"]
Drive = tuple[float, float]

SPEED_DOUBT = 5 * RPM
"""rad/s by which a steady point is moved either way to see whether its motion is firm."""
LOAD_DOUBT = 10.0
"""N·m, likewise: noise of the load moves the drive by so much."""
_DEVIATIONS = 2.0  # of the noise within which place is on the edge, and neither answer is wrong
_STEADY_SPEED = 2 * RPM  # rad/s by which a steady drive differs from where it was half a second ago
_STEADY_LOAD = 1.0  # N·m, likewise
_STEADY_TIME = 0.5  # s
_ROUND_SPEED = 2 * RPM  # steady points nearer than this are one
_ROUND_LOAD = 2.0
_NO_BAND = 1e9  # rad/s, distance where there is no band


@dataclass(frozen=True, eq=False)
class Truth:
    """What was so at each of n samples; neither `inside` nor `outside` means on an edge."""

    distance: Array
    """From the true speed to the nearest band at the true load, rad/s, negative inside, (n,)."""
    inside: Flags
    """Inside a band by more than the measurement can tell."""
    outside: Flags
    """Outside of all, likewise."""
    steady: Flags
    """Speed and load have stood still for half a second."""
    chaotic: Flags
    """Where the model is surely chaotic: steady, run long and without noise, at this point and at all around it;
    moving, at all nodes of the nominal map around."""
    calm: Flags
    """Where it is so at none of them, or standing. What is neither may be either."""
    ahead: Array
    """s until a band is reached, as it came about; infinity where none was."""


def steady_points(scenario: Scenario) -> list[Drive]:
    """Return the points (rad/s, N·m), rounded, at which a run dwells."""
    bench = scenario.bench()
    samples = [bench.step() for _ in range(round(scenario.profile.duration / scenario.sample_time))]
    speed, load = (np.array([sample[k] for sample in samples]) for k in (3, 4))
    still = is_steady(speed, load, scenario.sample_time)
    return sorted({rounded(v, w) for v, w in zip(speed[still].tolist(), load[still].tolist(), strict=True)})


def motions(
    train: GearTrain,
    points: Iterable[Drive],
    *,
    transient: int = 1500,
    periods: int = 600,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[Drive, Answer]:
    """Return what the motion is at each steady point (rad/s of s1, N·m), by the point and eight points around it.

    `chaotic` or `calm` where all nine agree, SPEED_DOUBT and LOAD_DOUBT apart; `either` where they do not, or one of
    them leans to chaos without being sure. Each is run from rest for `transient` mesh periods and judged on `periods`.
    A standing drive is calm. `progress` is told (runs done, in all). Limit: motions that coexist with the one from
    rest are not looked for.
    """
    asked = sorted(set(points))
    moving = [(v, w) for v, w in asked if abs(v) > 2 * SPEED_DOUBT]
    steps = list(product((-1, 0, 1), repeat=2))
    around = (
        Point(train.frequency(v + a * SPEED_DOUBT), w + b * LOAD_DOUBT, transient=transient, periods=periods)
        for v, w in moving
        for a, b in steps
    )
    found: dict[Drive, Answer] = dict.fromkeys(asked, "calm")
    chaos: list[float] = []
    for answer in respond(train, around, workers=workers):
        regime = regime_of(answer)
        sure = isinstance(answer, Diverged) or regime.name == "chaotic"
        chaos.append(1.0 if sure else 0.5 if regime.leans_chaotic else 0.0)
        if progress is not None:
            progress(len(chaos), len(moving) * len(steps))
    for k, point in enumerate(moving):
        found[point] = _agreed(chaos[k * len(steps) : (k + 1) * len(steps)])
    return found


def truth(record: Record, source: BandSource, known: dict[Drive, Answer], nominal: RegimeMap) -> Truth:
    """Return what was so in a run, held against `source`.

    `known` holds the motion at its steady points, `nominal` is asked where the drive moves. Limit: a moving drive is
    held against motions of steady ones.
    """
    scenario = record.scenario
    magnitude = np.abs(record.speed)
    spread = _DEVIATIONS * scenario.load_noise if source.follows_load else 0.0
    off = (-spread, 0.0, spread) if spread else (0.0,)
    away = np.array([_distances(source, magnitude, record.load + each) for each in off])
    doubt = _DEVIATIONS * scenario.speed_noise + scenario.speed_step / 2
    distance = away[len(off) // 2]
    still = is_steady(record.speed, record.load, scenario.sample_time)
    drives = zip(record.speed.tolist(), record.load.tolist(), still.tolist(), strict=True)
    answers = [known.get(rounded(v, w), "either") if at else around(nominal, v, w) for v, w, at in drives]
    chaotic, calm = (np.array([each == name for each in answers]) for name in ("chaotic", "calm"))
    return Truth(
        distance,
        np.asarray((away < -doubt).all(axis=0)),
        np.asarray((away > doubt).all(axis=0)),
        still,
        chaotic,
        calm,
        _ahead(record.time, distance <= 0),
    )


def around(nominal: RegimeMap, speed: float, load: float) -> Answer:
    """Return what the nominal machine does at the map's nodes next to `speed` (rad/s) and `load` (N·m), either side.

    Below the map's first speed it is that of standstill and of this node, beyond its ends `either`.
    """
    magnitude = abs(speed)
    if not (magnitude <= nominal.speeds[-1] and nominal.loads[0] <= load <= nominal.loads[-1]):
        return "either"
    column, row = int(np.searchsorted(nominal.speeds, magnitude)), int(np.searchsorted(nominal.loads, load))
    codes = nominal.codes[max(row - 1, 0) : row + 1, max(column - 1, 0) : column + 1]
    return _agreed((codes == NAMES.index("chaotic")).astype(float).ravel().tolist() + [0.0] * (column == 0))


def _agreed(chaos: Sequence[float]) -> Answer:
    if min(chaos) == 1.0:
        return "chaotic"
    return "calm" if max(chaos) == 0.0 else "either"


def rounded(speed: float, load: float) -> Drive:
    """Return the steady point, rad/s and N·m, that stands for all drives near it."""
    return round(speed / _ROUND_SPEED) * _ROUND_SPEED, round(load / _ROUND_LOAD) * _ROUND_LOAD


def is_steady(speed: Array, load: Array, sample_time: float) -> Flags:
    """Return where speed and load are what they were all through the last half second."""
    back = max(round(_STEADY_TIME / sample_time), 1)
    still = np.zeros(len(speed), dtype=bool)
    for k in range(back, len(speed)):
        window = slice(k - back, k + 1)
        still[k] = np.ptp(speed[window]) <= _STEADY_SPEED and np.ptp(load[window]) <= _STEADY_LOAD
    return still


def _distances(source: BandSource, magnitude: Array, load: Array) -> Array:
    """Return the distance to the nearest band at each sample's own load."""
    kept: dict[float, Array] = {}
    found = np.full(len(magnitude), _NO_BAND)
    for k, (speed, torque) in enumerate(zip(magnitude.tolist(), load.tolist(), strict=True)):
        if torque not in kept:
            kept[torque] = np.array([(band.low, band.high) for band in source.at(torque)]).reshape(-1, 2)
        edges = kept[torque]
        if len(edges):
            found[k] = np.maximum(edges[:, 0] - speed, speed - edges[:, 1]).min()
    return found


def _ahead(time: Array, within: Flags) -> Array:
    """Return the time from each sample to the next one inside a band, s; 0 inside."""
    ahead = np.full(len(time), np.inf)
    entry = np.inf
    for k in range(len(time) - 1, -1, -1):
        entry = time[k] if within[k] else entry
        ahead[k] = entry - time[k]
    return ahead
