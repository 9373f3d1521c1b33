"""From strips to a calibration, to a plan that names it, to a score with a band."""

import json

import numpy as np
import pytest

from planner.calibration import load_calibration

HEADER = "load_g,speed_mm_s,radius_mm,side,width_mm,repeat"


@pytest.fixture(scope="module")
def strips(tmp_path_factory):
    path = tmp_path_factory.mktemp("strips") / "mine.csv"
    rng, truth, lines = np.random.default_rng(3), load_calibration(), [HEADER]
    for number, (load, speed) in enumerate((f, v) for f in (0.5, 1, 2.4, 4, 6.5) for v in (0.5, 0.8, 1.2, 2.0)):
        radius = float(truth.radius_mm(load, speed)) * np.exp(0.05 * rng.normal()) * (1.9 if number == 6 else 1.0)
        lines.append(f"{load},{speed},{radius:.3f},{'top' if number % 2 else 'bottom'},8,1")
    path.write_text("\n".join(lines) + "\n")
    return path


def test_calibrate_plan_and_predict_name_the_calibration_and_band_the_score(lce, strips, dome_case, tmp_path):
    made = tmp_path / "new" / "calibration.toml"
    ran = lce("calibrate", strips, "--out", made, "--operator", "A. Person", "--date", "2026-01-02")
    assert ran.code == 0, ran.err
    assert "outlier: row 8 (1 g, 1.2 mm/s)" in ran.out
    assert {path.name for path in made.parent.iterdir()} == {"calibration.toml", "calibration.png"}
    record = load_calibration(made).record
    assert record.provenance["operator"] == "A. Person"
    assert record.provenance["source"] == "mine.csv"
    assert record.provenance["file_sha256"].startswith("sha256:")
    assert "20 strips" in record.provenance["samples"]
    assert "8 mm" in record.provenance["strip_width"]

    planned = lce("plan", dome_case, "--calibration", made, "--out", tmp_path / "plan")
    assert "calibration 'mine', measured" in planned.out
    told = json.loads((tmp_path / "plan" / "plan.json").read_text())["calibration"]
    assert told["name"] == "mine"
    assert not told["placeholder"]

    ran = lce("predict", tmp_path / "plan", "--mesh-mm", 1.5, "--calibration-draws", 3, "--out", tmp_path / "hot")
    assert "as well as calibration 'mine' is known" in ran.out
    result = json.loads((tmp_path / "hot" / "result.json").read_text())
    band = result["score_band"]["ssim_eq4"]
    assert band["low"] < band["median"] < band["high"]
    # a batch solves each film on one core, a prediction on all: they stop at slightly different places
    assert band["expected"] == pytest.approx(result["ssim_eq4"], abs=1e-3)
    assert band["high"] - band["low"] > 1e-3
    assert not any("placeholder" in warning for warning in result["warnings"])
    page = (tmp_path / "hot" / "report.html").read_text()
    assert "As well as calibration" in page
    assert "mine, measured" in page

    lce("predict", tmp_path / "plan", "--mesh-mm", 1.5, "--calibration-draws", 0, "--out", tmp_path / "none")
    assert "score_band" not in json.loads((tmp_path / "none" / "result.json").read_text())


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], "is empty"),
        (["load,speed"], "lacks load_g"),
        ([HEADER, *(f"2.4,{0.1 * k:g},3,top,8,1" for k in range(5, 20))], "load_g: found only 2.4 g"),
    ],
)
def test_bad_strips_are_refused_and_nothing_is_written(lce, tmp_path, lines, words):
    path = tmp_path / "bad.csv"
    path.write_text("\n".join(lines))
    lce("calibrate", path, "--out", tmp_path / "new" / "c.toml").assert_refused(words)
    assert not (tmp_path / "new").exists()


def test_calibrations_are_toml_files(lce, strips, tmp_path):
    lce("calibrate", strips, "--out", tmp_path / "c.json").assert_refused("allowed is a file that ends in .toml")
    (tmp_path / "d.toml").mkdir()
    lce("calibrate", strips, "--out", tmp_path / "d.toml").assert_refused("is a folder")
