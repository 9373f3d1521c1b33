"""`lce plan --method inverse`: what it asks the search for, and what it makes of its result. The result is made up."""

import json

import numpy as np
import pytest

from planner.program import Program, layer_times, load_machine, load_program
from planner.target import load_target
from planner.toolpaths.dense import Tiling
from scenes.pictures.graphics import VARIABLE
from twin.batch import ProcessNoise
from twin.film import FilmOptions
from twin.inverse import InverseDesign, Moment
from twin.predict import PredictOptions, predict
from twin.score import Score, score_surface

FILES = {"program.json", "plan.json", "plan.png", "target.npz", "target.png", "progress.png", "design.png"}
PICTURES = ("draw_plan", "draw_target", "draw_search", "draw_design")


@pytest.fixture(scope="module")
def designed(planned):
    """The small dome's plan, given out as an inverse design."""
    program = load_program(planned)
    parts = {name: getattr(program, name) for name in type(program).model_fields}
    inputs = program.inputs.model_copy(update={"method": "inverse", "settings": {"stack": "all"}})
    program = Program(**{**parts, "inputs": inputs})
    shape = predict(program, PredictOptions(film=FilmOptions(mesh_mm=1.5), device="cpu"))
    scored = score_surface(shape.top_mm, shape.film.triangles, load_target(planned / "target.npz"))
    history = tuple(
        Moment(
            elapsed_s=3.0 * k,
            stage=stage,
            ssim=0.7 + 0.05 * k,
            rms_mm=0.3 - 0.05 * k,
            top_mm=shape.top_mm,
            triangles=shape.film.triangles,
        )
        for k, stage in enumerate(("coarse", "coarse", "middle", "passes"))
    )
    return InverseDesign(
        program=program,
        shape=shape,
        scored=scored,
        ideal=scored.score,
        finer=scored.score,
        wider_range_share=0.9,
        noise_costs={"strain": 0.02, "layer_strain": 0.01, "registration": 0.005, "direction": 0.03, "together": 0.04},
        designed_mm=0.02,
        tilings=(Tiling.of_nothing(wanted=True),) * 4,
        layer_times=layer_times(program, load_machine()),
        problems=(),
        history=history,
        notes=("A note.",),
        limits=("The brow is too tight.",),
    )


@pytest.fixture
def search(monkeypatch, designed, field):
    """Put the design in place of each search; returns what searches were asked for."""
    asked = []

    def stand_in(target, *, options, progress, watch, keep, resume, **_):
        asked.append({"target": target, "options": options, "resume": resume})
        for moment in designed.history:
            progress(moment.stage, 0.5)
            watch(moment)
        keep(field)
        return designed

    monkeypatch.setenv(VARIABLE, "relief")
    monkeypatch.setattr("scenes.inverse_planning.design_inverse", stand_in)
    return asked


def test_a_design_leaves_its_program_figures_and_pictures(lce, dome_case, tmp_path, search, designed):
    out = tmp_path / "new" / "out"
    ran = lce("plan", dome_case, "--out", out, "--method", "inverse", "--support", "free", "--modulus-mpa", "2")
    assert ran.code == 0, ran.err
    assert {path.name for path in out.iterdir()} == FILES
    assert [path.name for path in out.parent.iterdir()] == ["out"]
    made, program = designed, load_program(out)
    assert program == made.program
    assert load_target(out / "target.npz").digest == program.inputs.target_sha256

    figures = json.loads((out / "plan.json").read_text())
    assert (figures["method"], figures["seed"], figures["program_digest"]) == ("inverse", 0, program.digest)
    assert (figures["settings"]["stack"], figures["settings"]["support"]) == ("all", "free")
    assert figures["settings"]["material"]["modulus_mpa"] == 2.0
    assert figures["calibration"]["placeholder"] is True
    assert set(figures["predicted"]) == set(figures["ideal"]) == set(Score.__dataclass_fields__)
    assert [layer["passes"] for layer in figures["layers"]] == [len(layer.passes) for layer in program.layers]
    assert all(0.0 <= layer["tiling"]["coverage"] <= 1.0 for layer in figures["layers"])
    assert figures["limits"] == ["The brow is too tight."]
    assert len(figures["history"]) == len(made.history)
    assert set(figures["history"][0]) == {"elapsed_s", "stage", "ssim", "rms_mm"}

    asked = search[0]["options"]
    assert (asked.heated.support, asked.heated.material.modulus_mpa) == ("free", 2.0)
    for words in ("is a placeholder", "layer 1:", f"SSIM (Eq. 4) {made.score.ssim_eq4:.3f}", "without passes",
                  "cost 0.040 of similarity together; alone: direction 0.030, strain of the whole film 0.020",
                  "limit: The brow is too tight."):  # fmt: skip
        assert words in ran.out
    assert figures["noise_costs"] == made.noise_costs


def test_a_robust_design_bears_the_noise_that_is_stated(lce, dome_case, tmp_path, search):
    noise = ("--noise-strain", "0.02", "--noise-direction-length-mm", "inf")
    ran = lce("plan", dome_case, "--out", tmp_path / "out", "--method", "inverse", "--robust", *noise)
    assert ran.code == 0, ran.err
    asked = search[0]["options"]
    assert asked.robust
    assert asked.noise == ProcessNoise(strain=0.02, direction_length_mm=np.inf)


def test_an_interrupted_search_is_resumed_with_the_same_inputs_only(
    lce, dome_case, tmp_path, search, field, monkeypatch
):
    out, progress = tmp_path / "out", tmp_path / "out.progress"

    def interrupt(*_, **__):
        assert {path.name for path in progress.iterdir()} == {"checkpoint.npz", "current.png"}
        raise KeyboardInterrupt

    for name in PICTURES:
        monkeypatch.setattr(f"scenes.inverse_planning.{name}", lambda *_, **__: None)
    command = ("plan", dome_case, "--out", out, "--method", "inverse")
    with monkeypatch.context() as patched:
        patched.setattr("scenes.inverse_planning.save_program", interrupt)
        ran = lce(*command, "--budget-s", "9")
    assert (ran.code, ran.err) == (130, "lce: interrupted; no results were written.\n")
    assert "repeat the command with --resume" in ran.out
    assert not out.exists()
    assert progress.exists()

    lce(*command, "--resume", "--seed", "1").assert_refused("belongs to another target, calibration or setting")
    assert len(search) == 1
    assert lce(*command, "--resume").code == 0
    assert search[0]["resume"] is None
    assert search[1]["resume"].stage == field.stage
    assert {path.name for path in out.iterdir()} == {"program.json", "plan.json", "target.npz"}
    assert not progress.exists()


def test_what_fails_before_its_first_stage_leaves_nothing(lce, dome_case, tmp_path, monkeypatch):
    def fail(*_, **__):
        raise RuntimeError("a bug")

    monkeypatch.setattr("scenes.inverse_planning.design_inverse", fail)
    with pytest.raises(RuntimeError, match="a bug"):
        lce("plan", dome_case, "--out", tmp_path / "out", "--method", "inverse")
    assert not list(tmp_path.iterdir())
