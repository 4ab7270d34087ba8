"""Periodic excitation over the mesh phase: truncated Fourier series, and transmission error built from harmonics."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PeriodicSeries:
    """A real function of period 1: mean + sum of cosine[n]·cos(2π(n+1)p) + sine[n]·sin(2π(n+1)p)."""

    mean: float
    cosine: tuple[float, ...]
    sine: tuple[float, ...]

    def value(self, phase: ArrayLike) -> Array:
        """Return the function at `phase` (any shape, in periods), in its own unit."""
        angle = self._angles(phase)
        varying = np.cos(angle) @ np.asarray(self.cosine) + np.sin(angle) @ np.asarray(self.sine)
        return np.asarray(self.mean + varying)

    def derivative(self, phase: ArrayLike) -> Array:
        """Return the derivative with respect to phase (per period) at `phase`."""
        angle = self._angles(phase)
        order = 2 * np.pi * np.arange(1, len(self.cosine) + 1)
        rate = np.cos(angle) @ (order * np.asarray(self.sine))
        rate -= np.sin(angle) @ (order * np.asarray(self.cosine))
        return np.asarray(rate)

    def scaled(self, factor: float) -> "PeriodicSeries":
        """Return the series multiplied by `factor`."""
        return PeriodicSeries(
            self.mean * factor,
            tuple(c * factor for c in self.cosine),
            tuple(s * factor for s in self.sine),
        )

    def _angles(self, phase: ArrayLike) -> Array:
        orders = np.arange(1, len(self.cosine) + 1)
        return np.asarray(2 * np.pi * np.multiply.outer(np.asarray(phase, dtype=float), orders))


def fourier_series(samples: Array, harmonics: int) -> PeriodicSeries:
    """Return the first `harmonics` harmonics of a function sampled at equal steps over one period.

    `samples` has shape (n,), n > 2·harmonics; the coefficients are those of the discrete Fourier transform.
    """
    if len(samples) <= 2 * harmonics:
        raise ValueError(f"{harmonics} harmonics need more than {2 * harmonics} samples, found {len(samples)}.")
    spectrum = np.fft.rfft(samples) / len(samples)
    kept = spectrum[1 : harmonics + 1]
    return PeriodicSeries(
        float(spectrum[0].real),
        tuple(float(c) for c in 2 * kept.real),
        tuple(float(s) for s in -2 * kept.imag),
    )


@dataclass(frozen=True)
class TransmissionErrorHarmonic:
    """One harmonic of e(p): amplitude·sin(2π·order·p + phase)."""

    order: int
    amplitude: float
    """m"""
    phase: float
    """rad"""


def error_series(harmonics: Sequence[TransmissionErrorHarmonic]) -> PeriodicSeries:
    """Return e(p), m, as the sum of `harmonics`; an empty sequence gives a zero error."""
    highest = max((h.order for h in harmonics), default=1)
    cosine, sine = np.zeros(highest), np.zeros(highest)
    for h in harmonics:
        cosine[h.order - 1] += h.amplitude * np.sin(h.phase)
        sine[h.order - 1] += h.amplitude * np.cos(h.phase)
    return PeriodicSeries(0.0, tuple(map(float, cosine)), tuple(map(float, sine)))
