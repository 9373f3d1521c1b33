import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.calibration import (
    contraction_for_radius,
    radius_for_contraction,
    skin_depth_mm,
    skin_radius_mm,
    wide_stack,
    wide_strip,
)

PAPER = (0.2, 0.2, 0.2, 0.2)
THIN = (0.1, 0.1, 0.1, 0.1)
STRONGEST = float(contraction_for_radius(1.8, PAPER, (0, 1)))
RANGE_MM = np.geomspace(1.8, 14.4, 12)
"""Radii of the paper's control range."""


def depth_for_radius(radius_mm):
    return skin_depth_mm(contraction_for_radius(radius_mm, PAPER, (0, 1)), STRONGEST, PAPER, (0, 1))


def test_a_stack_of_equal_strips_is_the_strip() -> None:
    e = np.array([0.05, 0.2, 0.35])
    layers = np.zeros((3, 4))
    layers[:, :2] = e[:, None]
    found = wide_stack(layers, np.tile(PAPER, (3, 1)))
    for one, other in zip(found, wide_strip(e, PAPER, (0, 1)), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)


def test_every_strip_of_a_stack_has_its_own_layers() -> None:
    found = wide_stack(np.array([[0.2, 0.0], [0.2, 0.0], [0.0, 0.0]]), np.array([[0.4, 0.4], [0.1, 0.4], [0.3, 0.3]]))
    for i, layers in enumerate(((0.4, 0.4), (0.1, 0.4))):
        assert found[0][i] == pytest.approx(float(wide_strip(0.2, layers, (0,))[0]))
    assert np.isinf(found[0][2])


def test_a_skin_through_the_whole_layer_is_the_uniform_layer() -> None:
    deep = skin_radius_mm([0.2, 0.3], 0.3, PAPER, (0, 1))
    np.testing.assert_allclose(deep, wide_strip(0.3, PAPER, (0, 1))[0], rtol=1e-12)
    assert np.isinf(skin_radius_mm(0.0, 0.3, PAPER, (0, 1)))


def test_small_strain_is_the_moment_of_the_skins() -> None:
    """The bending of a wide strip is (9 e / H^3) times the first moment of the contracting height, H the film's."""
    e, d = 1e-4, np.array([0.02, 0.05, 0.12])
    convex, concave = skin_radius_mm(d, e, PAPER, (0, 1)), skin_radius_mm(d, e, PAPER, (2, 3))
    np.testing.assert_allclose(1 / convex, 9 * e / 0.8**3 * d * (0.2 + d), rtol=2e-3)
    np.testing.assert_allclose(-1 / concave, 9 * e / 0.8**3 * d * (0.6 - d), rtol=2e-3)


@settings(max_examples=40, deadline=None)
@given(st.floats(1.8, 14.4))
def test_the_calibration_strip_bends_as_calibrated(radius: float) -> None:
    depth = depth_for_radius(radius)
    assert 0.0 < depth <= 0.2 + 1e-12
    assert float(skin_radius_mm(depth, STRONGEST, PAPER, (0, 1))) == pytest.approx(radius, rel=1e-5)


def test_depth_grows_with_contraction_up_to_the_layer() -> None:
    depth = skin_depth_mm(np.linspace(0.0, STRONGEST, 50), STRONGEST, PAPER, (0, 1))
    assert depth[0] == 0.0
    assert np.all(np.diff(depth) > 0.0)
    assert depth[-1] == pytest.approx(0.2)
    assert skin_depth_mm(0.5, STRONGEST, PAPER, (0, 1)) == pytest.approx(0.2)


def test_thin_layers_bend_tightly_with_a_skin_and_freely_without() -> None:
    """The paper: with layers of 0.1 mm all radii were below 3 mm, which left no range to shape with."""
    depth = depth_for_radius(RANGE_MM)
    skin = skin_radius_mm(depth, STRONGEST, THIN, (0, 1))
    through = depth >= 0.1
    assert through.any()
    np.testing.assert_allclose(skin[through], 0.9, rtol=1e-5)
    assert skin_radius_mm(depth_for_radius(12.0), STRONGEST, THIN, (0, 1)) < 3.0
    # the very weakest settings stay above 3 mm, by a little
    assert skin.max() == pytest.approx(3.56, abs=0.02)
    uniform = radius_for_contraction(contraction_for_radius(RANGE_MM, PAPER, (0, 1)), THIN, (0, 1))
    np.testing.assert_allclose(uniform, RANGE_MM / 2, rtol=1e-3)
    assert (uniform > 3.0).sum() >= 5


def test_the_same_setting_curves_more_on_the_concave_side() -> None:
    """Skins of the top layers lie farther from the middle; three times is the limit of thin skins and small strain."""
    radius = np.append(RANGE_MM, 60.0)
    concave = skin_radius_mm(depth_for_radius(radius), STRONGEST, PAPER, (2, 3))
    more = -radius / concave
    assert more[0] == pytest.approx(1.0, rel=1e-6)
    assert np.all(np.diff(more) > 0.0)
    assert more[-2] == pytest.approx(2.56, abs=0.02)
    assert 2.7 < more[-1] < 3.0


def test_a_strip_that_does_not_tell_the_depth_is_refused() -> None:
    with pytest.raises(ValueError, match="does not bend more and more"):
        skin_depth_mm(0.1, 0.3, (0.2, 0.6), (1,))
