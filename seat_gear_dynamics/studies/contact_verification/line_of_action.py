"""Where two rigid involute gears touch: positions on the line of action, and the gap beyond its path."""

from math import atan, atan2, cos, hypot, pi, sin, sqrt
from typing import NamedTuple

from numba import njit

from seat_gear_dynamics.gears import Mesh


class Line(NamedTuple):
    """A pair of rigid gears; positions s are m from the driver's base-circle tangent point along the line of action."""

    driver_radius: float
    """Base circle, m."""
    driven_radius: float
    driver_tip: float
    """Tip circle, m."""
    driven_tip: float
    length: float
    """Between the two tangent points, m."""
    start: float
    """Position where the driven tip enters, m."""
    end: float
    """Position where the driver's tip leaves, m."""
    pitch: float
    """Base pitch, m."""
    pitch_point: float
    """Position where nothing slides, m."""
    teeth: float
    """Of the driver."""
    sine: float
    """Of the operating pressure angle."""
    cosine: float
    half_backlash: float
    """Half the backlash on the line of action, m."""
    corner: bool
    """True: a tip touches before and after the path of contact as the flanks' geometry has it; False: pairs enter and
    leave at once."""


def line_of_action(mesh: Mesh, backlash: float, *, corner: bool = True) -> Line:
    """Return the pair `mesh` with `backlash`, m on the line of action, made by moving the gears apart.

    Section 4.1 sets the backlash by the centre distance: the gap opens by 2·sin α per metre of it (to first order),
    which also moves the operating pressure angle and shortens the path of contact. Raises ValueError for a backlash
    below 0 or so large that less than one pair would remain in contact.
    """
    if not 0 <= backlash < float("inf"):
        raise ValueError(f"The backlash is {backlash!r} m, expected a finite number of at least 0.")
    first, second = mesh.driver, mesh.driven
    pitch_radii = first.tooth.pitch_radius + second.tooth.pitch_radius
    centre = pitch_radii + backlash / (2 * sin(first.pressure_angle))
    base = first.base_radius + second.base_radius
    length = sqrt(centre**2 - base**2)
    start = length - sqrt(second.tooth.tip_radius**2 - second.base_radius**2)
    end = sqrt(first.tooth.tip_radius**2 - first.base_radius**2)
    pitch = 2 * pi * first.base_radius / first.teeth
    if not end - start >= pitch:
        raise ValueError(
            f"With a backlash of {backlash * 1e6:g} µm the contact ratio of {mesh.name} is "
            f"{(end - start) / pitch:.3f}, expected at least 1: give a smaller backlash."
        )
    return Line(
        first.base_radius,
        second.base_radius,
        first.tooth.tip_radius,
        second.tooth.tip_radius,
        length,
        start,
        end,
        pitch,
        length * first.base_radius / base,
        float(first.teeth),
        length / centre,
        base / centre,
        backlash / 2,
        corner,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def gap(line: Line, position: float) -> tuple[float, float]:
    """Return the separation of an unloaded pair, m, and its slope over its `position` on the line of action.

    0 on the path of contact. Beyond it only a tip can touch: before the start the driven gear's, past the end the
    driver's; where `line.corner` is off the gap is 1 m there, out of reach. This is the corner contact of Munro,
    Morrish & Palmer 1999, Proc. IMechE C 213, 389-400, exact for rigid involutes with sharp tips.
    """
    if line.start <= position <= line.end:
        return 0.0, 0.0
    if not line.corner:
        return 1.0, 0.0
    if position < line.start:
        return _tip_gap(line, position, line.driven_radius, line.driven_tip, line.driver_radius)
    separation, slope = _tip_gap(line, line.length - position, line.driver_radius, line.driver_tip, line.driven_radius)
    return separation, -slope


@njit(cache=True, nogil=True, error_model="numpy")
def _tip_gap(line: Line, position: float, base: float, tip: float, flank: float) -> tuple[float, float]:
    """Return how far a flank (base radius `flank`, at `position` of its own) stays from the other gear's tip, m.

    Involutes of one base circle are equidistant along their common normals. So the distance is the difference of two
    base-circle arcs: of the involute through the tip's corner, and of the flank.
    """
    roll = sqrt((tip / base) ** 2 - 1.0)
    angle = (line.length - position) / base - (roll - atan(roll))  # of the corner, from its gear's tangent point
    x, y = base + flank - tip * cos(angle), line.length - tip * sin(angle)
    own_roll = sqrt((hypot(x, y) / flank) ** 2 - 1.0)
    tangent = atan2(y, x) - atan(own_roll)
    return flank * (tangent + own_roll) - position, tip / base * cos(tangent - angle) - 1.0
