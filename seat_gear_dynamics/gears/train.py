"""The typed, immutable description of a gear train: gears, meshes, model scales and published bands."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, pi, sqrt
from typing import Literal

from seat_gear_dynamics.gears.excitation import PeriodicSeries, TransmissionErrorHarmonic, error_series
from seat_gear_dynamics.gears.stiffness import MeshStiffness, mesh_stiffness
from seat_gear_dynamics.gears.tooth import Tooth, contact_ratio

PUBLISHED_PAIRS = ((1.29, 1349.0), (1.30, 1359.0), (1.52, 1589.0), (1.97, 2060.0))
"""Omega and the speed of s1, r/min, that section 3.1 converts it to."""


@dataclass(frozen=True)
class Provenance:
    """Where a parameter's value comes from."""

    kind: str
    """One of `given` (printed in the paper), `derived`, `calibrated`, `chosen`."""
    source: str
    """The table, equation or reason."""


@dataclass(frozen=True)
class Gear:
    """A gear on elastic supports; every quantity in SI units (Table 1 of the paper)."""

    name: str
    teeth: int
    module: float
    """m"""
    pressure_angle: float
    """rad"""
    tooth_height: float
    """Full height, addendum plus dedendum, m."""
    base_radius: float
    """m"""
    inertia: float
    """kg·m²"""
    mass: float
    """kg"""
    face_width: float
    """m"""
    bore_radius: float
    """m"""
    youngs_modulus: float
    """Pa"""
    poisson_ratio: float
    support_stiffness: float
    """k_n on x and y, N/m."""
    support_clearance_factor: float
    """mu_n of (10)-(13), multiplies the support stiffness."""
    support_damping_ratio: float
    """Of the gear's mass on its support."""
    torsional_stiffness: float
    """k_nt of (10)-(13): acts as r²·k_nt on the rotation, N/m."""
    torsional_damping_ratio: float
    eccentricity: float
    """Distance of the tooth ring's centre from the axis: an error along the line of action once a revolution, m."""
    eccentricity_phase: float
    """Of that error at mesh phase 0, rad."""

    @property
    def tooth(self) -> Tooth:
        """The involute tooth of this gear."""
        return Tooth(
            self.teeth,
            self.module,
            self.pressure_angle,
            self.tooth_height,
            self.face_width,
            self.bore_radius,
            self.youngs_modulus,
            self.poisson_ratio,
        )

    @property
    def equivalent_mass(self) -> float:
        """Inertia reduced to the line of action, J/r², kg."""
        return self.inertia / self.base_radius**2


@dataclass(frozen=True)
class Mesh:
    """A pair of meshing gears, `driver` on `driven`."""

    name: str
    driver: Gear
    driven: Gear
    mean_stiffness: float
    """The mean that the computed stiffness is scaled to where `scale_to_mean`, N/m (Table 2)."""
    scale_to_mean: bool
    """True: the computed shape scaled to `mean_stiffness`; False: the computed stiffness as it is."""
    stiffness_harmonics: int
    """Number of Fourier harmonics of k(t) that the model keeps."""
    damping_ratio: float
    """xi of (2)."""
    backlash: float
    """b of (1), on the line of action, m."""
    error_harmonics: tuple[TransmissionErrorHarmonic, ...]

    @cached_property
    def computed_stiffness(self) -> MeshStiffness:
        """The potential-energy stiffness over one mesh period, unscaled."""
        return mesh_stiffness(self.driver.tooth, self.driven.tooth)

    @property
    def mean_model_stiffness(self) -> float:
        """The mean stiffness that the equations use, N/m."""
        return self.mean_stiffness if self.scale_to_mean else self.computed_stiffness.mean

    @cached_property
    def stiffness(self) -> PeriodicSeries:
        """k(p), N/m, as a truncated Fourier series over the mesh phase p in [0, 1)."""
        shape = self.computed_stiffness.series(self.stiffness_harmonics)
        return shape.scaled(self.mean_model_stiffness / shape.mean)

    @cached_property
    def transmission_error(self) -> PeriodicSeries:
        """e(p), m, over the mesh phase p in [0, 1)."""
        return error_series(self.error_harmonics)

    @property
    def damping(self) -> float:
        """Mesh damping c of (2), N·s/m, with the gears' masses as the paper has it."""
        inverse_mass = 1 / self.driver.mass + 1 / self.driven.mass
        return 2 * self.damping_ratio * sqrt(self.mean_model_stiffness / inverse_mass)

    @property
    def contact_ratio(self) -> float:
        """Transverse contact ratio, dimensionless."""
        return contact_ratio(self.driver.tooth, self.driven.tooth)


@dataclass(frozen=True)
class Shaft:
    """The shaft that s2 and s3 share; massless, as the paper has it."""

    stiffness: float
    """Torsional, N·m/rad; 0 leaves the pairs decoupled, as (10)-(13) print them."""
    damping_ratio: float
    """Of s2's and s3's inertias turning against each other on the shaft."""

    @property
    def couples(self) -> bool:
        """Whether there is a shaft at all."""
        return self.stiffness > 0


@dataclass(frozen=True)
class Variant:
    """Which reading of the equations is solved."""

    backlash_in_torsion: bool
    """True: f(δ) in every line. False: δ in the torsional lines, as (10)-(13) print them (digest, erratum 5)."""
    damping_in_contact_only: bool
    """True: c·δ′ acts while teeth touch. False: always, as (10)-(13) print it."""


@dataclass(frozen=True)
class ForbiddenBand:
    """A range of input-gear speed to stay out of, published at one load."""

    low: float
    """rad/s of s1"""
    high: float
    """rad/s of s1"""
    load: float
    """T4 at which the band was found, N·m."""


@dataclass(frozen=True)
class Model:
    """Scales and limits of the model that belong to no single gear."""

    time_scale: float
    """omega_d that ties dimensionless time to a bench's seconds, rad/s."""
    displacement_scale: float
    """b_c, m."""
    load_scale: float
    """Mesh force of the model over the static force of the given torque; a calibration constant."""
    max_speed: float
    """Speeds beyond this are refused as absurd, rad/s of s1."""
    max_load: float
    """Loads beyond this are refused as absurd, N·m."""
    covered_speed: float
    """Highest |speed| for which a statement about bands exists, rad/s of s1."""


@dataclass(frozen=True)
class GearTrain:
    """The whole machine: two meshes in series, its scales, its published bands and where each number is from."""

    name: str
    meshes: tuple[Mesh, Mesh]
    shaft: Shaft
    variant: Variant
    model: Model
    bands: tuple[ForbiddenBand, ...]
    provenance: Mapping[str, Provenance]
    text: str
    """The description as it was read, for logs and reports."""

    @property
    def gears(self) -> tuple[Gear, Gear, Gear, Gear]:
        """s1, s2, s3, s4."""
        first, second = self.meshes
        return first.driver, first.driven, second.driver, second.driven

    @property
    def derived_time_scale(self) -> float:
        """omega_d of (15), rad/s: the scale in which the dimensionless equations are written."""
        return derived_time_scale(self.meshes[0])

    def frequency(self, speed: float) -> float:
        """Return the dimensionless mesh frequency Omega of P12 at `speed`, rad/s of s1."""
        return self.meshes[0].driver.teeth * speed / self.model.time_scale

    def speed(self, frequency: float) -> float:
        """Return the speed of s1, rad/s, at which P12 meshes with dimensionless frequency `frequency`."""
        return frequency * self.model.time_scale / self.meshes[0].driver.teeth

    def static_forces(self, load: float) -> tuple[float, float]:
        """Return the static mesh forces of P12 and P34, N, at load torque `load` on s4, N·m.

        F34 = T4/r4, T3 = F34·r3, F12 = T3/r2 (the digest's static chain); `load_scale` is not applied.
        """
        _, s2, s3, s4 = self.gears
        second = load / s4.base_radius
        return second * s3.base_radius / s2.base_radius, second

    def with_shaft(self, stiffness: float, damping_ratio: float = 0.01) -> "GearTrain":
        """Return the same train with s2 and s3 coupled by a shaft, N·m/rad; 0 takes the shaft away."""
        return replace(self, shaft=Shaft(stiffness, damping_ratio))

    def with_time_scale(self, scale: float | Literal["published", "derived"]) -> "GearTrain":
        """Return the same train with another omega_d for bench time: one of the two named values or a measured one."""
        if scale == "published":
            scale = published_time_scale(self.gears[0].teeth)
        elif scale == "derived":
            scale = self.derived_time_scale
        if not (isinstance(scale, int | float) and 0 < scale < inf):
            raise ValueError(
                f"The time scale is {scale!r}, expected 'published', 'derived' or a positive number of rad/s."
            )
        return replace(self, model=replace(self.model, time_scale=float(scale)))

    def with_mesh(
        self, index: int, *, damping_ratio: float | None = None, backlash: float | None = None
    ) -> "GearTrain":
        """Return the same train with mesh `index` (0 or 1) given another damping ratio or backlash (m)."""
        mesh = self.meshes[index]
        changed = replace(
            mesh,
            damping_ratio=mesh.damping_ratio if damping_ratio is None else damping_ratio,
            backlash=mesh.backlash if backlash is None else backlash,
        )
        meshes = (changed, self.meshes[1]) if index == 0 else (self.meshes[0], changed)
        return replace(self, meshes=meshes)


def derived_time_scale(mesh: Mesh) -> float:
    """Return omega_d of (15) from P12, rad/s."""
    return sqrt(mesh.mean_model_stiffness * (1 / mesh.driver.equivalent_mass + 1 / mesh.driven.equivalent_mass))


def published_time_scale(teeth: int) -> float:
    """Return the omega_d, rad/s, that the paper's own pairs of frequency and speed imply for `teeth` teeth of s1.

    The mean over the four pairs of section 3.1, which agree within their rounding. It is 1/62 of (15)'s value, and the
    paper does not say why (digest, erratum 4).
    """
    return sum(teeth * rpm * pi / 30 / frequency for frequency, rpm in PUBLISHED_PAIRS) / len(PUBLISHED_PAIRS)
