"""The plane of speed and load cut into forbidden and calm zones, by bands that hold at every load or follow it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.gears import ForbiddenBand
from seat_gear_dynamics.sensing import BandSource, MapBands

Array = NDArray[np.float64]
Places = NDArray[np.int64]


@dataclass(frozen=True)
class Stretch:
    """A range of |speed|: a forbidden band, or what lies between two."""

    low: float
    """rad/s of s1"""
    high: float
    """rad/s of s1; infinity for what lies above the last band."""
    forbidden: bool
    load: float | None = None
    """Where bands follow the load: the load of the map that is nearest, N·m; else None.

    `low` and `high` are then what they were in the middle of the loads at which the drive was there.
    """
    outside: bool = False
    """Whether it stands for all that lies outside the map, of which nothing is known."""


class Zones(Protocol):
    """Tells in which stretch a drive is; speeds in rad/s of s1, either sign, loads in N·m, arrays of shape (n,)."""

    def where(self, speed: Array, load: Array) -> Places:
        """Return the number of the stretch at each sample; numbers keep their meaning, new ones may come."""
        ...

    def forbidden(self, speed: Array, load: Array) -> NDArray[np.bool_]:
        """Return which samples are in a forbidden band."""
        ...

    def stretches(self) -> tuple[Stretch, ...]:
        """Return the stretches by number, as far as they are known by now."""
        ...


def zones(source: BandSource) -> Zones:
    """Return the zones of a source of bands."""
    return MovingZones(source) if isinstance(source, MapBands) else FixedZones(source.at(0.0))


class FixedZones:
    """Zones of bands that hold at every load: all speeds from 0 up, cut at their edges."""

    def __init__(self, bands: Sequence[ForbiddenBand]) -> None:
        """Take bands that do not overlap."""
        self._stretches = stretches(bands)
        self._lows = np.array([stretch.low for stretch in self._stretches])
        self._bands = tuple(bands)

    def where(self, speed: Array, load: Array) -> Places:
        """Return the number of the stretch at each sample, in order of speed."""
        return np.searchsorted(self._lows, np.abs(speed), side="right") - 1

    def forbidden(self, speed: Array, load: Array) -> NDArray[np.bool_]:
        """Return which samples are in a band, its edges among it."""
        magnitude = np.abs(speed)
        inside = [(magnitude >= band.low) & (magnitude <= band.high) for band in self._bands]
        return np.asarray(np.any(inside, axis=0)) if inside else np.zeros(len(speed), dtype=bool)

    def stretches(self) -> tuple[Stretch, ...]:
        """Return all stretches in order of speed."""
        return self._stretches


def stretches(bands: Sequence[ForbiddenBand]) -> tuple[Stretch, ...]:
    """Return all speeds from 0 up cut into forbidden bands and what lies between, in order.

    Bands, at whatever load they hold, must not overlap.
    """
    ordered = sorted(bands, key=lambda band: band.low)
    edges = [0.0, *(edge for band in ordered for edge in (band.low, band.high)), np.inf]
    cuts = [Stretch(low, high, bool(i % 2)) for i, (low, high) in enumerate(pairwise(edges))]
    return tuple(cut for cut in cuts if cut.high > cut.low)


class _Key(NamedTuple):
    """What a stretch of a map is known by: the number of the nearest load, how many bands there are, its place."""

    row: int
    bands: int
    place: int
    """0 below the first band, 1 in it, 2 above it, …"""


class _Level(NamedTuple):
    """The bands in the middle of a newton metre."""

    row: int
    edges: list[float]


@dataclass
class _Zone:
    number: int
    levels: set[float] = field(default_factory=set)
    """N·m at which the drive was there, middles of newton metres; none outside the map."""


_OUTSIDE = _Key(-1, 0, 0)


class MovingZones:
    """Zones of a map's bands, which follow the load; those that the drive came to, apart for each load of the map.

    Bands are taken in the middle of the newton metre that a load falls in, so that an hour of noisy load asks for some
    hundred sets of bands: the edges are off by what they move in half a newton metre. Memory is bounded by the map.
    Limit: bands that part or meet between two loads of the map are counted by how many there are at the load at hand.
    """

    def __init__(self, source: MapBands) -> None:
        self._source = source
        self._loads = source.map.loads
        self._first = 0.0 if source.beyond(0.0, float(self._loads[0])) is None else float(source.map.speeds[0])
        self._levels: dict[float, _Level] = {}
        self._zones: dict[_Key, _Zone] = {}

    def where(self, speed: Array, load: Array) -> Places:
        """Return the number of the stretch at each sample, in the order in which the drive came to them."""
        places = np.empty(len(speed), dtype=np.int64)
        for n, (key, at) in enumerate(self._keys(speed, load)):
            zone = self._zones.get(key)
            if zone is None:
                zone = self._zones[key] = _Zone(len(self._zones))
            if key is not _OUTSIDE:
                zone.levels.add(at)
            places[n] = zone.number
        return places

    def forbidden(self, speed: Array, load: Array) -> NDArray[np.bool_]:
        """Return which samples are in a band at their load; none outside the map."""
        return np.array([key.place % 2 == 1 for key, _ in self._keys(speed, load)], dtype=bool)

    def stretches(self) -> tuple[Stretch, ...]:
        """Return the stretches that the drive came to, by number."""
        return tuple(self._stretch(key, zone) for key, zone in self._zones.items())

    def _keys(self, speed: Array, load: Array) -> Iterator[tuple[_Key, float]]:
        """Yield what each sample is in, and the middle of the newton metre of its load."""
        lowest, highest = float(self._loads[0]), float(self._loads[-1])
        for magnitude, torque in zip(np.abs(speed).tolist(), load.tolist(), strict=True):
            at = min(torque // 1.0 + 0.5, highest)
            if lowest <= torque <= highest and self._first <= magnitude <= self._source.covered_speed:
                level = self._levels.get(at) or self._level(at)
                yield _Key(level.row, len(level.edges) // 2, bisect_right(level.edges, magnitude)), at
            else:
                yield _OUTSIDE, at

    def _level(self, at: float) -> _Level:
        edges = [edge for band in self._source.at(at) for edge in (band.low, band.high)]
        level = self._levels[at] = _Level(int(np.abs(self._loads - at).argmin()), edges)
        return level

    def _stretch(self, key: _Key, zone: _Zone) -> Stretch:
        if key == _OUTSIDE:
            return Stretch(0.0, np.inf, False, outside=True)
        levels = sorted(zone.levels)
        edges = [self._first, *self._levels[levels[len(levels) // 2]].edges, self._source.covered_speed]
        load = float(self._loads[key.row])
        return Stretch(edges[key.place], edges[key.place + 1], key.place % 2 == 1, load)
