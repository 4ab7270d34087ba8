"""The generated step, run as plain Python, against the same Runge-Kutta step in NumPy on the public right-hand side."""

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from math import pi
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain, Variant
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.motion.lanes import LanePoints
from seat_gear_dynamics.motion.lanes.batch import Entry, entry, rows
from seat_gear_dynamics.motion.lanes.excitation import grid
from seat_gear_dynamics.motion.lanes.period import lay_out
from seat_gear_dynamics.motion.lanes.points import checked
from seat_gear_dynamics.motion.lanes.reduction import expand_state, reduce_state, reduced
from seat_gear_dynamics.motion.lanes.source import advance_source

Array = NDArray[np.float64]

SHAFT = 2.6e4  # N·m/rad: a steel shaft of the train's size
VARIANTS = [Variant(torsion, contact) for torsion, contact in product((True, False), repeat=2)]
ARRANGEMENTS = [(0.0, 1), (0.0, 2), (SHAFT, 2)]


def made_ready(train: GearTrain, state: Array, frequency: float, load: float, meshes: int) -> Entry:
    points = checked(LanePoints(frequency, load, state=state))
    return entry(train, points, meshes=meshes, target_steps=256, longest_step=0.1)


def stepped(train: GearTrain, state: Array, frequency: float, load: float, meshes: int, part: int) -> tuple[Array, Any]:
    """Return the rows of lanes after one step from the start of part number `part`, and their company's facts."""
    ready = made_ready(train, state, frequency, load, meshes)
    ((company, lanes),) = ready.companies()
    table, half_step = rows(company.structure, [(ready, lanes)])
    shared = grid(company.excitation, company.level, company.direction)
    excitation = np.empty((2 * shared.base + 1) * 3 * meshes)
    lay_out.py_func(excitation, *shared.tables, shared.runout, shared.turning, shared.base, part)
    module: dict[str, Any] = {}
    exec(advance_source(company.structure.full, len(state)), module)
    flat = table.ravel().copy()
    module["advance"](flat, excitation, 1)
    return flat.reshape(table.shape), (company.structure, half_step, shared)


def runge_kutta_step(system: System, tau: float, state: Array, h: float) -> Array:
    k1 = system.derivative(tau, state)
    k2 = system.derivative(tau + h / 2, state + h / 2 * k1)
    k3 = system.derivative(tau + h / 2, state + h / 2 * k2)
    k4 = system.derivative(tau + h, state + h * k3)
    return state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def random_states(train: GearTrain, seed: int, count: int = 3) -> Array:
    """Return states in and out of the backlash of ±1, at rest across the line of action."""
    return expand_state(np.random.default_rng(seed).normal(size=(count, 16)), reduced(train).line)


@pytest.mark.parametrize("variant", VARIANTS, ids=str)
@pytest.mark.parametrize(("shaft", "meshes"), ARRANGEMENTS)
@pytest.mark.parametrize(("frequency", "part"), [(0.9, 0), (-0.41, 7), (0.03, 45)])
def test_a_step_of_every_kind_is_the_numpy_step_to_rounding(
    train: GearTrain, variant: Variant, shaft: float, meshes: int, frequency: float, part: int
) -> None:
    kind = replace(train, variant=variant).with_shaft(shaft)
    load, states = 300.0, random_states(train, part)
    table, (structure, half_step, shared) = stepped(kind, states, frequency, load, meshes, part)
    system = System(kind).at(frequency=frequency, load=load)
    tau, n = part / shared.parts * 2 * pi / abs(frequency), structure.coordinates
    for lane, state in enumerate(states):
        h = 2 * half_step[lane]
        expected = reduce_state(runge_kutta_step(system, tau, state, h), reduced(kind).line)[0]
        found = np.concatenate([table[:n, lane], table[n : 2 * n, lane] / half_step[lane]])
        # Rounding of numbers of order 1; the phase of part 45 is rounded on both sides.
        assert found == pytest.approx(np.concatenate([expected[:n], expected[8 : 8 + n]]), abs=1e-12)


@pytest.mark.parametrize(("shaft", "meshes"), ARRANGEMENTS)
@pytest.mark.parametrize(("frequency", "part"), [(0.9, 16), (-0.41, 39), (0.03, 45)])
def test_a_step_of_an_eccentric_train_is_the_numpy_step_to_rounding(
    make_train: Callable[..., GearTrain], shaft: float, meshes: int, frequency: float, part: int
) -> None:
    train = make_train({"gears.*.eccentricity": 20, "gears.s2.eccentricity_phase": 1.0}).with_shaft(shaft)
    states = random_states(train, part)
    table, (structure, half_step, shared) = stepped(train, states, frequency, 300.0, meshes, part)
    system = System(train).at(frequency=frequency, load=300.0)
    tau, n = part / shared.parts * 2 * pi / abs(frequency), structure.coordinates
    for lane, state in enumerate(states):
        expected = reduce_state(runge_kutta_step(system, tau, state, 2 * half_step[lane]), reduced(train).line)[0]
        found = np.concatenate([table[:n, lane], table[n : 2 * n, lane] / half_step[lane]])
        assert found == pytest.approx(np.concatenate([expected[:n], expected[8 : 8 + n]]), abs=1e-12)


@pytest.mark.parametrize("variant", VARIANTS, ids=str)
@pytest.mark.parametrize(("shaft", "meshes"), ARRANGEMENTS)
def test_the_tangent_is_the_difference_of_two_steps_where_no_contact_changes(
    train: GearTrain, variant: Variant, shaft: float, meshes: int
) -> None:
    # δ within ±0.3 of -4, 0 or 4: far from the ends of the backlash at ±1. The equations are linear there, so the
    # difference of two motions is a tangent exactly, and only rounding over the disturbance's size of 1 is left.
    kind = replace(train, variant=variant).with_shaft(shaft)
    line, rng = reduced(kind).line, np.random.default_rng(1)
    states = rng.normal(size=(3, 16)) * 0.02
    states[:, [1, 5]] += np.array([[-4.0], [0.0], [4.0]])
    first, (structure, half_step, _) = stepped(kind, expand_state(states, line), 0.7, 100.0, meshes, 0)
    row, n = structure.row, 4 * structure.full.tangent_meshes
    begin = made_ready(kind, expand_state(states, line), 0.7, 100.0, meshes)
    start, _ = rows(begin.structure, [(begin, np.arange(3))])
    direction = np.zeros((3, 16))
    direction[:, :n] = start[row["ZQ0"] : row["ZQ0"] + n].T * 0.01
    direction[:, 8 : 8 + n] = (start[row["ZV0"] : row["ZV0"] + n] / half_step).T * 0.01
    second, _ = stepped(kind, expand_state(states + direction, line), 0.7, 100.0, meshes, 0)
    count = structure.coordinates
    for kind_of_row, offset in (("ZQ0", 0), ("ZV0", count)):
        found = first[row[kind_of_row] : row[kind_of_row] + n]
        assert found == pytest.approx((second - first)[offset : offset + n] / 0.01, abs=1e-11)


def test_the_ends_of_a_shaft_hold_each_other_with_equal_force(train: GearTrain) -> None:
    # Without supports a shaft twists by w·q: the acceleration of each end over its share of the twist, times its
    # inertia, is the same force; and a turn of both that leaves the shaft untwisted pulls at neither (action and
    # reaction).
    kind = train.with_shaft(SHAFT)
    gears = [replace(g, torsional_stiffness=0.0) for g in kind.gears]
    meshes = [replace(m, driver=a, driven=b) for m, a, b in zip(kind.meshes, gears[::2], gears[1::2], strict=True)]
    ready = made_ready(replace(kind, meshes=(meshes[0], meshes[1])), random_states(train, 0, 1), 0.5, 0.0, 2)
    table, _ = rows(ready.structure, [(ready, np.array([0]))])
    value = {name: table[index, 0] for name, index in ready.structure.row.items()}
    (w2, w3), (g2, g3) = ready.reduced.shaft_weight, ready.reduced.shaft_gain
    for kind_of_row in "QV":
        own, far = value[f"E3_OF_{kind_of_row}3"], value[f"E3_OF_{kind_of_row}5"]
        assert own * w3 == pytest.approx(far * w2, rel=1e-12)  # untwisted: q3 = w3, q5 = -w2
        assert value[f"E5_OF_{kind_of_row}3"] * g2 == pytest.approx(own * g3, rel=1e-12)
        assert value[f"E5_OF_{kind_of_row}5"] * g2 == pytest.approx(far * g3, rel=1e-12)
        assert own < 0


def test_an_undamped_oscillator_steps_by_the_stability_polynomial(train: GearTrain) -> None:
    # Classical Runge-Kutta turns exp(iz) into 1 + iz − z²/2 − iz³/6 + z⁴/24 (Hairer & Wanner 1996, IV.2). Without
    # mesh forces u1 is such an oscillator, seen from Q and V in half steps: z = 2·sqrt(k).
    gears = [replace(g, support_damping_ratio=0.0, torsional_damping_ratio=0.0) for g in train.gears]
    meshes = [replace(m, driver=a, driven=b) for m, a, b in zip(train.meshes, gears[::2], gears[1::2], strict=True)]
    ready = made_ready(replace(train, meshes=(meshes[0], meshes[1])), random_states(train, 0, 1), 0.5, 0.0, 1)
    table, half_step = rows(ready.structure, [(ready, np.array([0]))])
    z = 2 * half_step[0] * np.sqrt(ready.reduced.stiffness[1])
    row = ready.structure.row
    cosine, sine = 1 - z**2 / 2 + z**4 / 24, z - z**3 / 6
    assert 1 + table[row["Q1_OF_Q1"], 0] == pytest.approx(cosine, rel=1e-15)
    assert 1 + table[row["V1_OF_V1"], 0] == pytest.approx(cosine, rel=1e-15)
    assert 2 + table[row["Q1_OF_V1"], 0] == pytest.approx(2 * sine / z, rel=1e-15)
    assert table[row["V1_OF_Q1"], 0] == pytest.approx(-z / 2 * sine, rel=1e-14)
