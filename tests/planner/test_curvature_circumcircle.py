import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.curvature import signed_curvature


def curvature(p2: tuple[float, float], p3: tuple[float, float]) -> float:
    (back, rise_back), (ahead, rise_ahead) = p2, p3
    return float(signed_curvature(*(np.array(v) for v in (back, rise_back, ahead, rise_ahead))))


def heron_curvature(p2: tuple[float, float], p3: tuple[float, float]) -> float:
    """Eq. 1-3 of the paper as printed, without the sign."""
    (back, rise_back), (ahead, rise_ahead) = p2, p3
    l1, l2 = np.hypot(back, rise_back), np.hypot(ahead, rise_ahead)
    l3 = np.hypot(back + ahead, rise_ahead - rise_back)
    half = (l1 + l2 + l3) / 2
    return float(4 * np.sqrt(half * (half - l1) * (half - l2) * (half - l3)) / (l1 * l2 * l3))


def test_right_angle_below_the_point() -> None:
    # P2 = (-1, -1), P1 = (0, 0), P3 = (1, -1): half a circle of radius 1.
    assert curvature((1, -1), (1, -1)) == pytest.approx(1.0)


def test_concave_is_negative() -> None:
    assert curvature((1, 1), (1, 1)) == pytest.approx(-1.0)


@pytest.mark.parametrize("slope", [0.0, 0.7, -3.0])
def test_straight_line_has_none(slope: float) -> None:
    assert curvature((2.0, -2.0 * slope), (1.5, 1.5 * slope)) == pytest.approx(0.0, abs=1e-15)


def test_nearly_straight_keeps_its_digits() -> None:
    radius = 1e7
    fall = -(2.0**2) / (2 * radius)
    assert curvature((2.0, fall), (2.0, fall)) == pytest.approx(1 / radius, rel=1e-6)


@given(back=st.floats(0.2, 4), ahead=st.floats(0.2, 4), rise_back=st.floats(-4, 4), rise_ahead=st.floats(-4, 4))
def test_agrees_with_the_printed_equations(back: float, ahead: float, rise_back: float, rise_ahead: float) -> None:
    ours = curvature((back, rise_back), (ahead, rise_ahead))
    printed = heron_curvature((back, rise_back), (ahead, rise_ahead))
    assert abs(ours) == pytest.approx(printed, abs=1e-6)
    above_chord = -(ahead * rise_back + back * rise_ahead)
    assert ours * above_chord >= 0


@given(start=st.floats(-1.2, 1.2), back=st.floats(0.05, 0.3), ahead=st.floats(0.05, 0.3))
def test_any_three_points_of_a_circle(start: float, back: float, ahead: float) -> None:
    radius = 7.0
    x, z = radius * np.sin(start), radius * np.cos(start)
    p2 = x - radius * np.sin(start - back), radius * np.cos(start - back) - z
    p3 = radius * np.sin(start + ahead) - x, radius * np.cos(start + ahead) - z
    assert curvature(p2, p3) == pytest.approx(1 / radius, rel=1e-6)
