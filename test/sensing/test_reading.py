"""Force windows in SI units."""

from dataclasses import astuple
from math import isnan, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.motion import Window
from seat_gear_dynamics.sensing import ForceWindow

windows = st.builds(
    lambda duration, force: ForceWindow(duration, duration * force, duration * force**2, force, force, 0.0),
    st.floats(0.001, 10),
    st.floats(-1000, 1000),
)


@given(windows, windows, windows)
def test_merging_does_not_depend_on_how_windows_are_grouped(a: ForceWindow, b: ForceWindow, c: ForceWindow) -> None:
    assert astuple(a.merged(b).merged(c)) == pytest.approx(astuple(a.merged(b.merged(c))), rel=1e-9, abs=1e-9)


@given(windows, windows)
def test_the_mean_of_merged_windows_is_weighted_by_time_and_lies_between_the_extremes(
    a: ForceWindow, b: ForceWindow
) -> None:
    both = a.merged(b)
    weighted = (a.mean * a.duration + b.mean * b.duration) / (a.duration + b.duration)
    assert both.mean == pytest.approx(weighted, rel=1e-9, abs=1e-9)
    assert both.min - 1e-9 <= both.mean <= both.max + 1e-9
    assert both.rms >= abs(both.mean) * (1 - 1e-9) - 1e-9


@given(windows)
def test_an_empty_window_changes_nothing(window: ForceWindow) -> None:
    assert window.merged(ForceWindow()) == window == ForceWindow().merged(window)


def test_an_empty_window_has_no_mean() -> None:
    assert all(isnan(v) for v in (ForceWindow().mean, ForceWindow().rms, ForceWindow().contact_loss))


def test_dimensionless_windows_become_newtons_and_seconds() -> None:
    window = ForceWindow.from_dimensionless(Window(20.0, 6.0, 8.0, -0.5, 2.0, 5.0), force_unit=1000.0, time_scale=10.0)
    assert window.duration == 2.0
    assert window.mean == pytest.approx(300.0)
    assert window.rms == pytest.approx(1000 * sqrt(8 / 20))
    assert (window.min, window.max) == (-500.0, 2000.0)
    assert (window.separated, window.contact_loss) == (0.5, 0.25)
