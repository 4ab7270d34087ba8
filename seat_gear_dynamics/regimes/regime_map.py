"""The regime map: what the motion is over speed and load, and the forbidden bands that follow."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from hashlib import sha256
from typing import Any, BinaryIO
from zipfile import BadZipFile

import numpy as np
from numpy.lib.npyio import NpzFile
from numpy.typing import ArrayLike, NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.plotting import Plottable
from seat_gear_dynamics.regimes.bands import MapBand, forbidden_bands, wilson_interval
from seat_gear_dynamics.regimes.classification import Name
from seat_gear_dynamics.regimes.map_nodes import NAMES as NAMES
from seat_gear_dynamics.regimes.map_nodes import NODE, MapGrid, Nodes, map_nodes
from seat_gear_dynamics.regimes.map_nodes import chaos_weight as chaos_weight
from seat_gear_dynamics.regimes.workers import Workers

Array = NDArray[np.float64]
Codes = NDArray[np.int64]

_FORMAT = 1


class MapError(ValueError):
    """A regime map that cannot be used for what was asked; the text is one sentence."""


@dataclass(frozen=True, eq=False)
class RegimeMap(Plottable, figure="regime_map:plot_map", table="regimes:map_table"):
    """Regimes over a grid of speed and load; arrays have shape (loads, speeds).

    Every node is run from rest at static deflection, so of motions that coexist the map shows one. Speeds are positive
    and the map is asked with |speed|: whether a drive in reverse does the same is not checked here.
    """

    speeds: Array
    """rad/s of s1, increasing."""
    loads: Array
    """T4, N·m, increasing."""
    codes: Codes
    """Index into NAMES; a divergence is undecided and its forces are NaN."""
    period: Codes
    """In mesh periods; 0 where the motion is not periodic."""
    lyapunov: Array
    """Largest exponent per unit of τ; NaN where there is none."""
    contact_loss: Array
    """Share of the time that P12 is out of contact."""
    force_max: Array
    """Largest force of P12, N."""
    chaos: Array
    """Probability of chaos: see `chaos_weight` for one machine, its mean over machines where there are `samples`."""
    samples: int
    """Machines drawn within tolerances for `chaos`; 0: the nominal machine alone."""
    fingerprint: str
    """Of the train, see `fingerprint`."""
    transient: int
    """Mesh periods run in."""
    periods: int
    """Mesh periods sampled."""

    def __post_init__(self) -> None:
        shape = (len(self.loads), len(self.speeds))
        for name in ("codes", "period", "lyapunov", "contact_loss", "force_max", "chaos"):
            found = getattr(self, name).shape
            if found != shape:
                raise MapError(f"The map's {name} has shape {found}, expected {shape} (loads, speeds).")

    @classmethod
    def compute(
        cls,
        system: System,
        speeds: ArrayLike,
        loads: ArrayLike,
        progress: Callable[[int, int], None] | None = None,
        *,
        transient: int = 400,
        periods: int = 200,
        workers: Workers | int | None = None,
    ) -> "RegimeMap":
        """Return the map of `system` over `speeds` (rad/s of s1, at least two) and `loads` (T4, N·m).

        Both strictly increasing, speeds positive; the system's own operating point does not matter. `workers`: who
        computes, a number: so many threads of this machine. `progress` is told (nodes done, nodes in all). Raises
        ValueError for impossible grids.
        """
        grid = MapGrid(np.asarray(speeds), np.asarray(loads), transient, periods)
        nodes, done = np.empty(grid.nodes, dtype=NODE), 0
        for block in map_nodes(system.train, grid, workers=workers):
            for found in block:
                nodes[done] = found
                done += 1
                if progress is not None:
                    progress(done, len(nodes))
        return cls.of_nodes(system.train, grid, nodes)

    @classmethod
    def of_nodes(cls, train: GearTrain, grid: MapGrid, nodes: Nodes) -> "RegimeMap":
        """Return the map of the nodes, (grid.nodes,) of NODE, that `map_nodes` found; they are not copied.

        Raises MapError for another number of nodes.
        """
        if len(nodes) != grid.nodes:
            raise MapError(f"There are {len(nodes)} nodes, expected {grid.nodes} of {grid.shape} (loads, speeds).")
        codes, period, *measured = (nodes[name].reshape(grid.shape) for name in NODE.names or ())
        lyapunov, contact_loss, force_max, chaos = measured
        judged = (codes, period, lyapunov, contact_loss, force_max, chaos)
        return cls(grid.speeds, grid.loads, *judged, 0, fingerprint(train), grid.transient, grid.periods)

    def covers(self, speed: float, load: float) -> bool:
        """Return whether the map says anything at `speed` (rad/s of s1, either sign) and `load` (N·m)."""
        inside = self.speeds[0] <= abs(speed) <= self.speeds[-1] and self.loads[0] <= load <= self.loads[-1]
        return bool(inside)

    def regime_at(self, speed: float, load: float) -> Name:
        """Return the regime at the node nearest to `speed` (rad/s) and `load` (N·m); raises MapError outside."""
        self._inside(speed, load)
        row = np.abs(self.loads - load).argmin()
        column = np.abs(self.speeds - abs(speed)).argmin()
        return NAMES[int(self.codes[row, column])]

    def probability_at(self, speed: float, load: float) -> float:
        """Return the probability of chaos, interpolated linearly in speed and load; raises MapError outside."""
        self._inside(speed, load)
        return float(np.interp(abs(speed), self.speeds, self._along(self.chaos, load)))

    def interval_at(self, speed: float, load: float, *, confidence: float = 0.95) -> tuple[float, float]:
        """Return the Wilson interval of that probability; the probability twice where no machines were drawn."""
        self._inside(speed, load)
        bounds = (self._along(bound, load) for bound in self._bounds(confidence))
        low, high = (float(np.interp(abs(speed), self.speeds, bound)) for bound in bounds)
        return low, high

    def bands(self, load: float, threshold: float = 0.5, *, confidence: float = 0.95) -> tuple[MapBand, ...]:
        """Return the forbidden bands at `load` (N·m): where the probability of chaos is at least `threshold`.

        Edges and their errors as `forbidden_bands` has them; between two loads the probability is interpolated. Raises
        MapError for a load outside the map and a threshold not in (0, 1].
        """
        self._inside(float(self.speeds[0]), load)
        if not 0 < threshold <= 1:
            raise MapError(f"The threshold is {threshold!r}, expected more than 0 and at most 1.")
        probability, lower, upper = (self._along(each, load) for each in (self.chaos, *self._bounds(confidence)))
        return forbidden_bands(self.speeds, probability, lower, upper, threshold=threshold, load=float(load))

    def belongs_to(self, train: GearTrain) -> bool:
        """Return whether the map was computed for `train`."""
        return self.fingerprint == fingerprint(train)

    def with_chaos(self, chaos: Array, samples: int) -> "RegimeMap":
        """Return the map with the probability of chaos, (loads, speeds), that `samples` machines showed."""
        return replace(self, chaos=chaos, samples=samples)

    def save(self, file: BinaryIO) -> None:
        """Write the map to a binary file open for writing, as NumPy's compressed npz."""
        arrays = {field.name: np.asarray(getattr(self, field.name)) for field in fields(self)}
        np.savez_compressed(file, allow_pickle=False, format=np.asarray(_FORMAT), **arrays)

    @classmethod
    def load(cls, file: BinaryIO, train: GearTrain | None = None) -> "RegimeMap":
        """Read a map from a binary file open for reading.

        Raises MapError where the file holds no map, or, if `train` is given, one of another machine.
        """
        found = _parsed(_stored(file))
        if train is not None and not found.belongs_to(train):
            raise MapError(
                f"The map is of another machine: its parameters have the hash {found.fingerprint[:12]}, "
                f"those of {train.name} {fingerprint(train)[:12]}; compute the map of this machine."
            )
        return found

    def _inside(self, speed: float, load: float) -> None:
        if not self.covers(speed, load):
            raise MapError(
                f"{abs(speed):g} rad/s and {load:g} N·m are outside the map, which covers {self.speeds[0]:g} to "
                f"{self.speeds[-1]:g} rad/s and {self.loads[0]:g} to {self.loads[-1]:g} N·m; compute a wider one."
            )

    def _bounds(self, confidence: float) -> tuple[Array, Array]:
        if not self.samples:
            return self.chaos, self.chaos
        return wilson_interval(self.chaos, self.samples, confidence=confidence)

    def _along(self, values: Array, load: float) -> Array:
        """Return `values` over the speeds at `load`, interpolated between the two loads beside it."""
        above = min(int(np.searchsorted(self.loads, load)), len(self.loads) - 1)
        below = max(above - 1, 0)
        if above == below or load == self.loads[above]:
            return np.asarray(values[above])
        share = (load - self.loads[below]) / (self.loads[above] - self.loads[below])
        return np.asarray((1 - share) * values[below] + share * values[above])


def fingerprint(train: GearTrain) -> str:
    """Return a hash (SHA-256, hexadecimal) of every parameter of `train` that its motion depends on.

    Name, text, provenance, published bands and the limits on inputs do not count.
    """
    model = replace(train.model, max_speed=0.0, max_load=0.0, covered_speed=0.0)
    bare = replace(train, name="", text="", provenance={}, bands=(), model=model)
    return sha256(repr(bare).encode()).hexdigest()


def _stored(file: BinaryIO) -> dict[str, NDArray[Any]]:
    """Return the arrays of an npz file; raises MapError where it is none."""
    try:
        stored = np.load(file, allow_pickle=False)
        if isinstance(stored, NpzFile):
            return {name: stored[name] for name in stored.files}
    except (ValueError, OSError, EOFError, BadZipFile) as error:
        raise MapError(f"The file holds no regime map ({error}); give one that RegimeMap.save wrote.") from error
    raise MapError("The file holds a single array and no regime map; give one that RegimeMap.save wrote.")


def _parsed(values: dict[str, NDArray[Any]]) -> RegimeMap:
    missing = [field.name for field in fields(RegimeMap) if field.name not in values]
    if missing or int(values.get("format", np.asarray(0)).item()) != _FORMAT:
        raise MapError(
            f"The file holds no regime map of format {_FORMAT} (missing: {', '.join(missing) or 'nothing'}); "
            f"give one that RegimeMap.save of this version wrote."
        )
    kept: dict[str, Any] = {field.name: values[field.name] for field in fields(RegimeMap)}
    for name in ("samples", "fingerprint", "transient", "periods"):
        kept[name] = kept[name].item()
    return RegimeMap(**kept)
