"""Order tracking against forces whose orders and amplitudes are known."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import welch

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.logs.analysis.order_spectrum import mesh_orders, order_spectrum

Array = NDArray[np.float64]


def run_up(*, seconds: float = 4.0, rate: float = 20_000.0) -> tuple[Array, Array]:
    """Return time and angle of a drive that speeds up from 10 to 14 revolutions a second."""
    time = np.arange(0, seconds, 1 / rate)
    return time, 2 * np.pi * (10 * time + 0.5 * (4 / seconds) * time**2)


def test_lines_stand_at_their_order_with_their_amplitude_while_the_speed_moves() -> None:
    _, angle = run_up()
    force = 500 + 30 * np.cos(17 * angle) + 4 * np.sin(34 * angle + 0.3)
    found = order_spectrum(angle, force, highest=40)
    # On a bin the Hann window gives a line its amplitude exactly; what is left is the spline's error, (17·2π/1670)⁴.
    assert found.line(17) == pytest.approx(30, rel=1e-3)
    assert found.line(34) == pytest.approx(4, rel=1e-2)
    # Away from the lines a Hann window has fallen to nothing: eight bins off, by 1/8³.
    quiet = (np.abs(found.orders - 17) > 1) & (np.abs(found.orders - 34) > 1) & (found.orders > 1)
    assert found.amplitude[quiet].max() < 30 / 8**3


def test_a_spectrum_over_time_smears_what_the_order_spectrum_shows_sharp() -> None:
    time, angle = run_up()
    force = 30 * np.cos(17 * angle)
    size = 16_000
    _, power = welch(force, 1 / (time[1] - time[0]), "hann", size, scaling="spectrum")
    assert np.sqrt(2 * power.max()) < 15
    assert order_spectrum(angle, force, highest=40).amplitude.max() == pytest.approx(30, rel=1e-3)


def test_what_lies_above_the_highest_order_does_not_fold_back_below_it() -> None:
    _, angle = run_up()
    found = order_spectrum(angle, np.cos(17 * angle) + np.cos(119 * angle), highest=60)
    assert found.orders[-1] == pytest.approx(60)
    assert found.amplitude[np.abs(found.orders - 17) > 1].max() < 1 / 8**3


def test_the_mean_is_taken_out_and_a_turn_backward_is_the_same() -> None:
    _, angle = run_up()
    force = 700 + 30 * np.cos(17 * angle)
    forward, backward = (order_spectrum(a, force, highest=30) for a in (angle, -angle))
    assert forward.line(0) < 1e-6
    np.testing.assert_array_equal(forward.amplitude, backward.amplitude)


def test_a_line_between_two_bins_loses_no_more_than_the_hann_window_takes() -> None:
    _, angle = run_up()
    found = order_spectrum(angle, np.cos((17 + 1 / 16) * angle), highest=30)
    # Scalloping loss of the Hann window half a bin off: 8/(3π) = 0.849 (Harris 1978).
    assert found.amplitude.max() == pytest.approx(8 / (3 * np.pi), rel=1e-2)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda a, f: (a[:3000], f[:3000]), "expected at least 16"),
        (lambda a, f: (a[::40], f[::40]), "samples a turn"),
        (lambda a, f: (np.r_[a[:50], a], np.r_[f[:50], f]), "moving one way"),
        (lambda a, f: (a, f[:-1]), "expected as many"),
        (lambda a, f: (a, np.where(a > 9, np.nan, f)), "not finite"),
        (lambda a, f: (a[:0], f[:0]), "Got 0 angles"),
    ],
)
def test_records_that_cannot_be_tracked_are_refused(
    change: Callable[[Array, Array], tuple[Array, Array]], sentence: str
) -> None:
    _, angle = run_up()
    with pytest.raises(ValueError, match=sentence):
        order_spectrum(*change(angle, np.cos(17 * angle)), highest=30)


def test_mesh_orders_are_the_teeth_that_pass_in_a_turn_of_s1(train: GearTrain) -> None:
    found = mesh_orders(train, 40)
    np.testing.assert_allclose(found["s1_s2"], [17, 34])
    # s3 sits on s2's shaft: 17/40 of a turn, 17 teeth.
    np.testing.assert_allclose(found["s3_s4"], 7.225 * np.arange(1, 6))
