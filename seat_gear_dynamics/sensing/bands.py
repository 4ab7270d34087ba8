"""Where the forbidden bands come from: the published ones at every load, or a regime map's at the load at hand."""

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from hashlib import sha256
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from seat_gear_dynamics.gears import ForbiddenBand, GearTrain, packaged_description
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes.regime_map import MapError, RegimeMap, fingerprint

_SAME = 1e-9  # relative; a first speed of one grid step is 0 plus a step but for rounding

Bands = tuple[ForbiddenBand, ...]


def packaged_map() -> Path:
    """Return the path of the packaged height adjuster's regime map, which stands beside its description."""
    return packaged_description().with_name("height_adjuster_map.npz")


def map_path(given: str | Path) -> Path:
    """Return the path of a regime map that a person names: `packaged`, or a file."""
    return packaged_map() if str(given) == "packaged" else Path(given)


class BandSource(Protocol):
    """What an alarm asks of a source of bands; speeds are |speed| of s1 in rad/s, loads T4 in N·m."""

    name: str
    """`published` or `map`."""
    label: str
    """For messages and logs: which bands these are, as `published` or `map 0123456789ab`."""
    covered_speed: float
    """The highest speed of which something is known, rad/s."""
    follows_load: bool
    """Whether the bands depend on the load."""

    def at(self, load: float) -> Bands:
        """Return the bands at `load`, by rising speed and apart from each other; none outside the source."""
        ...

    def forbids(self, speed: float, load: float) -> bool:
        """Return whether `speed` is in one of the bands at `load`: as `at` says it, without making the bands."""
        ...

    def beyond(self, speed: float, load: float) -> str | None:
        """Return a sentence where nothing is known of `speed` and `load`, else None."""
        ...

    def probability(self, speed: float, load: float) -> float | None:
        """Return the probability of chaos; None where the source has none."""
        ...


class PublishedBands:
    """The bands that a description names, held at every load: what is used until a map is loaded.

    Limit: they were published at one load (600 N·m for the packaged train); at another one the chaotic speeds lie
    elsewhere, and only the running model sees it.
    """

    name = label = "published"
    follows_load = False

    def __init__(self, bands: Sequence[ForbiddenBand], covered_speed: float) -> None:
        self._bands = tuple(sorted(bands, key=lambda band: band.low))
        self.covered_speed = covered_speed

    @classmethod
    def of(cls, train: GearTrain) -> "PublishedBands":
        """Return the published bands of `train`."""
        return cls(train.bands, train.model.covered_speed)

    def at(self, load: float) -> Bands:
        """Return the published bands, whatever the load."""
        return self._bands

    def forbids(self, speed: float, load: float) -> bool:
        """Return whether `speed` is in one of them."""
        return any(band.low <= speed <= band.high for band in self._bands)

    def beyond(self, speed: float, load: float) -> str | None:
        """Return a sentence for a speed beyond the studied range; loads are not looked at."""
        if speed <= self.covered_speed:
            return None
        return (
            f"{speed / RPM:.0f} r/min is beyond the studied range, which ends at {self.covered_speed / RPM:.0f} r/min"
        )

    def probability(self, speed: float, load: float) -> float | None:
        """Return None: a published band has no probability."""
        return None


class _Piece(NamedTuple):
    """Speeds, rad/s, that are forbidden between two loads of the map; edges are linear from one load to the other."""

    low: float
    high: float
    next_low: float
    next_high: float


class MapBands:
    """The bands of a regime map, which follow the load.

    At a load of the map a band reaches half a grid step beyond where the probability of chaos crosses `threshold`: the
    edge may be anywhere between a calm and a chaotic speed of the grid, and the farther one is taken.

    Between two loads of the map: bands that overlap are one band whose edges move linearly; a gap that only one of the
    loads has is closed; a band that meets none of the other load reaches up to that load unchanged. At a load of the
    map what holds on either side of it holds. So a forbidden region never ends before the next load that is free of
    it, and an error of the load, however small, opens nothing.

    The map is entered from standstill on where its first speed is one grid step or less: nothing excites a standing
    drive. Outside the map nothing is known.

    Limits: what is finer than the grid is not seen. A band that is narrower than it moves from one load to the next is
    taken for two, each held up to the other's load, and the way between them is free: use a close grid of loads. The
    map shows motions from rest; where motions coexist the drive may be on another one.
    """

    name = "map"
    follows_load = True

    def __init__(self, found: RegimeMap, train: GearTrain, *, threshold: float = 0.5) -> None:
        """Take a map of `train`; raises MapError for another machine's, for a single load and for a bad threshold."""
        if not found.belongs_to(train):
            raise MapError(
                f"The map is of another machine: its parameters have the hash {found.fingerprint[:12]}, "
                f"those of {train.name} {fingerprint(train)[:12]}; compute the map of this machine."
            )
        if len(found.loads) < 2:
            raise MapError(
                f"The map has one load, {float(found.loads[0]):g} N·m, and a measured load is never just that one; "
                f"compute a map over two loads at least."
            )
        self.map = found
        self.label = f"map {_digest(found, threshold)}"
        self.covered_speed = float(found.speeds[-1])
        self._speeds: list[float] = found.speeds.tolist()
        self._loads: list[float] = found.loads.tolist()
        self._chaos: list[list[float]] = found.chaos.tolist()
        steps = np.diff(found.speeds)
        self._first = 0.0 if found.speeds[0] <= steps[0] * (1 + _SAME) else float(found.speeds[0])
        reach = float(steps.max()) / 2
        rows = [self._row(found, load, threshold, reach) for load in self._loads]
        self._cells = [_pieces(here, there) for here, there in pairwise(rows)]
        self._latest: tuple[float, Bands] = (np.nan, ())

    def at(self, load: float) -> Bands:
        """Return the bands at `load`."""
        at, bands = self._latest  # one sample asks several times
        if at != load:
            bands = self._joined(self._spans(load), load)
            self._latest = (load, bands)
        return bands

    def forbids(self, speed: float, load: float) -> bool:
        """Return whether `speed` is in a band at `load`."""
        return any(low <= speed <= high for low, high in self._spans(load))

    def beyond(self, speed: float, load: float) -> str | None:
        """Return a sentence outside the map."""
        if self._first <= speed <= self.covered_speed and self._loads[0] <= load <= self._loads[-1]:
            return None
        return (
            f"{speed / RPM:.0f} r/min and {load:.0f} N·m are outside the map, which covers {self._first / RPM:.0f} to "
            f"{self.covered_speed / RPM:.0f} r/min and {self._loads[0]:g} to {self._loads[-1]:g} N·m"
        )

    def probability(self, speed: float, load: float) -> float | None:
        """Return the map's probability of chaos, linear between its nodes and 0 at standstill; None outside.

        By Jeffreys' prior (n p + 1/2)/(n + 1), with n the machines drawn, or 1 for a nominal map: no count of machines
        makes sure.
        """
        if self.beyond(speed, load) is not None:
            return None
        lowest = self._speeds[0]
        share = self._chaos_at(max(speed, lowest), load) * min(1.0, speed / lowest)
        machines = max(self.map.samples, 1)
        return (machines * share + 0.5) / (machines + 1)

    def _chaos_at(self, speed: float, load: float) -> float:
        """Return what `RegimeMap.probability_at` does, to the bit, from two rows' neighbours alone."""
        column, row = bisect_right(self._speeds, speed) - 1, bisect_right(self._loads, load) - 1
        if self._loads[row] == load:
            here, there, share = self._chaos[row], self._chaos[row], 0.0
        else:
            here, there = self._chaos[row], self._chaos[row + 1]
            share = (load - self._loads[row]) / (self._loads[row + 1] - self._loads[row])
        left = (1 - share) * here[column] + share * there[column]
        if self._speeds[column] == speed:
            return left
        right = (1 - share) * here[column + 1] + share * there[column + 1]
        slope = (right - left) / (self._speeds[column + 1] - self._speeds[column])
        return slope * (speed - self._speeds[column]) + left

    def _spans(self, load: float) -> Iterator[tuple[float, float]]:
        """Yield what is forbidden at `load`, which may overlap: at a load of the map, what holds on either side."""
        upper = bisect_right(self._loads, load) - 1  # the cell from this load of the map on
        cells = (upper - 1, upper) if upper >= 0 and self._loads[upper] == load else (upper,)
        for k in cells:
            if 0 <= k < len(self._cells):
                low, high = self._loads[k], self._loads[k + 1]
                share = (load - low) / (high - low)
                yield from (_moved(piece, share) for piece in self._cells[k])

    def _row(self, found: RegimeMap, load: float, threshold: float, reach: float) -> list[tuple[float, float]]:
        """Return the bands at a load of the map, widened by `reach`, those that then touch joined."""
        wide = ((max(b.low - reach, self._first), b.high + reach) for b in found.bands(load, threshold))
        top = self.covered_speed
        return [(band.low, band.high) for band in self._joined(((low, min(high, top)) for low, high in wide), load)]

    def _joined(self, spans: Iterable[tuple[float, float]], load: float) -> Bands:
        joined: list[tuple[float, float]] = []
        for low, high in sorted(spans):
            if joined and low <= joined[-1][1]:
                joined[-1] = (joined[-1][0], max(joined[-1][1], high))
            else:
                joined.append((low, high))
        return tuple(ForbiddenBand(low, high, load) for low, high in joined)


def _digest(found: RegimeMap, threshold: float) -> str:
    """Return 12 digits of a hash of all that the bands depend on: another map of the same machine has others."""
    content = sha256(f"{found.fingerprint} {found.samples} {threshold!r}".encode())
    for values in (found.speeds, found.loads, found.chaos):
        content.update(np.ascontiguousarray(values, dtype="<f8").tobytes())
    return content.hexdigest()[:12]


def _moved(piece: _Piece, share: float) -> tuple[float, float]:
    return (
        (1 - share) * piece.low + share * piece.next_low,
        (1 - share) * piece.high + share * piece.next_high,
    )


def _pieces(here: list[tuple[float, float]], there: list[tuple[float, float]]) -> list[_Piece]:
    """Return what is forbidden between two loads with these bands: groups of overlapping bands, hull to hull."""
    marked = sorted([(low, high, 0) for low, high in here] + [(low, high, 1) for low, high in there])
    groups: list[list[tuple[float, float, int]]] = []
    for band in marked:
        if groups and band[0] <= max(high for _, high, _ in groups[-1]):
            groups[-1].append(band)
        else:
            groups.append([band])
    return [_hulls(group) for group in groups]


def _hulls(group: list[tuple[float, float, int]]) -> _Piece:
    """Return the hull at each of two loads of bands that overlap; a load without any takes the other's."""
    hulls = []
    for row in (0, 1):
        own = [(low, high) for low, high, of in group if of == row] or [(low, high) for low, high, _ in group]
        hulls.append((min(low for low, _ in own), max(high for _, high in own)))
    return _Piece(*hulls[0], *hulls[1])
