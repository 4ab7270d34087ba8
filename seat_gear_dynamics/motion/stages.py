"""The equations of motion for state and tangent of both meshes at once, as the stages of a Runge-Kutta step want them.

The lanes of a `Four` are P12, P34, the tangent of P12 and that of P34. The six coordinates of a mesh, x, y and u of its
driver and of its driven gear, are six of them, and all lanes do the same arithmetic at the same time. Each does what
`kernel._rates` does, operation by operation in its order, so that both give the same bits.

Loops over the six are written out: only so does the compiler keep a motion in registers from stage to stage.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion.kernel import Equations, inlined
from seat_gear_dynamics.motion.vectors import (
    Four,
    even_and_odd,
    four,
    front_and_back,
    front_twice,
    lane,
    neighbours,
    where_above,
)

Array = NDArray[np.float64]
Six = tuple[Four, Four, Four, Four, Four, Four]
"""The coordinates of a mesh, their rates, or a coefficient of each."""


class Mechanics(NamedTuple):
    """What does not change from step to step; see `coefficients.Coefficients`."""

    stiffness: Six
    damping: Six
    direction: Six
    reaction: Six
    drive: Six
    mesh_damping: Four
    half_backlash: Four
    shaft_direction: Four
    """Of u2 in the lanes of P12 and its tangent, of u3 in those of P34 and its tangent; so too `shaft_reaction`."""
    shaft_reaction: Four
    shaft_stiffness: float
    shaft_damping: float
    coupled: bool
    backlash_in_torsion: bool
    damping_in_contact_only: bool


class Excitation(NamedTuple):
    """What moves the meshes at a moment; nothing moves the tangents."""

    kappa: Four
    error: Four
    """-e, and 0 in the tangents."""
    rate: Four
    """-de/dτ, and 0 in the tangents."""


class Contact(NamedTuple):
    """The meshes at a moment; in the tangents' lanes the changes of them."""

    delta: Four
    rate: Four
    force: Four
    touching: Four
    """1 in contact, 0 out of it; no meaning in the tangents' lanes."""
    beyond: Four
    """f(δ); no meaning in the tangents' lanes."""


class Tally(NamedTuple):
    """Force statistics in the order of `kernel.WINDOW_COLUMNS`; no meaning in the tangents' lanes."""

    duration: Four
    sum: Four
    squares: Four
    least: Four
    most: Four
    apart: Four


@inlined
def six_of_meshes(row: Array) -> Six:
    """Return a row (12,) that holds for state and tangent alike."""
    return (
        four(row[0], row[6], row[0], row[6]),
        four(row[1], row[7], row[1], row[7]),
        four(row[2], row[8], row[2], row[8]),
        four(row[3], row[9], row[3], row[9]),
        four(row[4], row[10], row[4], row[10]),
        four(row[5], row[11], row[5], row[11]),
    )


@inlined
def gathered(y: Array, z: Array, o: int) -> Six:
    """Return the twelve numbers from `o` on of a state and a tangent."""
    return (
        four(y[o], y[o + 6], z[o], z[o + 6]),
        four(y[o + 1], y[o + 7], z[o + 1], z[o + 7]),
        four(y[o + 2], y[o + 8], z[o + 2], z[o + 8]),
        four(y[o + 3], y[o + 9], z[o + 3], z[o + 9]),
        four(y[o + 4], y[o + 10], z[o + 4], z[o + 10]),
        four(y[o + 5], y[o + 11], z[o + 5], z[o + 11]),
    )


@inlined
def _lay_down(value: Four, y: Array, z: Array, i: int) -> None:
    y[i], y[i + 6], z[i], z[i + 6] = lane(value, 0), lane(value, 1), lane(value, 2), lane(value, 3)


@inlined
def laid_down(values: Six, y: Array, z: Array, o: int) -> None:
    """Write back what `gathered` returns."""
    _lay_down(values[0], y, z, o)
    _lay_down(values[1], y, z, o + 1)
    _lay_down(values[2], y, z, o + 2)
    _lay_down(values[3], y, z, o + 3)
    _lay_down(values[4], y, z, o + 4)
    _lay_down(values[5], y, z, o + 5)


@inlined
def mechanics_of(eq: Equations) -> Mechanics:
    """Return the coefficients of `eq` lane by lane."""
    return Mechanics(
        six_of_meshes(eq.stiffness),
        six_of_meshes(eq.damping),
        six_of_meshes(eq.direction),
        six_of_meshes(eq.reaction),
        six_of_meshes(eq.drive),
        four(eq.mesh_damping[0], eq.mesh_damping[1], eq.mesh_damping[0], eq.mesh_damping[1]),
        four(eq.half_backlash[0], eq.half_backlash[1], 0.0, 0.0),
        four(eq.shaft_direction[5], eq.shaft_direction[8], eq.shaft_direction[5], eq.shaft_direction[8]),
        four(eq.shaft_reaction[5], eq.shaft_reaction[8], eq.shaft_reaction[5], eq.shaft_reaction[8]),
        eq.shaft_stiffness,
        eq.shaft_damping,
        eq.coupled,
        eq.backlash_in_torsion,
        eq.damping_in_contact_only,
    )


@inlined
def excitation_of(row: Array, rate: float) -> Excitation:
    """Return the excitation of a row (2, 3) of tables, as in `kernel._rates`, lane by lane."""
    return Excitation(
        four(row[0, 0], row[1, 0], row[0, 0], row[1, 0]),
        four(-row[0, 1], -row[1, 1], 0.0, 0.0),
        four(-row[0, 2] * rate, -row[1, 2] * rate, 0.0, 0.0),
    )


@inlined
def push_of(drive: Six, load: float) -> Six:
    """Return the accelerations by the load; the tangents' are -0, as 0 less a 0 would turn the sign of -0."""
    none = four(-0.0, -0.0, -0.0, -0.0)
    return (
        front_and_back(load * drive[0], none),
        front_and_back(load * drive[1], none),
        front_and_back(load * drive[2], none),
        front_and_back(load * drive[3], none),
        front_and_back(load * drive[4], none),
        front_and_back(load * drive[5], none),
    )


@inlined
def closing(direction: Six, values: Six, start: Four) -> Four:
    """Return how coordinates, or rates, close their mesh, added to `start`."""
    w, x = direction, values
    return start + w[0] * x[0] + w[1] * x[1] + w[2] * x[2] + w[3] * x[3] + w[4] * x[4] + w[5] * x[5]


@inlined
def moved(x: Six, h: float, rate: Six) -> Six:
    """Return x + h·rate."""
    return (
        x[0] + h * rate[0],
        x[1] + h * rate[1],
        x[2] + h * rate[2],
        x[3] + h * rate[3],
        x[4] + h * rate[4],
        x[5] + h * rate[5],
    )


@inlined
def _weighted(k1: Four, k2: Four, k3: Four, k4: Four) -> Four:
    return k1 + 2.0 * k2 + 2.0 * k3 + k4


@inlined
def weighted(k1: Six, k2: Six, k3: Six, k4: Six) -> Six:
    """Return k1 + 2·k2 + 2·k3 + k4, six times what a Runge-Kutta step moves by in a unit of time."""
    return (
        _weighted(k1[0], k2[0], k3[0], k4[0]),
        _weighted(k1[1], k2[1], k3[1], k4[1]),
        _weighted(k1[2], k2[2], k3[2], k4[2]),
        _weighted(k1[3], k2[3], k3[3], k4[3]),
        _weighted(k1[4], k2[4], k3[4], k4[4]),
        _weighted(k1[5], k2[5], k3[5], k4[5]),
    )


@inlined
def contact_of(q: Six, v: Six, x: Excitation, m: Mechanics) -> Contact:
    """Return the meshes at coordinates q and rates v."""
    zero, one = four(0.0, 0.0, 0.0, 0.0), four(1.0, 1.0, 1.0, 1.0)
    delta, rate = closing(m.direction, q, x.error), closing(m.direction, v, x.rate)
    upper, lower = m.half_backlash, zero - m.half_backlash
    beyond = where_above(delta, upper, delta - upper, where_above(lower, delta, delta + upper, zero))
    touching = where_above(delta, upper, one, where_above(lower, delta, one, zero))
    sloped = front_and_back(one, front_twice(touching))  # f(δ) itself in the meshes, its slope in the tangents
    damping = m.mesh_damping
    if m.damping_in_contact_only:
        damping = damping * front_twice(touching)
    force = x.kappa * sloped * front_and_back(beyond, delta) + damping * rate
    return Contact(delta, rate, force, touching, beyond)


@inlined
def accelerations(q: Six, v: Six, push: Six, x: Excitation, found: Contact, m: Mechanics) -> Six:
    """Return the second derivatives in τ where the meshes are as `found` at these q and v."""
    k, b, g, f = m.stiffness, m.damping, m.reaction, found.force
    u_of_driver = push[2] - k[2] * q[2] - b[2] * v[2] - g[2] * f
    u_of_driven = push[5] - k[5] * q[5] - b[5] * v[5] - g[5] * f
    if not m.backlash_in_torsion:  # what δ has over f(δ), on the lines of u
        one = four(1.0, 1.0, 1.0, 1.0)
        free = front_and_back(one, one - front_twice(found.touching))
        over = front_and_back(found.delta - found.beyond, found.delta)
        u_of_driver = u_of_driver - g[2] * x.kappa * free * over
        u_of_driven = u_of_driven - g[5] * x.kappa * free * over
    if m.coupled:
        pull = m.shaft_reaction * _twist(q, v, m)
        u_of_driver = even_and_odd(u_of_driver, u_of_driver - pull)  # s3 drives P34
        u_of_driven = even_and_odd(u_of_driven - pull, u_of_driven)  # P12 drives s2
    return (
        push[0] - k[0] * q[0] - b[0] * v[0] - g[0] * f,
        push[1] - k[1] * q[1] - b[1] * v[1] - g[1] * f,
        u_of_driver,
        push[3] - k[3] * q[3] - b[3] * v[3] - g[3] * f,
        push[4] - k[4] * q[4] - b[4] * v[4] - g[4] * f,
        u_of_driven,
    )


@inlined
def _twist(q: Six, v: Six, m: Mechanics) -> Four:
    """Return the force of the shaft, the same in both lanes of the state and in both of the tangent."""
    u, rate = even_and_odd(q[5], q[2]), even_and_odd(v[5], v[2])
    part = four(0.0, 0.0, 0.0, 0.0) + m.shaft_direction * (m.shaft_stiffness * u + m.shaft_damping * rate)
    return part + neighbours(part)


@inlined
def tally_of(window: Array) -> Tally:
    """Return a window (2, 6) lane by lane."""
    return Tally(
        four(window[0, 0], window[1, 0], 0.0, 0.0),
        four(window[0, 1], window[1, 1], 0.0, 0.0),
        four(window[0, 2], window[1, 2], 0.0, 0.0),
        four(window[0, 3], window[1, 3], 0.0, 0.0),
        four(window[0, 4], window[1, 4], 0.0, 0.0),
        four(window[0, 5], window[1, 5], 0.0, 0.0),
    )


@inlined
def counted(tally: Tally, found: Contact, h: float) -> Tally:
    """Return the statistics with one step's start values added."""
    force, one = found.force, four(1.0, 1.0, 1.0, 1.0)
    return Tally(
        tally.duration + h * one,
        tally.sum + h * force,
        tally.squares + h * force * force,
        where_above(tally.least, force, force, tally.least),
        where_above(force, tally.most, force, tally.most),
        tally.apart + h * (one - found.touching),
    )


@inlined
def _note(value: Four, window: Array, column: int) -> None:
    window[0, column], window[1, column] = lane(value, 0), lane(value, 1)


@inlined
def note_tally(tally: Tally, window: Array) -> None:
    """Write back what `tally_of` returns."""
    _note(tally.duration, window, 0)
    _note(tally.sum, window, 1)
    _note(tally.squares, window, 2)
    _note(tally.least, window, 3)
    _note(tally.most, window, 4)
    _note(tally.apart, window, 5)
