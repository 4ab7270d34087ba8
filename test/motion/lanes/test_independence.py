"""A lane's numbers depend on its own inputs alone, to the last bit."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System, integrate, load_system
from seat_gear_dynamics.motion.lanes import WIDTH, LaneResponse, respond_lanes
from seat_gear_dynamics.motion.lanes.reduction import reduced
from seat_gear_dynamics.motion.march import DivergedError

Array = NDArray[np.float64]

SHAFT = 2.6e4


def bits(response: LaneResponse, lane: int) -> bytes:
    parts = response.section, response.growth, response.windows, response.state, response.diverged
    return b"".join(np.ascontiguousarray(part[lane]).tobytes() for part in parts)


def points(count: int, seed: int = 0) -> tuple[Array, Array, Array, Array]:
    """Return frequencies on several levels in both directions, loads, damping ratios and backlashes."""
    rng = np.random.default_rng(seed)
    frequency = rng.choice([-1, 1], count) * rng.uniform(0.11, 2.0, count)
    return frequency, rng.uniform(-50, 400, count), rng.uniform(0.01, 0.15, count), rng.uniform(0, 6e-5, count)


def respond(train: GearTrain, chosen: tuple[Array, ...], threads: int | None = None) -> LaneResponse:
    frequency, load, ratio, backlash = chosen
    return respond_lanes(
        train, frequency, load, damping_ratio=ratio, backlash=backlash, transient=3, periods=2, threads=threads
    )


@pytest.mark.parametrize("shaft", [0.0, SHAFT])
def test_a_lane_alone_is_the_lane_in_company_to_the_last_bit(train: GearTrain, shaft: float) -> None:
    kind, chosen = train.with_shaft(shaft), points(3 * WIDTH + 5)
    together = respond(kind, chosen)
    for lane in range(0, len(chosen[0]), 4):
        alone = respond(kind, tuple(values[lane : lane + 1] for values in chosen))
        assert bits(alone, 0) == bits(together, lane)


def test_every_position_in_a_block_computes_the_same_bits(train: GearTrain) -> None:
    # All lanes alike but for one that moves through the block: any instruction that treats a position differently,
    # such as a scalar remainder of the vector loop, shows.
    same = respond_lanes(train, np.full(WIDTH, 0.93), 30.0, transient=20, periods=5)
    assert len({bits(same, lane) for lane in range(WIDTH)}) == 1
    for place in range(WIDTH):
        load = np.full(WIDTH, 70.0)
        load[place] = 30.0
        mixed = respond_lanes(train, np.full(WIDTH, 0.93), load, transient=20, periods=5)
        assert bits(mixed, place) == bits(same, 0)


@given(st.permutations(range(2 * WIDTH + 3)))
@settings(max_examples=10)
def test_the_order_of_lanes_changes_nothing(train: GearTrain, order: list[int]) -> None:
    chosen = points(2 * WIDTH + 3, seed=1)
    straight, shuffled = respond(train, chosen), respond(train, tuple(values[order] for values in chosen))
    for lane, was in enumerate(order):
        assert bits(shuffled, lane) == bits(straight, was)


@pytest.mark.parametrize("shaft", [0.0, SHAFT])
@pytest.mark.parametrize("threads", [2, 3, 8, None])
def test_threads_change_nothing(train: GearTrain, threads: int | None, shaft: float) -> None:
    kind, chosen = train.with_shaft(shaft), points(5 * WIDTH + 1, seed=2)
    one, many = respond(kind, chosen, threads=1), respond(kind, chosen, threads=threads)
    for lane in range(len(chosen[0])):
        assert bits(one, lane) == bits(many, lane)


# Prints the bits of the odd lanes of a coupled and of a decoupled train, backwards, marched by two threads.
_ELSEWHERE = """
import sys
import numpy as np
from seat_gear_dynamics.motion import load_system
from seat_gear_dynamics.motion.lanes import respond_lanes
frequency, load = np.load(sys.argv[1])
for shaft in (0.0, float(sys.argv[2])):
    found = respond_lanes(load_system().train.with_shaft(shaft), frequency, load, transient=3, periods=2, threads=2)
    parts = found.section, found.growth, found.windows, found.state
    print(b"".join(np.ascontiguousarray(part[::-1]).tobytes() for part in parts).hex())
"""


def test_processes_change_nothing(tmp_path: Path) -> None:
    frequency, load, _, _ = points(3 * WIDTH + 3, seed=3)
    np.save(tmp_path / "points.npy", [frequency[1::2][::-1], load[1::2][::-1]])
    command = [sys.executable, "-c", _ELSEWHERE, str(tmp_path / "points.npy"), str(SHAFT)]
    elsewhere = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    for shaft, bits_elsewhere in zip((0.0, SHAFT), elsewhere, strict=True):
        kind = load_system().train.with_shaft(shaft)
        found = respond_lanes(kind, frequency, load, transient=3, periods=2, threads=1)
        parts = found.section, found.growth, found.windows, found.state
        assert b"".join(np.ascontiguousarray(part[1::2]).tobytes() for part in parts).hex() == bits_elsewhere


def test_tangent_and_statistics_change_no_motion(train: GearTrain) -> None:
    # Other source, so other fusing of products and sums is possible: equal to rounding, not to the bit.
    chosen = 0.7, np.array([200.0, 300.0])
    full = respond_lanes(train, *chosen, transient=10, periods=4)
    bare = respond_lanes(train, *chosen, transient=10, periods=4, tangent=False, statistics=False)
    assert bare.section == pytest.approx(full.section, rel=1e-9, abs=1e-9)
    assert np.isnan(bare.growth).all()
    assert np.isnan(bare.windows).all()
    assert np.isfinite(full.growth).all()


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 1e9])
@pytest.mark.parametrize("transient", [0, 4])
def test_a_lane_out_of_bounds_is_flagged_and_touches_no_neighbour(train: GearTrain, bad: float, transient: int) -> None:
    frequency, load, _, _ = points(WIDTH)
    frequency = np.abs(frequency)
    start = respond_lanes(train, frequency, load, transient=2, periods=1).state
    spoilt = start.copy()
    spoilt[5] = bad
    sound = respond_lanes(train, frequency, load, state=start, transient=transient, periods=3)
    found = respond_lanes(train, frequency, load, state=spoilt, transient=transient, periods=3)
    assert found.diverged.tolist() == [lane == 5 for lane in range(WIDTH)]
    assert not sound.diverged.any()
    assert all(np.isnan(part[5]).all() for part in (found.section, found.growth, found.windows, found.state))
    for lane in set(range(WIDTH)) - {5}:
        assert bits(found, lane) == bits(sound, lane)


def test_a_parametrically_pumped_lane_is_flagged_alone(make_train: Callable[..., GearTrain]) -> None:
    # Without damping and backlash the varying stiffness pumps at twice the natural frequency (Mathieu), here by some
    # per cent a period; off the resonance, or with the mesh damped, the motion stays bounded.
    train = make_train({"*damping_ratio": 0, "meshes.*.stiffness_harmonics": 1})
    r = reduced(train)
    natural = np.sqrt(np.linalg.eigvals(np.diag(r.stiffness[:4]) + np.tile(r.gain[:4, None], 4)).real.max())
    frequency, ratio = 2 * natural * np.array([0.8, 1.0, 1.0, 1.2]), np.array([0.0, 0.0, 0.5, 0.0])
    found = respond_lanes(
        train, frequency, 100.0, damping_ratio=ratio, backlash=0.0, transient=1000, periods=1, tangent=False
    )
    assert found.diverged.tolist() == [False, True, False, False]
    assert np.isfinite(found.section[~found.diverged]).all()
    with pytest.raises(DivergedError):
        integrate(System(train.with_mesh(0, backlash=0.0)).at(frequency=float(frequency[1]), load=100.0), periods=1)
