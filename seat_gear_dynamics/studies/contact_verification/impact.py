"""The contact law of the verification model: ADAMS' IMPACT force with its STEP-ramped damping, and Coulomb friction.

Formulas: MSC Adams Solver documentation, functions IMPACT and STEP, and "Contact Friction Force Calculation"
(https://adams.thisaray.com/adams_view/contact_friction_force.html); Giesbers 2012, "Contact mechanics in MSC Adams",
https://essay.utwente.nl/62109, relates IMPACT to Hertz. Every quantity is in SI units.
"""

from math import isfinite, sqrt
from typing import NamedTuple

from numba import njit


class Contact(NamedTuple):
    """The parameters of one pair of flanks in contact."""

    stiffness: float
    """K, N/m^e"""
    exponent: float
    """e; 1.5 is Hertz' point contact, 1 a linear spring."""
    damping: float
    """Full damping, N·s/m."""
    depth: float
    """Penetration at which damping is full, m."""
    static_friction: float
    dynamic_friction: float
    stiction_speed: float
    """Sliding speed at which friction is `static_friction`, m/s."""
    friction_speed: float
    """Sliding speed from which on friction is `dynamic_friction`, m/s."""


def checked(contact: Contact) -> Contact:
    """Return `contact`; raises ValueError, a sentence, where a parameter is none that the law can take."""
    for name, value in contact._asdict().items():
        may_vanish = name in ("damping", "static_friction", "dynamic_friction")
        if not isfinite(value) or value < 0 or (value == 0 and not may_vanish):
            least = "of at least 0" if may_vanish else "above 0"
            raise ValueError(f"The contact's {name} is {value!r}, expected a finite number {least}: correct it.")
    if contact.exponent < 1:
        raise ValueError(
            f"The contact's exponent is {contact.exponent!r}, expected at least 1: below, the stiffness is infinite "
            "where contact begins."
        )
    if contact.friction_speed <= contact.stiction_speed:
        raise ValueError(
            f"The friction speed is {contact.friction_speed!r} m/s, expected more than the stiction speed "
            f"{contact.stiction_speed!r} m/s: give the larger one as friction speed."
        )
    return contact


def hertz_stiffness(first_radius: float, second_radius: float, youngs_modulus: float, poisson_ratio: float) -> float:
    """Return K = 4/3·√R·E* of two spheres of one material, N/m^1.5: the value users of ADAMS take for gears.

    1/R = 1/R₁ + 1/R₂ (m), E* = E/(2·(1 − ν²)) (Pa); Johnson 1985, Contact Mechanics, (4.22). With pitch radii as R₁ and
    R₂ this gives Table 2's contact stiffness. Limit: two flanks touch along a line and not in a point; the face width
    does not enter, so this K is a convention and no property of the teeth.
    """
    radius = first_radius * second_radius / (first_radius + second_radius)
    return 4 / 3 * sqrt(radius) * youngs_modulus / (2 * (1 - poisson_ratio**2))


@njit(cache=True, nogil=True, error_model="numpy")
def step(x: float, x0: float, h0: float, x1: float, h1: float) -> float:
    """Return ADAMS' STEP: h0 below x0, h1 above x1, and the cubic between that is level at both ends."""
    if x <= x0:
        return h0
    if x >= x1:
        return h1
    share = (x - x0) / (x1 - x0)
    return h0 + (h1 - h0) * share * share * (3.0 - 2.0 * share)


@njit(cache=True, nogil=True, error_model="numpy")
def impact(contact: Contact, penetration: float, rate: float) -> tuple[float, float, float]:
    """Return (force, its slope over penetration, its slope over rate): N, N/m, N·s/m.

    force = max(0, K·p^e + c·STEP(p; 0, 0; d, 1)·dp/dt) for p > 0, else 0. `rate` is dp/dt, m/s, positive while the
    bodies approach (ADAMS writes the rate of their distance, and so a minus). The force never attracts; where the limit
    to 0 acts, and out of contact, both slopes are 0.
    """
    if not penetration > 0.0:
        return 0.0, 0.0, 0.0
    elastic = contact.stiffness * penetration**contact.exponent
    share = min(penetration / contact.depth, 1.0)
    ramp = share * share * (3.0 - 2.0 * share)
    force = elastic + contact.damping * ramp * rate
    if not force > 0.0:
        return 0.0, 0.0, 0.0
    ramp_slope = 6.0 * share * (1.0 - share) / contact.depth
    slope = contact.exponent * elastic / penetration + contact.damping * ramp_slope * rate
    return force, slope, contact.damping * ramp


@njit(cache=True, nogil=True, error_model="numpy")
def friction_coefficient(contact: Contact, slip: float) -> float:
    """Return the friction force over the normal force, with the sign of `slip`, m/s; ADAMS prints it opposing.

    0 at rest, ± the static coefficient at ± the stiction speed, ± the dynamic one from ± the friction speed on, joined
    by STEPs. Limit: as it is 0 at rest it cannot hold a load; a standing body creeps.
    """
    speed = abs(slip)
    if speed < contact.stiction_speed:
        return step(
            slip, -contact.stiction_speed, -contact.static_friction, contact.stiction_speed, contact.static_friction
        )
    size = step(
        speed, contact.stiction_speed, contact.static_friction, contact.friction_speed, contact.dynamic_friction
    )
    return size if slip > 0.0 else -size
