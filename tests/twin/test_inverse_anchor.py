"""The anchor: what ties a design to its target beside the shape itself."""

import numpy as np
import pytest

from twin.inverse.anchor import OVERBENDING, Anchor

THICKNESS_MM = np.full(4, 0.2)
AREA_MM2 = np.array([0.5, 0.7, 0.9])
ALIGNMENT = np.random.default_rng(0).normal(0.0, 0.08, (4, 3, 2))
FORMS = np.column_stack(
    (
        1.0 + np.random.default_rng(1).normal(0.0, 0.1, 3),
        np.random.default_rng(2).normal(0.0, 0.05, 3),
        1.0 + np.random.default_rng(3).normal(0.0, 0.1, 3),
        np.random.default_rng(4).normal(0.0, 0.05, (3, 3)),
    )
)
FLAT_FORMS = np.tile([1.0, 0.0, 1.0, 0.0, 0.0, 0.0], (3, 1))
NO_CONTRACTION = np.full(ALIGNMENT.shape, 1e-9)


def anchor(forms=FORMS, *, metric=1.0):
    return Anchor(forms, AREA_MM2, THICKNESS_MM, 1.0, metric=metric)


@pytest.mark.parametrize("metric", [1.0, 0.1])
def test_gradient_is_that_of_differences(metric):
    one = anchor(metric=metric)
    change = np.random.default_rng(5).normal(size=ALIGNMENT.shape)
    step = 1e-6
    difference = (one.value(ALIGNMENT + step * change)[0] - one.value(ALIGNMENT - step * change)[0]) / (2.0 * step)
    assert float((one.value(ALIGNMENT)[1] * change).sum()) == pytest.approx(difference, rel=1e-6)


def test_split_energy_is_the_energy_for_small_differences():
    """Of films without contraction, whose natural forms are the flat film's."""
    for scale, off in ((1e-2, 0.05), (1e-3, 0.005)):
        forms = FLAT_FORMS + scale * np.random.default_rng(6).normal(size=(3, 6))
        whole, split = (
            anchor(forms).value(NO_CONTRACTION)[0],
            anchor(forms, metric=1.0 - 1e-12).value(NO_CONTRACTION)[0],
        )
        assert split == pytest.approx(whole, rel=off)


def test_only_the_metric_loses_weight():
    stretched, bent = FLAT_FORMS.copy(), FLAT_FORMS.copy()
    stretched[:, 0] += 1e-3
    bent[:, 3] += 1e-3 / OVERBENDING
    assert anchor(stretched, metric=0.1).value(NO_CONTRACTION)[0] == pytest.approx(
        0.1 * anchor(stretched).value(NO_CONTRACTION)[0], rel=0.01
    )
    assert anchor(bent, metric=0.1).value(NO_CONTRACTION)[0] == pytest.approx(
        anchor(bent).value(NO_CONTRACTION)[0], rel=0.01
    )


@pytest.mark.parametrize("metric", [1.0, 0.1])
def test_curvature_is_the_second_derivative_where_the_stress_vanishes(metric):
    """At a film without contraction on its own flat forms the square of the first derivative is all there is.

    All layers change alike: where they differ the energy has a part that no forms could take up.
    """
    one = anchor(FLAT_FORMS, metric=metric)
    rest = np.full(ALIGNMENT.shape, 1e-5)
    change = np.broadcast_to(np.random.default_rng(7).normal(size=(3, 2)), ALIGNMENT.shape)
    one.linearise(rest)
    step = 1e-3
    value = one.value(rest + step * change)[0]
    assert 0.5 * step**2 * float((one.curve(change) * change).sum()) == pytest.approx(value, rel=0.05)
