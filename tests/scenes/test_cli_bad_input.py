"""Wrong Programs, cases, calibrations, options and output folders: one line for each problem, nothing written."""

import errno
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from planner.calibration.files import PLACEHOLDER
from planner.program.machine import PAPER_MACHINE


@pytest.fixture
def plan_folder(planned, tmp_path):
    """A copy of the small dome's plan, to spoil."""
    return Path(shutil.copytree(planned, tmp_path / "plan"))


def first_passes(document, layer=0):
    return document["layers"][layer]["operations"][2]["passes"]


def move_a_pass(document):
    stroke = first_passes(document)[0]
    stroke["points_mm"] = [[x + 500, y] for x, y in stroke["points_mm"]]


def everything(document):
    document["layers"].pop()
    first_passes(document)[0]["load_g"] = [60.0]
    first_passes(document, 1)[0]["speed_mm_s"][0] = 0.01


BAD_PROGRAMS = {
    "version": (lambda d: d.update(schema_version="2.0"), ["schema_version is '2.0', allowed is '1.0'"]),
    "no version": (lambda d: d.pop("schema_version"), ["schema_version is None"]),
    "digest": (lambda d: d.update(digest="sha256:" + 64 * "0"), ["digest is"]),
    "changed": (lambda d: first_passes(d)[0].update(load_g=[3.21]), ["changed after it was written"]),
    "unknown key": (lambda d: d.update(sede=1), ["sede: unknown field"]),
    "layers": (lambda d: d["layers"].pop(), ["3 layers but film.layer_thickness_mm has 4"]),
    "outside": (move_a_pass, ["layers[0], pass 0: points_mm reaches"]),
    "load": (lambda d: first_passes(d)[0].update(load_g=[60.0]), ["load_g is 60 g, the calibration allows 0.5 to 6.5"]),
    "speed": (lambda d: first_passes(d)[1]["speed_mm_s"].__setitem__(0, 9.0), ["speed_mm_s is 9 mm/s"]),
    "several": (everything, ["3 layers", "load_g is 60 g", "speed_mm_s is 0.01 mm/s"]),
}


@pytest.mark.parametrize("name", BAD_PROGRAMS)
def test_a_wrong_program_is_refused(lce, plan_folder, tmp_path, name):
    change, problems = BAD_PROGRAMS[name]
    path = plan_folder / "program.json"
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))
    for program in (plan_folder, path):
        lce("predict", program, "--out", tmp_path / "out").assert_refused(*problems)
    assert not (tmp_path / "out").exists()


def test_what_is_no_program_is_refused(lce, tmp_path):
    lce("predict", tmp_path / "absent.json", "--out", tmp_path / "out").assert_refused("no such file")
    lce("predict", tmp_path, "--out", tmp_path / "out").assert_refused("program.json: no such file")
    for content in ("", "{", "[1]", "\x00"):
        (tmp_path / "program.json").write_text(content)
        lce("predict", tmp_path, "--out", tmp_path / "out").assert_refused("program.json")
    assert not (tmp_path / "out").exists()


def test_a_target_that_the_program_was_not_planned_for_is_refused(lce, plan_folder, tmp_path):
    path = plan_folder / "target.npz"
    with np.load(path) as archive:
        arrays = dict(archive)
    np.savez(path, **{**arrays, "z_mm": 1.01 * arrays["z_mm"]})
    lce("predict", plan_folder, "--out", tmp_path / "out").assert_refused("plan again, or name the target")
    path.write_bytes(b"scrambled")
    lce("predict", plan_folder, "--out", tmp_path / "out").assert_refused("target.npz cannot be read")
    lce("predict", plan_folder, "--target", "dme", "--out", tmp_path / "out").assert_refused("dme: no built-in case")
    assert not (tmp_path / "out").exists()


OPTIONS = [
    (("--mesh-mm", "0.001"), "found 0.001 mm, allowed are 0.05 to 5 mm"),
    (("--mesh-mm", "-1"), "allowed are 0.05 to 5 mm"),
    (("--mesh-mm", "nan"), "allowed are 0.05 to 5 mm"),
    (("--mesh-mm", "50"), "allowed are 0.05 to 5 mm"),
    (("--mesh-mm", "fine"), '"fine"'),
    (("--temperature-c", "15"), "found 15 C, allowed are 25 to 200 C"),
    (("--temperature-c", "500"), "found 500 C, allowed are 25 to 200 C"),
    (("--temperature-c", "nan"), "found nan C"),
    (("--temperatures-c", "25,hot"), "--temperatures-c: found '25,hot', allowed are numbers with commas between"),
    (("--temperatures-c", ""), "--temperatures-c: found ''"),
    (("--temperatures-c", "60,500,25"), "found 500 C, allowed are 25 to 200 C"),
    (("--temperatures-c", "60,nan"), "found nan C"),
    (("--temperatures-c", "60", "--temperature-c", "90"), "allowed is one of the two"),
    (("--density-kg-m3", "-1"), "Must be >= 0"),
    (("--transition-c", "400"), "transition_c is 400"),
    (("--layers-mm", "0.2,0.2"), "layer thickness: found 2 values, the Program has 4 layers"),
    (("--modulus-ratio", "1;1;1;1"), "--modulus-ratio: found '1;1;1;1'"),
    (("--line-width-mm", "0"), "line width: found 0"),
    (("--tap-mm", "nan"), "--tap-mm"),
    (("--machine", "absent.toml"), "no such machine file"),
    (("--modulus-mpa", "0"), "Must be >= 0.01"),
    (("--modulus-mpa", "nan"), "--modulus-mpa"),
    (("--seed", "-1"), "Must be >= 0"),
    (("--seed", "many"), "--seed"),
    (("--support", "water"), 'Choose from: "plate", "free"'),
    (("--device", "tpu"), 'Choose from: "auto", "cpu", "cuda"'),
    (("--noise", "-1"), "Must be >= 0"),
    (("--noise-strain", "0.1"), "--noise-strain 0.1: says how noisy films are, but --noise, their number, is 0"),
    (("--noise-mesh-mm", "1.2"), "--noise-mesh-mm 1.2: says how noisy films are, but --noise"),
    (("--noise", "2", "--noise-mesh-mm", "0.01"), "Must be >= 0.05"),
    (("--noise", "2", "--noise-strain", "nan"), "process noise, strain: found nan"),
    (("--colour", "red"), "Unknown option: --colour"),
    (("twice",), "twice"),
]


@pytest.mark.parametrize(("options", "words"), OPTIONS)
def test_options_of_predict_are_checked(lce, planned, tmp_path, options, words):
    lce("predict", planned, "--out", tmp_path / "out", *options).assert_refused(words)
    assert not list(tmp_path.iterdir())


def test_a_mesh_that_does_not_fit_the_memory_is_refused(lce, planned, tmp_path, monkeypatch):
    monkeypatch.setattr("twin.film.build._free_memory", lambda: 1e9)
    ran = lce("predict", planned, "--out", tmp_path / "out", "--mesh-mm", "0.05")
    ran.assert_refused("GB of memory, free are 1.0 GB; use --mesh-mm 0.0")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "--target requires an argument; see `lce plan --help`"),
        (("oblate_dom",), "did you mean oblate_dome?"),
        (("xyzzy",), "`lce scenes` lists them"),
        (("absent.toml",), "no such case file"),
        (("face", "--size-mm", "40x60"), "--size-mm 40x60 is for surface files"),
        (("face", "--up", "+y"), "--up +y is for surface files"),
        (("face", "--method", "radial"), 'Choose from: "perpendicular", "maximum"'),
        (("face", "--tracer", "wire"), 'Choose from: "greedy", "dense"'),
        (("face", "--robust"), "--robust: is for --method inverse, but the method is perpendicular; leave it out"),
        (
            ("face", "--method", "maximum", "--budget-s", "9", "--modulus-mpa", "2"),
            "--budget-s 9.0, --modulus-mpa 2.0: is for --method inverse, but the method is maximum; leave them out",
        ),
        (
            ("face", "--method", "inverse", "--tracer", "dense", "--margin-mm", "1"),
            "--tracer dense, --margin-mm 1.0: is for the methods perpendicular and maximum",
        ),
        (
            ("face", "--method", "inverse", "--noise-strain", "0.1"),
            "--noise-strain 0.1: says what a robust design must bear, but --robust is not given; add it, or leave it",
        ),
        (("face", "--method", "inverse", "--robust", "--noise-strain", "2"), "strain: found 2, allowed are 0 to 0.3"),
        (("face", "--noise-strain", "0.1"), "--noise-strain 0.1: is for --method inverse"),
        (("face", "--method", "inverse", "--budget-s", "0"), "Must be > 0"),
        (("face", "--method", "inverse", "--stack", "three"), 'Choose from: "all", "pairs"'),
        (("face", "--method", "inverse", "--temperature-c", "500"), "found 500 C, allowed are 25 to 200 C"),
        (("face", "--method", "inverse", "--layers-mm", "0.2"), "layer thickness: found [0.2]"),
        (("face", "--method", "inverse", "--resume"), "out.progress/checkpoint.npz: no search for this --out"),
        (("strip_tight", "--method", "inverse"), "--method inverse: is for surfaces"),
        (("face", "--flattening", "iron"), 'Choose from: "arap", "grid"'),
        (("face", "--seed", "-3"), "Must be >= 0"),
        (("face", "--calibration", "absent.toml"), "no such calibration file"),
        (("face", "--machine", "absent.toml"), "no such machine file"),
    ],
)
def test_options_of_plan_are_checked(lce, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    lce("plan", *arguments, "--out", tmp_path / "out").assert_refused(words)
    assert not list(tmp_path.iterdir())


def test_a_command_that_is_not_there_is_refused(lce):
    lce("plann").assert_refused('Unknown command "plann"')


@pytest.mark.parametrize(
    ("change", "problems"),
    [
        (lambda text: text + "\n[plan]\nmehod = 'maximum'\n", ["[plan] mehod is not a key"]),
        (lambda text: text + "\ncolour = 'red'\nsize = 3\n", ["colour is not a key", "size is not a key"]),
        (lambda text: text.replace("radius_mm", "radius"), ["[target] radius is not a key", "radius_mm"]),
        (lambda text: text.replace("radius_mm = 8", "radius_mm = -8"), ["radius_mm"]),
        (lambda text: text.replace("height_mm = 4", "height_mm = 290"), ["up to 3 times the width"]),
        (lambda text: text.replace("'dome'", "'doom'").replace('"dome"', '"doom"'), ["target"]),
        (lambda text: text + "\n[plan\n", ["cannot be read as TOML"]),
    ],
)
def test_a_wrong_case_file_is_refused(lce, dome_case, tmp_path, change, problems):
    path = tmp_path / "case.toml"
    path.write_text(change(dome_case.read_text()))
    lce("plan", path, "--out", tmp_path / "out").assert_refused(*problems)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("change", "problems"),
    [
        (lambda text: "operater = 'me'\n" + text, ["operater: unknown field"]),
        (lambda text: text.replace("load_g_max = 6.5", "load_g_max = 0.1"), ["load_g_min is 0.5"]),
        (lambda text: text.replace("radius_mm_max = 14.4", "radius_mm_max = 40"), ["limits.radius_mm_max is 40 mm"]),
        (lambda text: text.replace("load_scale_g = 2.0", ""), ["model.load_scale_g: this field is missing"]),
        (lambda text: "[limits\n" + text, ["not valid TOML"]),
    ],
)
def test_a_wrong_calibration_is_refused(lce, dome_case, tmp_path, change, problems):
    path = tmp_path / "calibration.toml"
    path.write_text(change(PLACEHOLDER.read_text()))
    lce("plan", dome_case, "--calibration", path, "--out", tmp_path / "out").assert_refused(*problems)
    assert not (tmp_path / "out").exists()


def test_a_wrong_machine_is_refused(lce, dome_case, tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text("colour = 'red'\n" + PAPER_MACHINE.read_text())
    lce("plan", dome_case, "--machine", path, "--out", tmp_path / "out").assert_refused("colour: unknown field")
    assert not (tmp_path / "out").exists()


def test_noise_without_a_target_is_refused(lce, plan_folder, tmp_path):
    (plan_folder / "target.npz").unlink()
    lce("predict", plan_folder, "--out", tmp_path / "out", "--noise", "2").assert_refused("no target to score them")
    assert not (tmp_path / "out").exists()


def test_a_scan_that_cannot_be_read_is_refused(lce, dome_case, tmp_path):
    (tmp_path / "scan.stl").write_bytes(b"")
    for name in ("absent.stl", "scan.stl", "scan.step"):
        ran = lce("score", tmp_path / name, "--target", dome_case, "--out", tmp_path / "out")
        ran.assert_refused(name.partition(".")[0])
    assert [path.name for path in tmp_path.iterdir()] == ["scan.stl"]


@pytest.mark.parametrize("command", ["plan", "predict", "score"])
def test_a_file_in_the_way_of_the_folder_is_told_before_any_work(lce, planned, tmp_path, monkeypatch, command):
    def too_early(*_, **__):
        pytest.fail("worked before looking at --out")

    for name in ("scenes.planning.plan", "scenes.prediction.predict", "scenes.commands.score_surface"):
        monkeypatch.setattr(name, too_early)
    (tmp_path / "file").write_text("mine")
    arguments = {
        "plan": (planned / "target.npz",),
        "predict": (planned,),
        "score": (planned / "target.npz", "--target", planned / "target.npz"),
    }[command]
    for out in (tmp_path / "file", tmp_path / "file" / "below"):
        lce(command, *arguments, "--out", out).assert_refused("a file of that name is in the way")
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize("place", ["numpy.savez_compressed", "pathlib.Path.write_text", "scenes.planning.draw_plan"])
def test_a_full_disk_leaves_nothing(lce, planned, tmp_path, monkeypatch, place):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(place, full)
    ran = lce("plan", planned / "target.npz", "--out", tmp_path / "new" / "out")
    ran.assert_refused("No space left on device")
    assert not list(tmp_path.iterdir())


def run_fresh(*arguments, **options):
    """Run the installed command in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "scenes.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        **options,
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("plan", "fase", "--out", "out"), "did you mean face?"),
        (("plan", "absent.stl", "--out", "out"), "there is no file absent.stl"),
        (("predict", "absent.json", "--out", "out"), "no such file"),
        (("predict", "--sed", "3"), "see `lce predict --help`"),
    ],
)
def test_a_fresh_process_refuses_likewise(tmp_path, arguments, words):
    ran = run_fresh(*arguments, cwd=tmp_path)
    assert ran.returncode == 2
    assert ran.stdout == ""
    assert ran.stderr.startswith("lce: ")
    assert ran.stderr.count("\n") == 1
    assert words in ran.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder_is_told(lce, planned, tmp_path):
    tmp_path.chmod(0o500)
    ran = lce("plan", planned / "target.npz", "--out", tmp_path / "out")
    tmp_path.chmod(0o700)
    ran.assert_refused("Permission denied")
