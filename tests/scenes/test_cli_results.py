"""The way through: plan, predict, score of a small dome, and the files that they leave."""

import json
import re
import shutil
from html.parser import HTMLParser

import numpy as np
import pytest
import trimesh
from results import COARSE, names, result_of

from planner.errors import InputError, SolverError
from planner.program import load_program
from planner.target import load_target
from scenes.commands import run_predict
from scenes.noise_flags import NoiseFlags
from scenes.plan_folder import plans_figures
from scenes.predict_flags import HeatingFlags, MaterialFlags, PostFlags, SolverFlags
from twin.predict import predict
from twin.score import Score

SCORES = (
    "ssim_eq4",
    "ssim_eq4_own_scale",
    "ssim_eq4_inside",
    "ssim_gauss",
    "rms_mm",
    "rms_percent_of_diagonal",
    "hausdorff_mm",
    "depth_mm",
    "target_depth_mm",
)
PLAN_FILES = {"program.json", "plan.json", "plan.png", "target.npz", "target.png"}
SCORE_FILES = {"result.json", "scan.npz", "depth_images.png", "error_map.png"}
UNSCORED_FILES = {"result.json", "shape.ply", "heating.npz", "hot_shape.png", "plan.png", "report.html"}
PREDICT_FILES = UNSCORED_FILES | SCORE_FILES | {"target.png"}


def without_times(result):
    return {key: value for key, value in result.items() if not key.endswith("wall_s")}


@pytest.fixture(scope="module")
def predicted(tmp_path_factory, planned):
    """The folder of a full prediction of the small dome; read it, do not write into it."""
    folder = tmp_path_factory.mktemp("predicted") / "hot"
    run_predict(
        planned,
        folder,
        target=None,
        scanner_noise=False,
        heating=HeatingFlags(),
        material=MaterialFlags(),
        post=PostFlags(),
        solver=SolverFlags(mesh_mm=1.5, device="cpu"),
        noise=NoiseFlags(),
    )
    return folder


def test_a_plan_leaves_its_program_figures_pictures_and_target(planned):
    assert names(planned) == PLAN_FILES
    program, target = load_program(planned), load_target(planned / "target.npz")
    figures = json.loads((planned / "plan.json").read_text())
    assert figures["program_digest"] == program.digest
    assert figures["target_sha256"] == program.inputs.target_sha256 == target.digest
    assert figures["calibration"]["placeholder"] is True
    assert len(figures["layers"]) == 4


def test_plan_tells_what_came_out_and_repeats_itself(lce, planned, dome_case, tmp_path, no_pictures):
    ran = lce("plan", dome_case, "--out", tmp_path / "out")
    assert (ran.code, ran.err) == (0, "")
    assert "placeholder" in ran.out
    assert re.search(r"layer 1: \d+ passes, \d+ mm, \d+ min", ran.out)
    assert re.search(r"clamped: \d+% of the points", ran.out)
    again = load_program(tmp_path / "out")
    assert again == load_program(planned)
    other = lce("plan", dome_case, "--seed", "3", "--method", "maximum", "--out", tmp_path / "other")
    assert other.code == 0
    changed = load_program(tmp_path / "other")
    assert again.layers != changed.layers
    assert (changed.seed, changed.inputs.method) == (3, "maximum")


def test_the_result_keeps_the_contract(predicted, planned):
    assert names(predicted) == PREDICT_FILES
    result, program = result_of(predicted), load_program(planned)
    assert set(SCORES) == set(Score.__dataclass_fields__)
    for key in SCORES:
        assert isinstance(result[key], float), key
    assert 0.6 < result["ssim_eq4"] <= 1.0
    assert 0.0 < result["rms_mm"] < result["hausdorff_mm"] < 3.0
    assert 1.0 < result["depth_mm"] < 3.0
    assert result["target_depth_mm"] == pytest.approx(4 * (1 - np.sqrt(1 - 0.81)), abs=0.05)
    diagonal = load_target(planned / "target.npz").diagonal_mm
    assert result["rms_percent_of_diagonal"] == pytest.approx(100 * result["rms_mm"] / diagonal)
    assert result["triangle_count"] > 100
    assert result["newton_iterations"] > 5
    assert result["wall_s"] > result["heating_wall_s"] > 0
    assert result["device"] == result["settings"]["device"] == "cpu"
    assert result["seed"] == 0
    assert result["equilibrium"]["relative_residual"] < 1e-9
    assert result["equilibrium"]["energy_mj"] > 0
    assert result["equilibrium"]["stable"] is True
    assert result["temperature_field"] == "uniform"
    assert result["calibration"] == {"name": "placeholder", "placeholder": True}
    assert result["program_digest"] == program.digest
    assert result["target_digest"] == program.inputs.target_sha256
    assert any("placeholder" in warning for warning in result["warnings"])
    assert result["settings"]["film"]["mesh_mm"] == 1.5


def test_a_series_of_temperatures_is_kept_told_and_drawn(lce, planned, tmp_path):
    out = tmp_path / "hot"
    ran = lce("predict", planned, "--out", out, *COARSE, "--temperatures-c", "25,60,105,60")
    assert ran.code == 0, ran.err
    result = result_of(out)
    assert [stop["temperature_c"] for stop in result["stops"]] == [25.0, 60.0, 105.0, 60.0]
    assert result["temperature_c"] == 105.0
    depth = [stop["depth_mm"] for stop in result["stops"]]
    assert depth[0] < 1e-6
    assert depth[1] < depth[2]
    assert all(stop["stable"] for stop in result["stops"])
    with np.load(out / "heating.npz") as heating:
        assert heating["temperature_c"][heating["stops"]].tolist() == [25.0, 60.0, 105.0, 60.0]
    assert re.search(r"105 C: \d\.\d mm deep, stable", ran.out)
    assert names(out) == PREDICT_FILES | {"temperatures.png"}
    page = (out / "report.html").read_text(encoding="utf-8")
    assert page.count("<img") == 6
    assert "mm deep, stable" in page


class References(HTMLParser):
    """Everything that a page refers to, and its tags."""

    def __init__(self):
        super().__init__()
        self.sources: list[str] = []
        self.tags: list[str] = []
        self.policy = ""

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.sources += [value or "" for key, value in attrs if key in ("src", "href", "srcset", "action", "data")]
        if ("http-equiv", "Content-Security-Policy") in attrs:
            self.policy = dict(attrs)["content"] or ""


def test_the_report_is_one_page_that_needs_nothing_else(predicted):
    page = (predicted / "report.html").read_text(encoding="utf-8")
    found = References()
    found.feed(page)
    assert found.tags.count("img") == 5
    assert all(source.startswith(("data:image/png;base64,", "#")) for source in found.sources)
    assert not set(found.tags) & {"link", "iframe", "object"}
    assert "default-src 'none'" in found.policy
    assert "unsafe-eval" not in found.policy
    for address in ("http://", "https://", "url(", "@import"):
        assert address not in page, address
    result = result_of(predicted)
    assert f"SSIM {100 * result['ssim_eq4']:.1f} %" in page
    assert result["program_digest"] in page
    assert "is a placeholder" in page


def test_what_the_machine_has_to_do_is_told(predicted, planned):
    result, figures = result_of(predicted), json.loads((planned / "plan.json").read_text())
    assert result["layers"] == figures["layers"]
    assert result["clamped"]["wide_share"] == figures["clamped_wide_share"]
    assert result["plan_notes"] == figures["notes"]
    assert result["machine"]["name"] == "paper"
    assert result["machine"]["reset_and_cure_s"] == 4 * (60 + 180)
    assert result["machine"]["problems"] == figures["problems"]


def test_figures_of_another_plan_are_not_taken_for_this_one(planned, tmp_path):
    shutil.copytree(planned, tmp_path / "plan")
    digest = load_program(planned).digest
    assert plans_figures(tmp_path / "plan", digest) == json.loads((planned / "plan.json").read_text())
    assert plans_figures(tmp_path / "plan" / "program.json", "sha256:another") is None
    (tmp_path / "plan" / "plan.json").write_text("{")
    with pytest.raises(InputError, match=r"plan.json: is no JSON .*; plan again"):
        plans_figures(tmp_path / "plan", digest)


def test_heating_and_shape_belong_together(predicted, planned):
    result = result_of(predicted)
    shape = trimesh.load_mesh(predicted / "shape.ply", process=False)
    with np.load(predicted / "heating.npz") as heating:
        temperature, vertices = heating["temperature_c"], heating["vertices_mm"]
        triangles, flat = heating["triangles"], heating["flat_mm"]
    assert temperature[0] == 25.0
    assert temperature[-1] == 150.0
    assert np.all(np.diff(temperature) > 0)
    assert temperature.tolist() == pytest.approx(result["accepted_temperatures_c"])
    assert vertices.shape == (len(temperature), len(flat), 3)
    assert triangles.shape == (result["triangle_count"], 3)
    assert np.ptp(vertices[0, :, 2]) < 1e-9
    assert np.ptp(vertices[-1, :, 2]) > 1.0
    assert np.array_equal(shape.faces, triangles)
    # in the target's frame: seen from above, convex, its middle over the target's
    target = load_target(planned / "target.npz")
    seen = np.asarray(shape.vertices)
    radius = np.hypot(*seen[:, :2].T)
    assert seen[radius < 2, 2].mean() - seen[radius > 6, 2].mean() == pytest.approx(target.depth_mm, rel=0.5)
    assert np.abs(seen[:, :2].mean(axis=0)).max() < 0.5
    assert np.all(np.asarray(shape.face_normals)[:, 2] > 0)


def test_the_scan_is_a_height_map_in_the_targets_frame(predicted, planned):
    target = load_target(planned / "target.npz")
    with np.load(predicted / "scan.npz") as scan:
        x, y, z, wanted = scan["x_mm"], scan["y_mm"], scan["z_mm"], scan["target_z_mm"]
        similarity = scan["ssim_map"]
    assert z.shape == wanted.shape == (len(y), len(x)) == (168, 104)
    assert np.all(np.diff(x) > 0)
    assert np.all(np.diff(y) > 0)
    low, high = target.bounds_mm
    assert low[0] < x[0]
    assert x[-1] < high[0]
    assert low[1] < y[0]
    assert y[-1] < high[1]
    assert np.nanmax(wanted) == pytest.approx(target.depth_mm, abs=0.05)
    assert np.nanmax(similarity) <= 1.0 + 1e-9
    both = np.isfinite(z) & np.isfinite(wanted)
    assert both.mean() > 0.6
    assert np.abs(z - wanted)[both].mean() < 0.5


def test_the_scan_can_be_scored_again(lce, predicted, planned, tmp_path):
    ran = lce("score", predicted / "scan.npz", "--target", planned / "target.npz", "--out", tmp_path / "out")
    assert (ran.code, ran.err) == (0, "")
    assert "SSIM (Eq. 4)" in ran.out
    assert names(tmp_path / "out") == SCORE_FILES
    first, again = result_of(predicted), result_of(tmp_path / "out")
    assert again["ssim_eq4"] == pytest.approx(first["ssim_eq4"], abs=0.03)
    assert again["rms_mm"] == pytest.approx(first["rms_mm"], abs=0.05)
    assert again["target_digest"] == first["target_digest"]
    assert set(SCORES) <= set(again)


def test_a_target_scored_against_itself_agrees(lce, planned, tmp_path, no_pictures):
    itself = lce("score", planned / "target.npz", "--target", planned / "target.npz", "--out", tmp_path / "out")
    assert itself.code == 0
    result = result_of(tmp_path / "out")
    assert result["ssim_eq4"] == pytest.approx(1.0, abs=0.01)
    assert result["rms_mm"] < 0.01


def test_a_program_without_a_target_is_predicted_and_not_scored(lce, planned, tmp_path, no_pictures):
    shutil.copy(planned / "program.json", tmp_path / "alone.json")
    ran = lce("predict", tmp_path / "alone.json", "--out", tmp_path / "out", *COARSE)
    assert (ran.code, ran.err) == (0, "")
    assert "no target: the shape was not scored" in ran.out
    assert names(tmp_path / "out") == {name for name in UNSCORED_FILES if not name.endswith(".png")}
    result = result_of(tmp_path / "out")
    assert result["target_digest"] is None
    assert not set(SCORES) & set(result)
    assert "not scored" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_the_same_seed_gives_the_same_result(lce, predicted, planned, tmp_path, no_pictures):
    ran = lce("predict", planned / "program.json", "--out", tmp_path / "out", *COARSE)
    assert (ran.code, ran.err) == (0, "")
    assert without_times(result_of(tmp_path / "out")) == without_times(result_of(predicted))
    with np.load(predicted / "heating.npz") as first, np.load(tmp_path / "out" / "heating.npz") as again:
        assert all(np.array_equal(first[key], again[key]) for key in first.files)


def test_what_was_asked_for_is_what_was_done(lce, planned, tmp_path, no_pictures):
    options = ("--temperature-c", "100", "--support", "free", "--seed", "5", "--scanner-noise", "--target", "saddle")
    ran = lce("predict", planned, "--out", tmp_path / "out", *COARSE, *options)
    assert (ran.code, ran.err) == (0, "")
    result = result_of(tmp_path / "out")
    assert result["target_name"] == "saddle"
    assert result["accepted_temperatures_c"][-1] == result["temperature_c"] == 100.0
    assert (result["support"], result["seed"], result["scanner_noise"]) == ("free", 5, True)


def break_predict(monkeypatch, fault):
    def broken(program, options, *, progress):
        predict(program, options, progress=progress)
        raise fault

    monkeypatch.setattr("scenes.prediction.predict", broken)


def test_a_second_run_replaces_its_files_and_leaves_others(lce, planned, tmp_path, no_pictures, monkeypatch):
    out = tmp_path / "out"
    out.mkdir()
    (out / "result.json").write_text("old")
    (out / "notes.txt").write_text("mine")
    assert lce("predict", planned, "--out", out, *COARSE).code == 0
    assert result_of(out)["seed"] == 0
    assert (out / "notes.txt").read_text() == "mine"
    kept = {path: path.read_bytes() for path in out.iterdir()}

    break_predict(monkeypatch, RuntimeError("a bug"))
    with pytest.raises(RuntimeError, match="a bug"):
        lce("predict", planned, "--out", out, *COARSE, "--seed", "1")
    assert {path: path.read_bytes() for path in out.iterdir()} == kept

    break_predict(monkeypatch, KeyboardInterrupt())
    for folder in (out, tmp_path / "new"):
        ran = lce("predict", planned, "--out", folder, *COARSE, "--seed", "1")
        assert (ran.code, ran.err) == (130, "lce: interrupted; no results were written.\n")
    assert {path: path.read_bytes() for path in out.iterdir()} == kept
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_solver_that_gives_up_is_no_wrong_input(lce, planned, tmp_path, monkeypatch):
    break_predict(monkeypatch, SolverError("equilibrium: gave up; use a finer mesh."))
    ran = lce("predict", planned, "--out", tmp_path / "out", *COARSE)
    assert (ran.code, ran.err) == (1, "lce: equilibrium: gave up; use a finer mesh.\n")
    assert not list(tmp_path.iterdir())


def test_scenes_schema_and_doctor_answer_on_stdout(lce):
    listed = lce("scenes")
    assert (listed.code, listed.err) == (0, "")
    assert {"face", "oblate_dome", "saddle"} <= {line.split()[0] for line in listed.out.splitlines()}
    assert all(len(line.split()) > 3 for line in listed.out.splitlines())
    schema = lce("schema")
    assert (schema.code, schema.err) == (0, "")
    assert "digest" in json.loads(schema.out)["properties"]
    found = lce("doctor")
    assert (found.code, found.err) == (0, "")
    for word in ("python", "numpy", "warp-lang", "sparse solver", "3-D pictures", "kernels run on"):
        assert word in found.out
