"""What the virtual sensor returns: forces over a window, contact now, section points and regime, in SI units."""

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.motion import Window
from seat_gear_dynamics.regimes import Regime

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ForceWindow:
    """Statistics of one mesh force over a stretch of time; merge windows to get those of a longer stretch."""

    duration: float = 0.0
    """s"""
    integral: float = 0.0
    """Of the force, N·s."""
    square_integral: float = 0.0
    """Of the squared force, N²·s."""
    min: float = inf
    """N; infinity for an empty window."""
    max: float = -inf
    """N; minus infinity for an empty window."""
    separated: float = 0.0
    """Time out of contact, s."""

    @classmethod
    def from_dimensionless(cls, window: Window, force_unit: float, time_scale: float) -> "ForceWindow":
        """Return a dimensionless window in newtons and seconds."""
        return cls(
            window.duration / time_scale,
            window.sum * force_unit / time_scale,
            window.sum_of_squares * force_unit**2 / time_scale,
            window.minimum * force_unit,
            window.maximum * force_unit,
            window.separated / time_scale,
        )

    @property
    def mean(self) -> float:
        """Time mean, N; NaN for an empty window."""
        return self.integral / self.duration if self.duration else float("nan")

    @property
    def rms(self) -> float:
        """Root mean square, N; NaN for an empty window."""
        return sqrt(self.square_integral / self.duration) if self.duration else float("nan")

    @property
    def contact_loss(self) -> float:
        """Share of the time out of contact, 0 to 1; NaN for an empty window."""
        return self.separated / self.duration if self.duration else float("nan")

    def merged(self, later: "ForceWindow") -> "ForceWindow":
        """Return the statistics of this window followed by `later`."""
        return ForceWindow(
            self.duration + later.duration,
            self.integral + later.integral,
            self.square_integral + later.square_integral,
            min(self.min, later.min),
            max(self.max, later.max),
            self.separated + later.separated,
        )


@dataclass(frozen=True)
class Contact:
    """One mesh at a moment."""

    deflection: float
    """δ along the line of action, m; contact beyond half the backlash."""
    rate: float
    """dδ/dt, m/s."""
    force: float
    """Mesh force, N."""


@dataclass(frozen=True)
class Accepted:
    """A sample that the virtual sensor takes, and what is known of the motion before the model is moved to it."""

    t: float
    """Time of the sample, s."""
    speed: float
    """rad/s of s1"""
    load: float
    """T4, N·m"""
    event: str
    """As of a `Reading`; that the solution diverges is known only afterwards."""
    regime: Regime
    """Of P12 up to the sample before; undecided where the drive has left the one it was judged at."""


@dataclass(frozen=True)
class Reading:
    """What the virtual sensor says after a sample."""

    t: float
    """Time of the sample, s."""
    speed: float
    """rad/s of s1"""
    load: float
    """T4, N·m"""
    event: str
    """`running`, `started`, or why the model restarted: `gap`, `clock stepped back`, `diverged`."""
    windows: tuple[ForceWindow, ForceWindow]
    """Mesh forces of P12 and P34 since the sample before."""
    contacts: tuple[Contact, Contact]
    """P12 and P34 now."""
    section: Array
    """Section points of P12 since the sample before, shape (n, 3): δ/b_c, dimensionless rate, t in s."""
    regime: Regime
    """Of P12 since the drive has been steady."""
