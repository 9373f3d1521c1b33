import json
from pathlib import Path

import numpy as np
import pytest
import shapely

from planner.calibration import contraction_for_radius, load_calibration
from planner.errors import InputError
from planner.plan import Plan, plan, plan_summary
from planner.program import load_program, save_program
from planner.target import Target, load_target, target_from_heights
from planner.toolpaths import swept_area
from planner.toolpaths.cut_line import cut_line

ALL_BUT_LAST, REST = slice(None, -1), slice(1, None)


def surface(height: str) -> Target:
    """Small targets: a cap of radius 20 mm, a bowl of the same, a ridge of radius 13 mm, a slope."""
    half = 12 if height in ("cap", "bowl") else 7
    axis = np.arange(-half, half + 0.01, 0.25)
    x, y = np.meshgrid(axis, axis)
    radius = np.hypot(x, y)
    cap = np.sqrt(400 - np.minimum(radius, 12) ** 2)
    z = {"cap": cap, "bowl": 40 - cap, "ridge": np.sqrt(169 - x**2), "slope": 0.3 * x}[height]
    inside = radius <= 12.01 if height in ("cap", "bowl") else np.ones_like(x, dtype=bool)
    return target_from_heights(name=height, x_mm=axis, y_mm=axis, z_mm=np.where(inside, z, np.nan))


@pytest.fixture(scope="module")
def cap() -> Plan:
    return plan(surface("cap"), seed=3)


def test_a_cap_is_scratched_in_rings_in_the_bottom_half(cap: Plan) -> None:
    bottom, second, third, top = (layer.passes for layer in cap.program.layers)
    assert bottom == second
    assert len(bottom) > 10
    assert third == top == ()
    assert {stroke.side for stroke in bottom} == {"convex"}
    begin, end = (
        np.concatenate([np.array(stroke.points_mm)[cut] for stroke in bottom]) for cut in (ALL_BUT_LAST, REST)
    )
    middle, along = (begin + end) / 2, end - begin
    distance = np.linalg.norm(middle, axis=1)
    radial = np.abs((middle * along).sum(axis=1)) / distance / np.linalg.norm(along, axis=1)
    assert np.mean(radial[distance > 3]) < 0.1


def test_a_bowl_is_scratched_in_the_top_half() -> None:
    layers = plan(surface("bowl")).program.layers
    assert layers[0].passes == layers[1].passes == ()
    assert layers[2].passes == layers[3].passes
    assert {stroke.side for stroke in layers[3].passes} == {"concave"}


def test_a_cap_gets_the_contraction_of_its_contour_lines(cap: Plan) -> None:
    # The circle through points 2 mm away on a contour of radius r is that contour seen from the side: between the
    # cap's radius (at the top) and the contour's own radius.
    radius = 1 / cap.curvature.curvature_per_mm
    assert np.all(radius < 20.5)
    assert cap.clamped_wide_share > 0.05
    assert cap.clamped_tight_share == 0


def test_the_cut_follows_the_patterned_region(cap: Plan) -> None:
    cut = shapely.Polygon(cap.program.cut.line_mm)
    swept = swept_area(cap.program.layers[0].passes, 0.8)
    assert cut.is_valid
    assert cut.intersection(swept).area > 0.985 * swept.area
    assert swept.area > 0.9 * cut.area
    deposited = shapely.Polygon(cap.program.film.outline_mm)
    assert deposited.contains(cut)
    assert deposited.boundary.distance(cut) == pytest.approx(3.0, abs=0.1)


def test_a_margin_widens_the_cut(cap: Plan) -> None:
    wider = plan(surface("cap"), seed=3, margin_mm=2.0)
    inner, outer = (shapely.Polygon(each.program.cut.line_mm) for each in (cap, wider))
    assert outer.boundary.distance(inner) == pytest.approx(2.0, abs=0.05)
    assert wider.program.film.uncut_margin_mm == 2.0


def test_the_same_seed_gives_the_same_program(cap: Plan) -> None:
    assert plan(surface("cap"), seed=3).program.digest == cap.program.digest
    assert plan(surface("cap"), seed=4).program.digest != cap.program.digest


def test_a_ridge_is_scratched_across() -> None:
    result = plan(surface("ridge"), method="maximum")
    steps = np.concatenate([np.diff(np.array(stroke.points_mm), axis=0) for stroke in result.program.layers[0].passes])
    assert np.abs(steps[:, 0]).sum() > 10 * np.abs(steps[:, 1]).sum()
    # Constant radius of 13 mm: every pass promises it.
    calibration = load_calibration()
    for stroke in result.program.layers[0].passes:
        radius = calibration.radius_mm(stroke.load_g[0], np.array(stroke.speed_mm_s))
        np.testing.assert_allclose(radius, 13.0, rtol=0.06)


def test_a_thicker_stack_contracts_more_for_the_same_radius() -> None:
    result = plan(surface("ridge"), method="maximum", layer_thickness_mm=(0.4,) * 4)
    calibration = load_calibration()
    stroke = max(result.program.layers[0].passes, key=lambda stroke: stroke.length_mm)
    given = calibration.contraction(stroke.load_g[0], np.array(stroke.speed_mm_s))
    np.testing.assert_allclose(given, contraction_for_radius(13.0, (0.4,) * 4, (0, 1)), rtol=0.06)
    assert any("layers of 0.2" in note for note in result.notes)


def test_an_odd_stack_keeps_its_middle_polydomain() -> None:
    layers = plan(surface("cap"), layer_thickness_mm=(0.2,) * 5).program.layers
    assert [bool(layer.passes) for layer in layers] == [True, True, False, False, False]


def test_the_summary_is_plain_and_says_placeholder(cap: Plan, tmp_path: Path) -> None:
    summary = json.loads(json.dumps(plan_summary(cap)))
    assert summary["calibration"]["placeholder"] is True
    assert summary["program_digest"] == cap.program.digest
    assert summary["layers"][0]["total_s"] == pytest.approx(cap.layer_times[0].total_s)
    assert any("placeholder" in note for note in summary["notes"])
    save_program(cap.program, tmp_path / "program.json")
    assert load_program(tmp_path) == cap.program


def test_stages_are_reported_in_order() -> None:
    stages: list[tuple[str, float]] = []
    plan(surface("cap"), progress=lambda stage, share: stages.append((stage, share)))
    assert [share for _, share in stages] == sorted(share for _, share in stages)
    assert stages[-1] == ("done", 1.0)


def test_wrong_settings_are_told_together() -> None:
    with pytest.raises(InputError) as caught:
        plan(surface("cap"), layer_thickness_mm=(0.2,), margin_mm=-1, seed=-1)
    assert len(caught.value.problems) == 3


def test_a_slope_gives_no_passes() -> None:
    with pytest.raises(InputError, match="no passes"):
        plan(surface("slope"))


def test_pieces_apart_are_dropped() -> None:
    far = shapely.union(shapely.box(0, 0, 10, 10), shapely.box(20, 0, 22, 2))
    cut = cut_line(far)
    assert cut.lost_pieces == 1
    assert cut.lost_mm2 == pytest.approx(4, rel=0.05)
    assert cut.line_mm[:, 0].max() < 11
    ring = shapely.difference(shapely.Point(0, 0).buffer(10), shapely.Point(0, 0).buffer(5))
    assert cut_line(ring).piece.contains(shapely.Point(0, 0))
    assert cut_line(ring).piece.area == pytest.approx(np.pi * 100, rel=0.02)


@pytest.mark.shared
def test_the_faces_figures_are_those_of_the_paper(shared_dir: Path) -> None:
    result = plan(load_target(shared_dir / "targets" / "ict_mean.npz"))
    # The paper's own face: 3 % below, 41 % above the range, 2700 mm of convex passes in about an hour.
    assert 0.01 < result.clamped_tight_share < 0.08
    assert 0.35 < result.clamped_wide_share < 0.55
    assert 2000 < result.sides["convex"].length_mm < 3200
    assert all(time.total_s < 3600 for time in result.layer_times)
    assert result.problems == ()
