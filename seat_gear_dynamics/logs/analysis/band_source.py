"""By which bands a log is judged: those of a map that a user names, else those that its own warnings name."""

from __future__ import annotations

from pathlib import Path

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.regimes.regime_map import MapError, RegimeMap
from seat_gear_dynamics.sensing import BandSource, MapBands, PublishedBands, map_path, packaged_map


def band_source(train: GearTrain, path: Path | None, stated: str | None) -> BandSource:
    """Return the bands of the map at `path` (or `packaged`); without one those whose label `stated` a log names.

    Known by their label are the published bands of `train` and the packaged map; for any other one, and for a log that
    names none, the published ones are returned, so hold the label of what is returned against `stated`. Raises LogError
    where the map at `path` cannot be read, is of another machine, or has one load alone.
    """
    if path is not None:
        try:
            return _map_bands(map_path(path), train)
        except (MapError, OSError) as error:
            raise LogError(f"The map {path} cannot be used: {error}") from error
    published = PublishedBands.of(train)
    if stated in (None, published.label):
        return published
    try:
        packaged = _map_bands(packaged_map(), train)
    except (MapError, OSError):
        return published
    return packaged if packaged.label == stated else published


def _map_bands(path: Path, train: GearTrain) -> MapBands:
    with path.open("rb") as file:
        return MapBands(RegimeMap.load(file, train), train)
