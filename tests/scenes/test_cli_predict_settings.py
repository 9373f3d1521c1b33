"""What of a prediction's settings and noise reaches its result, its report and the terminal."""

import json
import re
from dataclasses import replace

import pytest
from results import COARSE, names, result_of

from planner.program.machine import PAPER_MACHINE
from scenes.noise_flags import NoiseFlags
from scenes.predict_flags import HeatingFlags, MaterialFlags, PostFlags, SolverFlags, predict_options
from scenes.robustness import MESH_MM
from twin.batch import ProcessNoise
from twin.families import Family
from twin.hot_shape import Snap
from twin.predict import PredictOptions, heat_film


@pytest.mark.usefixtures("no_pictures")
def test_settings_of_the_physics_reach_the_result(lce, planned, tmp_path):
    out = tmp_path / "hot"
    options = ["--temperature-field", "gap_model", "--profile", "skin", "--fading-tau-h", "2.5"]
    ran = lce("predict", planned, "--out", out, "--mesh-mm", "2", "--seeds", "2", "--cool", *options)
    assert ran.code == 0, ran.err
    result = json.loads((out / "result.json").read_text())
    assert result["temperature_field"] == "gap_model"
    assert result["settings"]["temperature_field"]["convection_w_m2k"] > 0
    assert result["settings"]["film"]["profile"] == "skin"
    assert result["settings"]["film"]["fading_tau_h"] == 2.5
    assert result["cooled_back_to_flat_mm"] < 1e-3
    assert sum(shape["share"] for shape in result["shapes_by_seed"]) == pytest.approx(1.0)
    assert [stop["temperature_c"] for stop in result["stops"]] == [150.0, 25.0]


@pytest.mark.usefixtures("no_pictures")
def test_every_setting_reaches_result_and_report(lce, planned, tmp_path):
    machine = tmp_path / "machine.toml"
    machine.write_text(PAPER_MACHINE.read_text().replace('name = "', 'name = "my own '))
    options = {
        "--modulus-mpa": "0.8",
        "--density-kg-m3": "1100",
        "--transition-c": "80",
        "--layers-mm": "0.21,0.2,0.19,0.2",
        "--modulus-ratio": "1,1,1.2,1",
        "--line-width-mm": "0.9",
        "--edge-blur-mm": "0.2",
        "--end-length-mm": "0.3",
        "--fading-tau-h": "3",
        "--machine": str(machine),
        "--tap-mm": "0.3",
    }
    given = [word for option in options.items() for word in option]
    ran = lce("predict", planned, "--out", tmp_path / "hot", *COARSE, *given)
    assert ran.code == 0, ran.err
    settings = result_of(tmp_path / "hot")["settings"]
    assert settings["material"] == {"modulus_mpa": 0.8, "density_kg_m3": 1100.0, "transition_c": 80.0}
    film = settings["film"]
    assert film["layer_thickness_mm"] == [0.21, 0.2, 0.19, 0.2]
    assert film["modulus_ratio"] == [1.0, 1.0, 1.2, 1.0]
    assert (film["line_width_mm"], film["edge_blur_mm"], film["end_length_mm"]) == (0.9, 0.2, 0.3)
    assert film["machine"].startswith("my own ")
    assert settings["ramp"]["tap_mm"] == 0.3
    page = (tmp_path / "hot" / "report.html").read_text(encoding="utf-8")
    shown = ("0.8 MPa, 1100 kg/m3", "80 °C", "0.21, 0.2, 0.19, 0.2 mm", "times 1, 1, 1.2, 1", "0.9 mm, 0.2 mm, 0.3 mm")
    for words in (*shown, "tau 3 h", "my own ", "0.3 mm", "uniform"):
        assert words in page, words


def test_flags_left_out_are_the_defaults_of_the_library():
    assert predict_options(HeatingFlags(), MaterialFlags(), PostFlags(), SolverFlags()) == PredictOptions()


def test_films_with_noise_are_scored_told_and_drawn(lce, planned, tmp_path, no_pictures):
    out = tmp_path / "hot"
    options = ("--noise", "3", "--noise-strain", "0.1", "--noise-direction-deg", "4", "--seed", "7")
    ran = lce("predict", planned, "--out", out, *COARSE, *options)
    assert ran.code == 0, ran.err
    assert "noise.png" in names(out)
    noise = result_of(out)["noise"]
    assert (noise["count"], noise["seed"], noise["mesh_mm"]) == (3, 7, 1.5)
    deviations = {"strain": 0.1, "layer_strain": 0.05, "direction_length_mm": 0.8, "registration_mm": 0.2}
    assert noise["standard_deviations"] == pytest.approx({**deviations, "direction_deg": 4.0})
    # the prediction's own mesh is as coarse: its score is that without noise
    assert noise["without_noise"]["ssim_eq4"] == pytest.approx(result_of(out)["ssim_eq4"], abs=1e-3)
    for name in ("ssim_eq4", "rms_mm"):
        assert len(set(noise[name])) == 3
        assert noise["percentiles"][name]["50"] == sorted(noise[name])[1]
    # one error of a tenth for the whole film, of a twentieth for each of four layers
    assert len(set(noise["contraction_share"])) == 3
    assert all(0.6 < share < 1.4 for share in noise["contraction_share"])
    assert re.search(
        r"3 noisy films on a mesh of 1.5 mm: SSIM \(Eq. 4\) 0\.\d+, 0\.\d+, 0\.\d+ at 10, 50, 90 %", ran.out
    )
    assert set(noise["expected_cost"]) == {"strain", "layer_strain", "registration", "direction", "together"}
    assert "errors of the process: to first order they cost" in ran.out
    page = (out / "report.html").read_text(encoding="utf-8")
    assert page.count("<img") == 1
    assert "3 noisy films, 10, 50, 90 %" in page
    assert "to first order they cost" in page


def test_flags_of_noise_left_out_are_the_defaults_of_the_library():
    assert NoiseFlags().process_noise() == ProcessNoise()
    assert NoiseFlags().noise_mesh_mm == MESH_MM


def test_noisy_films_are_heated_on_the_mesh_that_is_asked_for(lce, planned, tmp_path, no_pictures):
    out = tmp_path / "hot"
    ran = lce("predict", planned, "--out", out, *COARSE, "--noise", "1", "--noise-mesh-mm", "1.6")
    assert ran.code == 0, ran.err
    noise = result_of(out)["noise"]
    assert noise["mesh_mm"] == 1.6
    assert noise["without_noise"]["ssim_eq4"] != result_of(out)["ssim_eq4"]
    assert "1 noisy films on a mesh of 1.6 mm" in ran.out


@pytest.mark.usefixtures("no_pictures")
def test_snaps_and_several_shapes_are_told(lce, planned, tmp_path, monkeypatch):
    """Two shapes, made up of the one that the dome has; the first has jumped."""
    captions = []

    def two(film, options, count, *, progress):
        shape = heat_film(film, options)
        snapped = replace(shape, snaps=(Snap(temperature_c=87.2, distance_mm=1.23, cooling=False),))
        return (
            Family(shape=snapped, seeds=(0, 2), share=2 / 3),
            Family(shape=shape, seeds=(1,), share=1 / 3),
        )

    monkeypatch.setattr("scenes.prediction.shapes_by_seed", two)
    monkeypatch.setattr("scenes.prediction.draw_side_by_side", lambda *given, title: captions.extend(given[3]))
    ran = lce("predict", planned, "--out", tmp_path / "hot", *COARSE, "--seeds", "3")
    assert ran.code == 0, ran.err
    assert "The film snapped at 87 C by 1.2 mm while it was heated" in ran.out
    assert "The film has 2 shapes, taken by 67%, 33% of the seeds" in ran.out
    assert captions == ["67% of 3 seeds", "33% of 3 seeds"]
    result = result_of(tmp_path / "hot")
    assert result["equilibrium"]["snaps"] == [{"temperature_c": 87.2, "distance_mm": 1.23, "cooling": False}]
    page = (tmp_path / "hot" / "report.html").read_text(encoding="utf-8")
    assert "snapped at 87 °C" in page
    assert "taken by 67 % of the seeds" in page
