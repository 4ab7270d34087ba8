"""The analysis of a log: one pass over its messages, then the model beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.logs.analysis.bands import BandStay, BandStays
from seat_gear_dynamics.logs.analysis.batches import FORCE_NAMES, Array, Batch
from seat_gear_dynamics.logs.analysis.detection import DangerSpans, Detection, LevelSpans, detect
from seat_gear_dynamics.logs.analysis.dwells import Dwell, Dwells
from seat_gear_dynamics.logs.analysis.histories import Binned
from seat_gear_dynamics.logs.analysis.model import DwellMotion, ModelSettings, dwell_motion, model_map, model_sweep
from seat_gear_dynamics.logs.analysis.occupancy import Occupancy
from seat_gear_dynamics.logs.analysis.section_cloud import SectionCloud
from seat_gear_dynamics.logs.analysis.side_by_side import Stretches
from seat_gear_dynamics.logs.analysis.sources import Source
from seat_gear_dynamics.logs.analysis.stream import Stream
from seat_gear_dynamics.logs.analysis.zones import zones
from seat_gear_dynamics.logs.flows import Flow
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.regimes import RegimeMap, Sweep
from seat_gear_dynamics.sensing import BandSource, MapBands, PublishedBands

BINS = 1500
"""Most bins of a time history."""
_BLOCK = 1 << 20  # bytes hashed at a time
Tell = Callable[[str, int, int], None]
"""Is told (stage, done, in all)."""


@dataclass(frozen=True)
class Provenance:
    """What was analysed, and with what."""

    log: Path
    files: tuple[tuple[str, int, str], ...]
    """(name, bytes, sha256) of each file of the log"""
    log_version: str | None
    """Version of the software that recorded it; None for another program's log."""
    log_system_hash: str | None
    """sha256 of the description that the log keeps."""
    system_text: str
    """The description used here."""
    drive_topics: tuple[str, ...]
    estimated: bool
    """Forces, section and warnings were computed here: the log has none."""
    closed: bool = True
    """Whether the log was ended; not so where its recorder was killed or still writes."""
    notes: tuple[tuple[str, str], ...] = ()
    """What else the recorder says of the log, (what, value), but for its counts of messages."""

    @property
    def system_hash(self) -> str:
        """sha256 of the description used here."""
        return sha256(self.system_text.encode()).hexdigest()


@dataclass(frozen=True, eq=False)
class Analysis:
    """Everything that a report shows of a log; its size does not grow with the log's length."""

    provenance: Provenance
    train: GearTrain
    duration: float
    """s"""
    damage: str | None
    flows: list[Flow]
    drive: Binned
    """|speed| and speed (rad/s) and load (N·m) over time."""
    force: Binned
    """FORCE_NAMES, N, over time."""
    occupancy: Occupancy
    bands: tuple[BandStay, ...]
    levels: LevelSpans
    judged_by: BandSource
    """The bands that stays and warnings are held against; by them warnings were judged that were computed here."""
    stated_bands: tuple[str, ...]
    """Labels of the bands that the logged warnings name, in the order in which they came; the first few."""
    detection: Detection
    """Against the forbidden bands of `judged_by`."""
    map_detection: Detection | None
    """Against what the map itself says at its nearest node, where the bands are a map's; else None."""
    dwells: Dwells
    cloud: SectionCloud
    restarts: tuple[tuple[float, str], ...]
    """Where the model was restarted, (s, why); only where outputs are estimated here."""
    stretches: Stretches | None
    """How the estimate was cut and joined; None where outputs were logged."""
    motions: tuple[DwellMotion, ...]
    """The model's, of the longest dwells, in order of time."""
    sweep: Sweep | None
    map: RegimeMap | None

    @property
    def warned(self) -> bool:
        """Whether there is any warning, logged or computed here, to hold against stays."""
        return bool(self.levels.spans)

    @property
    def drawn(self) -> list[Dwell]:
        """The dwells that are drawn, in order of time: those the model ran, else the longest."""
        chosen = [motion.dwell for motion in self.motions]
        return chosen or self.dwells.longest(ModelSettings().dwells)

    def dimensionless(self, state: Array) -> Array:
        """Return (δ in m, its rate in m/s), (n, 2), in units of b_c and of b_c per τ."""
        scale = self.train.model.displacement_scale
        return np.asarray(state / np.array([scale, scale * self.train.model.time_scale]))

    @property
    def load(self) -> float:
        """The load at which the drive spent most time, N·m; NaN without a drive."""
        return typical_load(self.occupancy)


def analyse(
    path: Path | str,
    train: GearTrain,
    *,
    source: Source | None = None,
    model: ModelSettings | None = None,
    bands: BandSource | None = None,
    processes: int = 1,
    tell: Tell | None = None,
) -> Analysis:
    """Analyse the log at `path` with the parameters of `train`, by `bands` (None: its published ones).

    `source` says where speed and load stand; `model` what is computed beside the log (None: nothing). Where the bands
    are a map's, the map is drawn behind the trajectory too, and is a second truth for warnings. Memory is bounded but
    for the reader's own index of chunks. Raises LogError for what is no log or holds no speed or load.
    """
    report = tell or (lambda stage, done, total: None)
    bag, judged_by = Bag(path), bands or PublishedBands.of(train)
    regime_map = judged_by.map if isinstance(judged_by, MapBands) else None
    stream = Stream(bag, train, source, bands=judged_by, workers=processes)
    stage = "messages, through the model" if stream.estimated else "messages"
    one = _Reductions(bag, judged_by, regime_map)
    for batch in stream.batches(lambda done, total: report(stage, done, total)):
        one.add(batch)
    one.dwells.finish()
    speeds, loads = speed_range(one.occupancy), one.occupancy.load_range()
    motions, found, chart = _model(train, one, speeds, loads, model, regime_map, report)
    metadata = bag.metadata or {}
    provenance = Provenance(
        bag.path,
        tuple(_hashed(bag.files)),
        metadata.get("software_version"),
        metadata.get("system_hash"),
        train.text,
        stream.drive_topics,
        stream.estimated,
        bag.closed,
        tuple((key, value) for key, value in bag.custom_data.items() if not key.startswith("messages of ")),
    )
    return Analysis(
        provenance=provenance,
        train=train,
        duration=(bag.end_ns - bag.start_ns) * 1e-9,
        damage=bag.damage,
        flows=stream.flows.found(),
        drive=one.drive,
        force=one.force,
        occupancy=one.occupancy,
        bands=one.bands.found(),
        levels=one.levels,
        judged_by=judged_by,
        stated_bands=stream.stated_bands,
        detection=detect(one.in_band, one.levels),
        map_detection=detect(one.in_map, one.levels) if one.in_map else None,
        dwells=one.dwells,
        cloud=one.cloud,
        restarts=tuple(one.restarts),
        stretches=stream.stretches,
        motions=motions,
        sweep=found,
        map=chart,
    )


def speed_range(occupancy: Occupancy) -> tuple[float, float]:
    """Return the lowest and highest |speed| visited, rad/s; NaN without any."""
    cells = occupancy.cells()
    return (float(cells[:, 0].min()), float(cells[:, 0].max())) if len(cells) else (np.nan, np.nan)


def typical_load(occupancy: Occupancy) -> float:
    """Return the median load over time, N·m; NaN without a drive."""
    return occupancy.load_range(0.5)[0]


class _Reductions:
    """Everything that follows the batches."""

    def __init__(self, bag: Bag, judged_by: BandSource, regime_map: RegimeMap | None) -> None:
        end = (bag.end_ns - bag.start_ns) * 1e-9
        bins = int(np.clip(end * 10, 1, BINS))
        self.drive = Binned(("magnitude", "speed", "load"), 0.0, end, bins=bins)
        self.force = Binned(FORCE_NAMES, 0.0, end, bins=bins)
        self.occupancy = Occupancy()
        cut = zones(judged_by)
        self.bands = BandStays(cut)
        self.levels = LevelSpans()
        self.in_band = DangerSpans(lambda drive: cut.forbidden(drive[:, 1], drive[:, 2]))
        self.in_map = DangerSpans(lambda drive: _chaotic(drive, regime_map)) if regime_map else None
        self.dwells = Dwells()
        self.cloud = SectionCloud()
        self.restarts: list[tuple[float, str]] = []

    def add(self, batch: Batch) -> None:
        drive = batch.drive
        self.drive.add(drive[:, 0], np.column_stack([np.abs(drive[:, 1]), drive[:, 1:3]]))
        self.force.add(batch.force[:, 0], batch.force[:, 1:9])
        self.occupancy.add(drive)
        self.bands.add(drive, batch.force)
        self.levels.add(batch.warnings)
        self.in_band.add(drive)
        if self.in_map is not None:
            self.in_map.add(drive)
        self.dwells.add(batch)
        self.cloud.add(batch.section)
        self.restarts += batch.restarts[: max(1000 - len(self.restarts), 0)]


def _chaotic(drive: Array, regime_map: RegimeMap) -> NDArray[np.bool_]:
    """Return where the map, its nearest node, says chaos is more likely than not; outside the map nothing is said."""
    speeds, loads = regime_map.speeds, regime_map.loads
    magnitude, load = np.abs(drive[:, 1]), drive[:, 2]
    covered = (magnitude >= speeds[0]) & (magnitude <= speeds[-1]) & (load >= loads[0]) & (load <= loads[-1])
    column = np.abs(magnitude[:, None] - speeds).argmin(axis=1)
    row = np.abs(load[:, None] - loads).argmin(axis=1)
    return np.asarray(covered & (regime_map.chaos[row, column] >= 0.5))


def _model(
    train: GearTrain,
    one: _Reductions,
    speeds: tuple[float, float],
    loads: tuple[float, float],
    settings: ModelSettings | None,
    regime_map: RegimeMap | None,
    report: Tell,
) -> tuple[tuple[DwellMotion, ...], Sweep | None, RegimeMap | None]:
    if settings is None or not np.isfinite(loads).all():
        return (), None, regime_map
    motions = tuple(_motions(train, one.dwells.longest(settings.dwells), report))
    load = typical_load(one.occupancy)
    found = model_sweep(train, speeds, load, settings, lambda done, total: report("bifurcation", done, total))
    if regime_map is None:
        regime_map = model_map(train, speeds, loads, settings, lambda done, total: report("regime map", done, total))
    return motions, found, regime_map


def _motions(train: GearTrain, dwells: list[Dwell], report: Tell) -> Iterator[DwellMotion]:
    for done, dwell in enumerate(dwells, start=1):
        motion = dwell_motion(train, dwell)
        report("dwells", done, len(dwells))
        if motion is not None:
            yield motion


def _hashed(files: tuple[Path, ...]) -> Iterator[tuple[str, int, str]]:
    for path in files:
        digest = sha256()
        with path.open("rb") as file:
            while block := file.read(_BLOCK):
                digest.update(block)
        yield path.name, path.stat().st_size, digest.hexdigest()
