"""Regimes, bands and drives for the tests of the sensor and the alarm."""

from collections.abc import Callable, Sequence

import pytest

from seat_gear_dynamics.gears import ForbiddenBand
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.regimes import Regime
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
