"""The factors of the study of vibration and impact: how each is read from a system, and how put into it.

The paper announces the study (claim C15) and prints neither factors nor levels; those here are this project's choice.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from seat_gear_dynamics.gears import Gear, Mesh
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.studies.taguchi.result import Factor

BACKED_OFF = "initial gap"
"""The noise factor that is no quantity of the system but of its initial state."""
_MICROMETRE = 1e-6


@dataclass(frozen=True)
class Variation:
    """How one factor is read from a system and put into it."""

    name: str
    unit: str
    spread: tuple[float, ...]
    """Levels as multiples of the system's own value."""
    read: Callable[[System], float | None]
    """The system's own value in `unit`; None where it has no such quantity."""
    apply: Callable[[System, float], System]
    otherwise: tuple[float, ...] = ()
    """Levels in `unit` for a system whose own value is 0; without any, such a system does not vary the factor."""

    def factor(self, system: System) -> Factor | None:
        """Return the factor around the system's own value, starting at the nearest level; None if it cannot vary."""
        own = self.read(system)
        if own is None or (own == 0 and not self.otherwise):
            return None
        levels = self.otherwise if own == 0 else tuple(own * multiple for multiple in self.spread)
        start = min(range(len(levels)), key=lambda index: abs(levels[index] - own))
        return Factor(self.name, self.unit, levels, start)


def _with_meshes(system: System, change: Callable[[Mesh], Mesh]) -> System:
    first, second = system.train.meshes
    return replace(system, train=replace(system.train, meshes=(change(first), change(second))))


def _with_gears(system: System, change: Callable[[Gear], Gear]) -> System:
    return _with_meshes(system, lambda mesh: replace(mesh, driver=change(mesh.driver), driven=change(mesh.driven)))


def _in_ratio(value: float, own: float, new: float) -> float:
    """Return `value` changed in the ratio of `new` to `own`; where `own` is 0 there is none, and `new` is for all."""
    return value * (new / own) if own else new


def _damping_ratio(system: System) -> float:
    return system.train.meshes[0].damping_ratio


def _with_damping_ratio(system: System, new: float) -> System:
    own = _damping_ratio(system)
    return _with_meshes(system, lambda mesh: replace(mesh, damping_ratio=_in_ratio(mesh.damping_ratio, own, new)))


def _backlash(system: System) -> float:
    return system.train.meshes[0].backlash / _MICROMETRE


def _with_backlash(system: System, new: float) -> System:
    own, metres = system.train.meshes[0].backlash, new * _MICROMETRE
    return _with_meshes(system, lambda mesh: replace(mesh, backlash=_in_ratio(mesh.backlash, own, metres)))


def _with_backlash_times(system: System, factor: float) -> System:
    return _with_meshes(system, lambda mesh: replace(mesh, backlash=mesh.backlash * factor))


def _speed(system: System) -> float:
    return system.train.speed(system.operating_point.frequency) / RPM


def _error(system: System) -> float | None:
    return 1.0 if any(harmonic.amplitude for harmonic in system.train.meshes[0].error_harmonics) else None


def _with_error_times(system: System, factor: float) -> System:
    def changed(mesh: Mesh) -> Mesh:
        return replace(
            mesh, error_harmonics=tuple(replace(h, amplitude=h.amplitude * factor) for h in mesh.error_harmonics)
        )

    return _with_meshes(system, changed)


def _with_error_shifted(system: System, shift: float) -> System:
    """Move e(p) against k(p) by `shift`, rad of the first harmonic."""

    def changed(mesh: Mesh) -> Mesh:
        return replace(
            mesh, error_harmonics=tuple(replace(h, phase=h.phase + h.order * shift) for h in mesh.error_harmonics)
        )

    return _with_meshes(system, changed)


def _with_supports_times(system: System, factor: float) -> System:
    return _with_gears(system, lambda gear: replace(gear, support_stiffness=gear.support_stiffness * factor))


def _eccentricity(system: System) -> float:
    """Return the larger eccentricity of s1 and s2, µm."""
    return max(gear.eccentricity for gear in system.train.gears[:2]) / _MICROMETRE


def _with_eccentricity(system: System, new: float) -> System:
    own, metres = _eccentricity(system) * _MICROMETRE, new * _MICROMETRE
    return _with_gears(system, lambda gear: replace(gear, eccentricity=_in_ratio(gear.eccentricity, own, metres)))


_HALF_AND_HALF_MORE = (0.5, 1.0, 1.5)
_FIFTH_LESS_AND_MORE = (0.8, 1.0, 1.2)

# Where the own value is 0 the levels are those of Table 3: conditions 4 to 6 for backlash, 1 to 3 for eccentricity.
CONTROLS: tuple[Variation, ...] = (
    Variation("damping ratio", "1", _HALF_AND_HALF_MORE, _damping_ratio, _with_damping_ratio),
    Variation("backlash", "µm", _HALF_AND_HALF_MORE, _backlash, _with_backlash, otherwise=(0.0, 10.0, 30.0)),
    Variation(
        "load",
        "N·m",
        _HALF_AND_HALF_MORE,
        lambda system: system.operating_point.load,
        lambda system, new: system.at(load=new),
    ),
    Variation("speed", "r/min", _FIFTH_LESS_AND_MORE, _speed, lambda system, new: system.at(speed=new * RPM)),
    Variation("transmission error", "× own", _HALF_AND_HALF_MORE, _error, _with_error_times),
    Variation("eccentricity", "µm", _HALF_AND_HALF_MORE, _eccentricity, _with_eccentricity, (0.0, 20.0, 40.0)),
    Variation("support stiffness", "× own", _HALF_AND_HALF_MORE, lambda system: 1.0, _with_supports_times),
)
"""The control factors, three levels each. Values are those of P12 and s1; the other meshes and gears go along in ratio.

Speed has the narrower levels, since resonances lie closer together than half of it."""

NOISE: tuple[Variation, ...] = (
    Variation(
        "error phase",
        "rad",
        (),
        lambda system: None if _error(system) is None else 0.0,
        _with_error_shifted,
        otherwise=(-0.5, 0.5),
    ),
    Variation("backlash tolerance", "× nominal", (0.9, 1.1), lambda system: 1.0, _with_backlash_times),
    Variation(BACKED_OFF, "× backlash", (), lambda system: 0.0, lambda system, _: system, otherwise=(0.0, 1.0)),
)
"""The noise factors, two levels each: how the error lies to the stiffness is a matter of assembly, the backlash has its
tolerance, and where motions coexist the initial state decides between them. The widths are chosen, not measured."""
