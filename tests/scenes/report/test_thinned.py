"""Fine films and long ramps are thinned out; what was asked for is kept."""

import numpy as np
import pytest
from films import film, rectangle

from scenes.report import thinned
from scenes.report.thinned import thin_out
from twin.hot_shape import HotShape, Stop


def heated(*, mesh_mm, states, stops):
    """A film that bends along x in even steps of temperature."""
    sheet = film(rectangle(8.0, 6.0), mesh_mm)
    x, y = sheet.flat_mm.T
    shapes = np.stack([np.column_stack((x, y, share * 0.1 * x * x)) for share in np.linspace(0, 1, states)])
    temperature = np.linspace(25.0, 150.0, states)
    return HotShape(
        film=sheet,
        temperature_c=temperature,
        vertices_mm=shapes,
        stops=tuple(
            Stop(temperature_c=float(temperature[k]), index=k, stable=True, relative_residual=0.0) for k in stops
        ),
        hottest=stops[-1],
        top_mm=shapes[stops[-1]] + (0.0, 0.0, 0.4),
        energy_mj=1.0,
        relative_residual=0.0,
        stable=True,
        lowest_stiffness_n_mm3=1.0,
        tapped_away_at_c=(),
        snaps=(),
        newton_iterations=1,
        device="cpu",
        wall_s=0.0,
    )


def test_a_usual_film_is_kept_whole():
    shape = heated(mesh_mm=1.0, states=9, stops=(8,))
    kept = thin_out(shape)
    assert np.array_equal(kept.vertices_mm, shape.vertices_mm)
    assert np.array_equal(kept.triangles, shape.film.triangles)
    assert kept.hottest == 8


def test_of_a_long_ramp_the_stops_are_kept(monkeypatch):
    monkeypatch.setattr(thinned, "MOST_STATES", 5)
    shape = heated(mesh_mm=2.0, states=101, stops=(37, 98))
    kept = thin_out(shape)
    assert kept.temperature_c == pytest.approx([25.0, 56.25, 71.25, 87.5, 118.75, 147.5, 150.0])
    assert np.array_equal(kept.vertices_mm[kept.hottest], shape.hot_mm)


def test_of_a_fine_mesh_vertices_of_its_own_are_kept(monkeypatch):
    monkeypatch.setattr(thinned, "MOST_TRIANGLES", 150)
    shape = heated(mesh_mm=0.25, states=3, stops=(2,))
    kept = thin_out(shape)
    assert 100 < len(kept.triangles) < 220
    assert kept.triangles.max() == kept.vertices_mm.shape[1] - 1
    x, y, z = kept.vertices_mm[-1].T
    assert z == pytest.approx(0.1 * x * x)
    corners = np.column_stack((x, y))[kept.triangles]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    assert (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2 == pytest.approx(48.0, rel=0.03)
    assert kept.top_mm[:, 2] == pytest.approx(z + 0.4)
