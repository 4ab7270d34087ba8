"""The march in vectors against the same steps one number after the other, to the last bit."""

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain, Variant
from seat_gear_dynamics.motion import Inputs, March, kernel
from seat_gear_dynamics.motion.march import DivergedError

Array = NDArray[np.float64]
MakeTrain = Callable[..., GearTrain]

SHAFT = 2.6e4
KINDS = list(product((0.0, SHAFT), (0.0, 20.0), (True, False), (True, False)))
# Steady, on a finer grid, creeping, and through standstill into reverse; a light load rattles.
DRIVES = [
    (Inputs(1.3, 20.0), Inputs(1.3, 20.0), 15.0),
    (Inputs(0.04, 300.0), Inputs(0.05, -80.0), 15.0),
    (Inputs(0.001, 0.0), Inputs(0.002, 10.0), 20.0),
    (Inputs(0.8, 600.0), Inputs(-0.6, 600.0), 15.0),
]


class Plain:
    """A march by NumPy and `kernel._rates`: the Runge-Kutta formula as it is written, stage after stage."""

    def __init__(self, march: March) -> None:
        self.eq, self.grid = march._equations, march._grid
        self.y, self.z, self.growth = march._y.copy(), march._z.copy(), march._growth.copy()
        self.clock, self.place = march._clock.copy(), march._place.copy()
        self.window = np.zeros((2, 6))
        self.window[:, 3], self.window[:, 4] = np.inf, -np.inf
        self.sections: list[list[float]] = []

    def rates(self, y: Array, z: Array, level: int, half: int, rate: float, load: float) -> tuple[Array, Array, Array]:
        row, dy, dz, mesh = np.empty((2, 3)), np.empty(24), np.empty(24), np.empty((2, 4))
        kernel.look_up(row, self.grid, level, half)
        kernel._rates(y, z, row, rate, load, self.eq, dy, dz, mesh)
        return dy, dz, mesh

    def advance(self, first: Inputs, last: Inputs, end: float) -> None:
        slope, load_slope = (last.frequency - first.frequency) / end, (last.load - first.load) / end
        while self.clock[0] < end:
            tau = float(self.clock[0])
            self.step(first.frequency + slope * tau, first.load + load_slope * tau)

    def step(self, frequency: float, load: float) -> None:
        finest = self.grid.levels - 1
        level, h, rate, moved = kernel.plan(frequency, self.clock, self.place, self.grid)
        half = 2 * (int(self.place[0]) >> (finest - level))
        toward = 0 if rate == 0.0 else (1 if moved > 0 else -1)
        y, z = self.y, self.z
        k1, j1, mesh = self.rates(y, z, level, half, rate, load)
        self.count(mesh, h)
        k2, j2, _ = self.rates(y + 0.5 * h * k1, z + 0.5 * h * j1, level, half + toward, rate, load)
        k3, j3, _ = self.rates(y + 0.5 * h * k2, z + 0.5 * h * j2, level, half + toward, rate, load)
        k4, j4, _ = self.rates(y + h * k3, z + h * j3, level, half + 2 * toward, rate, load)
        self.y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        self.z = z + h / 6 * (j1 + 2 * j2 + 2 * j3 + j4)
        self.clock[0] += h
        self.place[0] = (self.place[0] + moved) % self.grid.cycle
        self.place[1] += 1
        at_section = moved != 0 and self.place[0] % (self.grid.base << finest) == 0
        if at_section or self.place[1] >= kernel.RENORMALISE:
            self.place[1] = 0
            kernel.renormalise(self.z, self.growth, self.eq.coupled)
        if at_section:
            _, _, mesh = self.rates(self.y, self.z, level, 2 * (int(self.place[0]) >> (finest - level)), rate, load)
            self.sections.append([float(self.clock[0]), *mesh[0, :2].tolist(), *self.growth.tolist()])
            self.growth[:] = 0.0

    def count(self, mesh: Array, h: float) -> None:
        for window, (_, _, force, contact) in zip(self.window, mesh.tolist(), strict=True):
            window[:3] += [h, h * force, h * force * force]
            window[3], window[4] = min(window[3], force), max(window[4], force)
            window[5] += h * (1.0 - contact)

    @property
    def whole(self) -> Array:
        return np.concatenate([self.y, self.z, self.clock, self.place, self.growth])


def assert_same_bits(train: GearTrain, drive: tuple[Inputs, Inputs, float], state: Array | None = None) -> None:
    first, last, end = drive
    march = March(train, load=first.load)
    if state is not None:
        march.state = state
    plain, sections = Plain(march), list[Array]()
    windows = march.advance((0.0, first), (end, last), sections.append)
    plain.advance(first, last, end)
    assert march.whole.tobytes() == plain.whole.tobytes()
    assert [list(vars(window).values()) for window in windows] == plain.window.tolist()
    assert np.concatenate([np.empty((0, 5)), *sections]).tolist() == plain.sections


@pytest.mark.parametrize("drive", DRIVES, ids=str)
@pytest.mark.parametrize(("shaft", "eccentricity", "torsion", "contact_only"), KINDS)
def test_every_kind_of_train_marches_as_its_equations_read(
    make_train: MakeTrain,
    shaft: float,
    eccentricity: float,
    torsion: bool,
    contact_only: bool,
    drive: tuple[Inputs, Inputs, float],
) -> None:
    described = make_train({"gears.*.eccentricity": eccentricity, "gears.s3.eccentricity_phase": 1.0})
    train = replace(described, variant=Variant(torsion, contact_only)).with_shaft(shaft)
    assert_same_bits(train, drive)


@given(state=st.lists(st.floats(-3, 3), min_size=24, max_size=24), shaft=st.sampled_from([0.0, SHAFT]))
@settings(max_examples=20)
def test_every_state_steps_as_its_equations_read(train: GearTrain, state: list[float], shaft: float) -> None:
    assert_same_bits(train.with_shaft(shaft), (Inputs(0.9, 100.0), Inputs(0.9, 100.0), 0.4), np.array(state))


@pytest.mark.parametrize("lost", [np.nan, np.inf, 1e9])
def test_a_motion_out_of_bounds_stops_before_its_step(train: GearTrain, lost: float) -> None:
    march, inputs = March(train, load=100.0), Inputs(0.9, 100.0)
    march.advance((0.0, inputs), (1.0, inputs))
    spoilt = march.state
    spoilt[2] = lost
    march.state = spoilt
    tau = march.tau
    with pytest.raises(DivergedError):
        march.advance((tau, inputs), (tau + 1.0, inputs))
    assert march.tau == tau
    assert march.state.tobytes() == spoilt.tobytes()


def test_a_tangent_that_is_no_number_starts_anew_and_touches_no_motion(train: GearTrain) -> None:
    sound, spoilt, inputs = March(train, load=100.0), March(train, load=100.0), Inputs(0.9, 100.0)
    spoilt._z[:6] = np.nan
    sections: list[Array] = []
    for march in (sound, spoilt):
        march.advance((0.0, inputs), (15.0, inputs), sections.append)
    assert spoilt.state.tobytes() == sound.state.tobytes()
    assert np.isfinite(sections[1][:, 4]).all()
    assert sections[1][:, 4].tolist() == sections[0][:, 4].tolist()
