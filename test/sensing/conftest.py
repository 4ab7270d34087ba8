"""Regimes, bands and drives for the tests of the sensor and the alarm."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from seat_gear_dynamics.gears import ForbiddenBand, GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes import Regime, RegimeMap
from seat_gear_dynamics.regimes.regime_map import NAMES, fingerprint
from seat_gear_dynamics.sensing import Alarm, Verdict


@pytest.fixture(scope="session")
def bands() -> tuple[ForbiddenBand, ...]:
    """The published bands, 1349-1359 and 1589-2060 r/min."""
    return tuple(ForbiddenBand(low * RPM, high * RPM, 600.0) for low, high in ((1349, 1359), (1589, 2060)))


@pytest.fixture(scope="session")
def calm() -> Regime:
    return Regime("periodic", 1, -0.1, 0.01, "recurs after 1")


@pytest.fixture(scope="session")
def chaotic() -> Regime:
    return Regime("chaotic", None, 0.1, 0.01, "exponent 0.1000")


@pytest.fixture
def alarm(bands: tuple[ForbiddenBand, ...]) -> Alarm:
    return Alarm(bands, covered_speed=2101.6 * RPM)


@pytest.fixture(scope="session")
def run(calm: Regime) -> Callable[..., list[Verdict]]:
    """Feed an alarm speeds in r/min, 100 a second from t = `start`; return its verdicts."""

    def feed(
        alarm: Alarm, rpm: Sequence[float], *, regime: Regime = calm, start: float = 0.0, rate: float = 100.0
    ) -> list[Verdict]:
        return [alarm.update(start + n / rate, v * RPM, 600.0, regime) for n, v in enumerate(rpm)]

    return feed


@pytest.fixture(scope="session")
def make_map(train: GearTrain) -> Callable[..., RegimeMap]:
    """Make a map of `train` over 10, 20, … rad/s and 100, 200, … N·m with this chaos, by load."""

    def make(chaos: Sequence[Sequence[float]], *, samples: int = 0, first: float = 10.0) -> RegimeMap:
        p = np.array(chaos, dtype=float)
        codes = np.where(p >= 0.5, NAMES.index("chaotic"), NAMES.index("periodic")).astype(np.int64)
        return RegimeMap(
            speeds=np.array([first + 10.0 * k for k in range(p.shape[1])]),
            loads=100.0 * np.arange(1, p.shape[0] + 1),
            codes=codes,
            period=np.where(p >= 0.5, 0, 1).astype(np.int64),
            lyapunov=p / 10,
            contact_loss=p,
            force_max=100 * p,
            chaos=p,
            samples=samples,
            fingerprint=fingerprint(train),
            transient=1,
            periods=48,
        )

    return make
