"""What stands still behind the moving picture: scales, the machine, forbidden bands by load, the regime map."""

from typing import Any

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes.regime_map import NAMES, RegimeMap

Bands = list[list[float]]


class Scene:
    """The machine's scales, and its bands: those of the map where one is given, else the published ones."""

    def __init__(self, train: GearTrain, found: RegimeMap | None = None, *, map_name: str = "") -> None:
        self._train, self._map, self._map_name = train, found, map_name
        self._cached: tuple[float, Bands] | None = None

    @property
    def bands_from(self) -> str:
        """Where the bands are from, in words."""
        if self._map is None:
            loads = sorted({band.load for band in self._train.bands})
            given = f"published at {', '.join(f'{load:g}' for load in loads)} N·m, shown at every load"
            return given if loads else "the machine has no forbidden bands"
        machines = f"{self._map.samples} machines" if self._map.samples else "the nominal machine"
        return f"map {self._map_name}, {machines}"

    @property
    def covered_rpm(self) -> float:
        """The end of the studied range, r/min."""
        return float(self._train.model.covered_speed / RPM)

    def bands(self, load: float | None) -> Bands:
        """Return (low, high, uncertainty of low, of high) in r/min of each band at `load` (N·m), |speed|.

        Of a map the load is taken to 1 N·m, which spares computing them at every breath of a measured load; outside
        it, and without a load, there are none.
        """
        if self._map is None:
            return [[band.low / RPM, band.high / RPM, 0.0, 0.0] for band in self._train.bands]
        if load is None or not self._map.covers(float(self._map.speeds[0]), load):
            return []
        whole = min(max(float(round(load)), float(self._map.loads[0])), float(self._map.loads[-1]))
        if self._cached is None or self._cached[0] != whole:
            self._cached = (whole, self._map_bands(whole))
        return self._cached[1]

    def outside_the_map(self, load: float | None) -> str | None:
        """Return in words that the map says nothing at `load` (N·m), or None."""
        if self._map is None or load is None or self._map.covers(float(self._map.speeds[0]), load):
            return None
        return f"{load:.0f} N·m is outside the map ({self._map.loads[0]:g} to {self._map.loads[-1]:g} N·m)"

    def description(self) -> dict[str, Any]:
        """Return what the page needs once, as plain JSON values; speeds in r/min."""
        train = self._train
        return {
            "machine": train.name,
            "coveredRpm": self.covered_rpm,
            "scaleRpm": max(self.covered_rpm, 2200.0),
            "loadScale": train.model.load_scale,
            "halfBacklash": [mesh.backlash / 2 for mesh in train.meshes],
            "lengthUnit": train.model.displacement_scale,
            "teeth": train.meshes[0].driver.teeth,
            "bandsFrom": self.bands_from,
            "published": [[band.low / RPM, band.high / RPM] for band in train.bands],
            "map": self._picture(),
        }

    def _map_bands(self, load: float) -> Bands:
        assert self._map is not None
        found = self._map.bands(load)
        return [[round(v / RPM, 1) for v in (b.low, b.high, b.low_error, b.high_error)] for b in found]

    def _picture(self) -> dict[str, Any] | None:
        if self._map is None:
            return None
        return {
            "speeds": [round(speed, 2) for speed in (self._map.speeds / RPM).tolist()],
            "loads": self._map.loads.tolist(),
            "codes": self._map.codes.tolist(),
            "names": list(NAMES),
        }
