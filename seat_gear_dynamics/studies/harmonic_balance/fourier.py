"""Truncated Fourier series of a motion, and the way between their coefficients and samples in time.

The alternating frequency-time scheme (Cameron & Griffin 1989, J. Appl. Mech. 56, 149-154): a force that is known in
time as a function of the motion is sampled there and taken back to harmonics. Coefficients are real,
(a0, a1 … aH, b1 … bH), of x(φ) = a0 + Σ a_k cos 2πkφ + b_k sin 2πkφ with the phase φ of the motion's own period.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Basis:
    """The harmonics kept and the samples they are weighed on; `samples` must exceed twice `harmonics`.

    A product of three series of H harmonics needs 4·H samples or more to be free of aliasing; a force with corners is
    never free of it, and its error falls with the square of the number of samples.
    """

    harmonics: int
    samples: int

    def __post_init__(self) -> None:
        if self.harmonics < 1 or self.samples <= 2 * self.harmonics:
            raise ValueError(
                f"A Fourier basis of {self.harmonics} harmonics on {self.samples} samples was asked for; expected at "
                f"least 1 harmonic and more than {2 * max(self.harmonics, 1)} samples."
            )

    @property
    def size(self) -> int:
        """Number of real coefficients, 2·H + 1."""
        return 2 * self.harmonics + 1

    @property
    def orders(self) -> Array:
        """0, 1 … H, shape (H + 1,)."""
        return np.arange(self.harmonics + 1, dtype=float)

    @property
    def phases(self) -> Array:
        """Phases of the samples in [0, 1), shape (samples,)."""
        return np.arange(self.samples) / self.samples

    def values(self, coefficients: Array) -> Array:
        """Return the series at the samples, shape (samples,)."""
        spectrum = np.zeros(self.samples // 2 + 1, dtype=complex)
        spectrum[: self.harmonics + 1] = amplitudes(coefficients) * (self.samples / 2)
        spectrum[0] *= 2
        return np.asarray(np.fft.irfft(spectrum, self.samples))

    def coefficients(self, values: Array) -> Array:
        """Return the first harmonics of sampled values, shape (2·H + 1,)."""
        spectrum = np.fft.rfft(values)[: self.harmonics + 1] * (2 / self.samples)
        spectrum[0] /= 2
        return from_amplitudes(spectrum)

    def multiplication(self, factor: Array) -> Array:
        """Return the matrix, (2·H + 1, 2·H + 1), that takes x to the first harmonics of factor(φ)·x(φ).

        `factor` is sampled, (samples,). With the slope of a force law as factor this is the exact derivative of the
        sampled force's harmonics by those of the motion: a Toeplitz and a Hankel part of its discrete spectrum.
        """
        h, spectrum = self.harmonics, np.fft.fft(factor) / self.samples
        row, column = np.arange(h + 1)[:, None], np.arange(h + 1)[None, :]
        lower, upper = spectrum[(row - column) % self.samples], spectrum[(row + column) % self.samples]
        cosine, sine = lower + upper, -1j * (lower - upper)[:, 1:]
        cosine[:, 0] = 2 * spectrum[: h + 1]
        both = np.concatenate([cosine, sine], axis=1)
        both[0] /= 2
        return from_amplitudes(both)

    def resampled(self, coefficients: Array, ratio: int = 1) -> Array:
        """Return coefficients of another basis for this one, each order multiplied by `ratio`; what lies above is cut.

        With ratio 2 a motion is written as one of twice its period.
        """
        source = amplitudes(coefficients)
        kept = np.arange(len(source)) * ratio <= self.harmonics
        target = np.zeros(self.harmonics + 1, dtype=complex)
        target[np.arange(len(source))[kept] * ratio] = source[kept]
        return from_amplitudes(target)


def amplitudes(coefficients: Array) -> Complex:
    """Return A_k of x = Re Σ A_k exp(2πikφ), shape (H + 1, …), of coefficients along the first axis."""
    half = len(coefficients) // 2
    result = np.asarray(coefficients, dtype=complex)[: half + 1].copy()
    result[1:] -= 1j * coefficients[half + 1 :]
    return result


def from_amplitudes(values: Complex) -> Array:
    """Return the real coefficients, (2·H + 1, …), of amplitudes (H + 1, …); an imaginary part of A_0 is dropped."""
    return np.concatenate([values.real, -values.imag[1:]])


def evaluate(coefficients: Array, phase: ArrayLike) -> tuple[Array, Array]:
    """Return the series and its derivative by phase at any phases, both of the phases' shape."""
    orders = np.arange(1, len(coefficients) // 2 + 1)
    angle = 2 * np.pi * np.multiply.outer(np.asarray(phase, dtype=float), orders)
    cosine, sine = np.cos(angle), np.sin(angle)
    a, b = coefficients[1 : len(orders) + 1], coefficients[len(orders) + 1 :]
    value = coefficients[0] + _weighed(cosine, a) + _weighed(sine, b)
    rates = 2 * np.pi * orders
    return value, _weighed(cosine, rates * b) - _weighed(sine, rates * a)


def _weighed(table: Array, weights: Array) -> Array:
    """Return table @ weights without a threaded BLAS, which on tables of this size waits more than it works."""
    return np.asarray(np.einsum("...i,i->...", table, weights))
