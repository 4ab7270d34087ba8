"""Order spectrum: mesh force over the shaft angle of s1, so that a drive whose speed moves still gives sharp lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import welch

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.plotting import Plottable

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class OrderSpectrum(Plottable, figure="order_spectrum:plot_spectrum", table="motions:order_spectrum_table"):
    """Amplitudes of a mesh force by order of the shaft s1."""

    orders: Array
    """Events per revolution of s1, shape (n,), from 0."""
    amplitude: Array
    """Peak amplitude of a line at each order, N, shape (n,); the mean is taken out."""
    segments: int
    """Segments that were averaged."""

    def line(self, order: float) -> float:
        """Return the amplitude at the order nearest to `order`, N."""
        return float(self.amplitude[int(np.abs(self.orders - order).argmin())])


def order_spectrum(
    angle: Array, force: Array, *, highest: float, revolutions: int = 8, minimum_segments: int = 3
) -> OrderSpectrum:
    """Return the order spectrum of `force` (n,), N, known at shaft angles `angle` (n,), rad, strictly monotonic.

    Computed order tracking (Fyfe & Munck 1997): the force is resampled to equal steps of angle by a cubic spline, then
    averaged over segments of `revolutions` by Welch's method (1967; Hann window, half overlap), so lines are
    1/`revolutions` apart. `highest` is the highest order wanted. Raises ValueError where the record has less than
    `minimum_segments` segments, samples are fewer than `highest` needs, or the angle does not move one way.

    Limits: lines between two bins lose up to 15 % to the window; what lies above half the record's own sampling rate
    folds back, so sample densely.
    """
    turned = np.abs(angle - angle[0]) if len(angle) else angle
    if len(angle) != len(force) or len(angle) < 4 or not (np.diff(turned) > 0).all():
        raise ValueError(
            f"Got {len(angle)} angles and {len(force)} forces, expected as many and an angle moving one way."
        )
    if not np.isfinite(force).all():
        raise ValueError("The force holds numbers that are not finite; leave them out.")
    whole = float(turned[-1]) / (2 * np.pi)
    if whole < revolutions * (minimum_segments + 1) / 2:
        raise ValueError(
            f"The record turns {whole:.1f} times, expected at least {revolutions * (minimum_segments + 1) / 2:g}: "
            f"take a longer one or shorter segments."
        )
    if (len(angle) - 1) / whole < 2 * highest:
        raise ValueError(f"The record has {len(angle) / whole:.0f} samples a turn, expected {2 * highest:g} at least.")
    # As dense as the record: a coarser grid would fold what it holds above `highest` back below it.
    per_turn = int(np.ceil((len(angle) - 1) / whole))
    even = np.arange(int(whole * per_turn)) * (2 * np.pi / per_turn)
    resampled = CubicSpline(turned, force)(even)
    size = revolutions * per_turn
    orders, power = welch(resampled, per_turn, "hann", size, size // 2, detrend="constant", scaling="spectrum")
    kept = orders <= highest * (1 + 1e-9)
    segments = (len(even) - size) // (size - size // 2) + 1
    return OrderSpectrum(orders[kept], np.sqrt(2 * power[kept]), segments)


def mesh_orders(train: GearTrain, highest: float) -> dict[str, Array]:
    """Return the orders of s1 at which each mesh is excited, up to `highest`: whole multiples of teeth that pass.

    s1_s2 passes z1 teeth in a turn of s1; s3_s4, on the shaft of s2, z1·z3/z2.
    """
    s1, s2, s3, _ = train.gears
    firsts = {"s1_s2": float(s1.teeth), "s3_s4": s1.teeth * s3.teeth / s2.teeth}
    return {name: first * np.arange(1.0, int(highest / first) + 1.0) for name, first in firsts.items()}
