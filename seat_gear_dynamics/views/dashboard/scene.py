"""What stands still behind the moving picture: scales, the machine, the regime map, and the bands that a monitor may
go by."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from seat_gear_dynamics.gears import ForbiddenBand, GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes.regime_map import NAMES, RegimeMap
from seat_gear_dynamics.views.warning_said import PUBLISHED, band_said, source_said

Bands = list[list[float]]
_LABEL = 40  # characters of a source's name that are shown
_ROUNDED = 1.0  # r/min; the monitor says its band to the whole r/min


class MapBands(Protocol):
    """A map's forbidden bands as an alarm takes them."""

    label: str
    """As the warning names the source of its bands."""

    def at(self, load: float) -> Sequence[ForbiddenBand]:
        """Return the bands at `load`, N·m; none outside the map."""


class Shown(NamedTuple):
    """The bands to show; speeds in r/min."""

    bands: Bands
    """(low, high) of each, |speed|."""
    source: str
    """Whose they are, in words."""
    covered: float
    """Up to this speed something is known."""
    outside: str | None = None
    """In words that nothing is known at this load."""
    loads: str = ""
    """The loads of which something is known, in words; empty for all."""


class Scene:
    """The machine's scales, its regime map where there is one, and the bands that the monitor goes by.

    The warning names their source: the published ones, those of `map_bands` (the alarm's own, made of the map `found`),
    or a map that this page does not have, of which only the band nearest to the speed is known, as the warning says it.
    """

    def __init__(
        self,
        train: GearTrain,
        found: RegimeMap | None = None,
        *,
        map_name: str = "",
        map_bands: MapBands | None = None,
    ) -> None:
        self._train, self._map, self._map_name, self._map_bands = train, found, map_name, map_bands
        self._published = [[band.low / RPM, band.high / RPM] for band in train.bands]
        self._cached: tuple[float, Bands] | None = None

    def shown(self, load: float | None, said: Mapping[str, str]) -> Shown:
        """Return the bands of the monitor that `said` a warning with these values, at `load` (N·m).

        Before any warning those are shown that a monitor goes by which is told nothing: the published ones.
        """
        label = source_said(said)
        if self._map_bands is not None and label == self._map_bands.label:
            return self._of_the_map(load)
        own = band_said(said)
        if label == PUBLISHED and (own is None or any(_same(own, band) for band in self._published)):
            return Shown(self._published, self._published_words(), self._covered)
        unknown = (
            f"the nearest of those that the monitor goes by ({label[:_LABEL]}), which this page was not given: "
            "start the dashboard with --map and --system as the monitor has them"
        )
        return Shown([] if own is None else [list(own)], unknown, self._covered)

    def caution(self, rpm: float | None, load: float | None, said: Mapping[str, str]) -> str | None:
        """Return in words that the map forbids a speed, where the monitor goes by other bands than the map's."""
        if self._map_bands is None or source_said(said) == self._map_bands.label:
            return None
        if rpm is None or load is None or not any(low <= abs(rpm) <= high for low, high in self._at(load)):
            return None
        return (
            f"By the map shown, {abs(rpm):.0f} r/min is forbidden at this load. "
            'The monitor goes by other bands: see its parameter "map".'
        )

    def description(self) -> dict[str, Any]:
        """Return what the page needs once, as plain JSON values; speeds in r/min."""
        train = self._train
        return {
            "machine": train.name,
            "scaleRpm": max(self._covered, 2200.0),
            "loadScale": train.model.load_scale,
            "halfBacklash": [mesh.backlash / 2 for mesh in train.meshes],
            "lengthUnit": train.model.displacement_scale,
            "map": self._picture(),
        }

    @property
    def _covered(self) -> float:
        return float(self._train.model.covered_speed / RPM)

    def _published_words(self) -> str:
        loads = ", ".join(f"{load:g}" for load in sorted({band.load for band in self._train.bands}))
        return f"published at {loads} N·m, held at every load" if loads else "none are published of this machine"

    def _of_the_map(self, load: float | None) -> Shown:
        assert self._map is not None
        source, covered = "those of the map, at the present load", float(self._map.speeds[-1] / RPM)
        loads = f"{self._map.loads[0]:g} to {self._map.loads[-1]:g} N·m"
        if load is None or self._within(load):
            return Shown([] if load is None else self._at(load), source, covered, None, loads)
        return Shown([], source, covered, f"{load:.0f} N·m is outside the map ({loads})", loads)

    def _within(self, load: float) -> bool:
        return self._map is not None and bool(self._map.loads[0] <= load <= self._map.loads[-1])

    def _at(self, load: float) -> Bands:
        """Return the map's bands at a load taken to 1 N·m, which spares making them at every breath of its noise."""
        if self._map is None or self._map_bands is None or not self._within(load):
            return []
        whole = min(max(float(round(load)), float(self._map.loads[0])), float(self._map.loads[-1]))
        if self._cached is None or self._cached[0] != whole:
            found = self._map_bands.at(whole)
            self._cached = (whole, [[round(band.low / RPM, 1), round(band.high / RPM, 1)] for band in found])
        return self._cached[1]

    def _picture(self) -> dict[str, Any] | None:
        if self._map is None:
            return None
        machines = f"{self._map.samples} machines" if self._map.samples else "the nominal machine"
        return {
            "name": f"{self._map_name}, {machines}",
            "speeds": [round(speed, 2) for speed in (self._map.speeds / RPM).tolist()],
            "loads": self._map.loads.tolist(),
            "codes": self._map.codes.tolist(),
            "names": list(NAMES),
        }


def _same(one: Sequence[float], other: Sequence[float]) -> bool:
    return all(abs(a - b) <= _ROUNDED for a, b in zip(one, other, strict=True))
