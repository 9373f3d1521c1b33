"""The report's commands make the same again."""

import shlex
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.program import load_machine, load_program
from planner.program.machine import PAPER_MACHINE
from scenes import cli
from scenes.noise_flags import DesignNoiseFlags, NoiseFlags
from scenes.predict_flags import HeatingFlags, MaterialFlags, PostFlags, SolverFlags, predict_options
from scenes.prediction import plain_settings
from scenes.report.reproduce import plan_command, predict_command
from twin.equilibrium import RampOptions
from twin.film import FilmOptions
from twin.material import Material
from twin.predict import PredictOptions

NUMBERS = st.floats(0.05, 2.0)
FOUR = st.none() | st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS)
OPTIONS = st.builds(
    PredictOptions,
    film=st.builds(
        FilmOptions,
        mesh_mm=NUMBERS,
        edge_blur_mm=NUMBERS,
        line_width_mm=st.none() | st.floats(0.3, 2.0),
        end_length_mm=NUMBERS,
        profile=st.sampled_from(["uniform", "skin"]),
        fading_tau_h=st.none() | NUMBERS,
        layer_thickness_mm=FOUR,
        modulus_ratio=FOUR,
    ),
    material=st.builds(
        Material, modulus_mpa=NUMBERS, density_kg_m3=st.floats(100, 3000), transition_c=st.floats(60, 90)
    ),
    ramp=st.builds(RampOptions, tap_mm=NUMBERS),
    temperature_c=st.floats(25, 200),
    support=st.sampled_from(["plate", "free"]),
    device=st.just("cpu"),
    seed=st.integers(0, 9),
) | st.builds(PredictOptions, temperatures_c=st.tuples(st.floats(25, 200), st.floats(25, 200)), device=st.just("cpu"))


def result_for(options, **more):
    field = options.temperature_field.kind
    return {
        "settings": plain_settings(options),
        "temperature_field": field,
        "scanner_noise": False,
        "target_digest": None,
        **more,
    }


PLAIN = result_for(PredictOptions())


def parsed(command):
    """The flags that the command line takes from a command."""
    words = shlex.split(command)
    assert words[0] == "lce"
    return cli.app.parse_args(words[1:])[1].arguments


@settings(max_examples=40, deadline=None)
@given(options=OPTIONS)
def test_the_command_gives_the_same_settings(small_program, options):
    flags = parsed(predict_command(result_for(options), small_program, "my plan/it's"))
    heating, material, post = HeatingFlags(), MaterialFlags(), PostFlags()
    again = predict_options(
        flags.get("heating") or heating, flags.get("material") or material, flags.get("post") or post, flags["solver"]
    )
    assert again == options
    assert str(flags["program"]) == "my plan/it's"


@pytest.fixture(scope="module")
def small_program(planned):
    return load_program(planned)


def test_what_was_asked_for_besides_is_asked_for_again(small_program):
    machine = load_machine(PAPER_MACHINE)
    options = PredictOptions(film=FilmOptions(machine=machine), device="cpu")
    result = result_for(
        options,
        scanner_noise=True,
        target_digest="sha256:another",
        shapes_by_seed=[{"seeds": (0, 2)}, {"seeds": (1,)}],
        score_band={"draws": 5},
        noise={
            "count": 7,
            "mesh_mm": 0.8,
            "standard_deviations": {
                "strain": 0.1,
                "layer_strain": 0.05,
                "direction_deg": 5.0,
                "direction_length_mm": "inf",
                "registration_mm": 0.2,
            },
        },
    )
    command = predict_command(result, small_program, "PLAN")
    flags = parsed(command)
    assert flags["noise"] == NoiseFlags(
        noise=7, noise_strain=0.1, noise_direction_length_mm=float("inf"), noise_mesh_mm=0.8
    )
    assert flags["solver"] == SolverFlags(seeds=3, device="cpu")
    assert (flags["scanner_noise"], flags["target"], flags["calibration_draws"]) == (True, "TARGET", 5)
    assert "--machine MACHINE.toml" in command


def test_the_plan_comes_out_with_the_same_hash(lce, planned, small_program, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("scenes.planning.draw_plan", lambda *_, **__: None)
    monkeypatch.setattr("scenes.planning.draw_target", lambda *_, **__: None)
    command = plan_command(PLAIN, small_program, str(planned))
    assert command == plan_command(PLAIN, small_program, str(planned / "program.json"))
    ran = lce(*shlex.split(command)[1:])
    assert ran.code == 0, ran.err
    assert load_program(tmp_path / "out" / "again").digest == small_program.digest


def test_a_searched_plan_and_one_by_hand(small_program):
    inputs = small_program.inputs
    searched = replace_method(small_program, "inverse", {"stack": "pairs", "robust": True, "machine": "my own"})
    command = plan_command(PLAIN, searched, "PLAN")
    assert "--method inverse" in command
    assert "--stack pairs --robust" in command
    assert "--machine MACHINE.toml" in command
    assert parsed(command)["inverse"].robust
    assert plan_command(PLAIN, replace_method(small_program, "strip", inputs.settings), "PLAN") is None


def test_a_searched_plan_keeps_what_it_was_heated_to_and_must_bear(small_program):
    settings = {"robust": True, "noise_strain": 0.02, "noise_direction_length_mm": "inf", "temperature_c": 110.0}
    command = plan_command(PLAIN, replace_method(small_program, "inverse", {**settings, "transition_c": 80.0}), "PLAN")
    flags = parsed(command)
    assert flags["noise"] == DesignNoiseFlags(noise_strain=0.02, noise_direction_length_mm=float("inf"))
    assert flags["heating"].temperature_c == 110.0
    assert flags["material"].transition_c == 80.0


def test_a_film_as_run_comes_from_no_plan(small_program):
    as_run = result_for(PredictOptions(film=FilmOptions(pass_to_cure_s=((1.0,),))))
    assert plan_command(as_run, small_program, "out/run") is None


def replace_method(program, method, settings):
    inputs = program.inputs.model_copy(update={"method": method, "settings": settings})
    return program.model_copy(update={"inputs": inputs})


def test_only_what_differs_from_the_defaults_is_written(small_program):
    options = replace(PredictOptions(), device="auto")
    assert predict_command(result_for(options), small_program, "PLAN") == "lce predict PLAN --out out/again-hot"
