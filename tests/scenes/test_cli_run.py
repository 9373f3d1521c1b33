"""`lce run`, and `lce predict` of what was run."""

import json
from pathlib import Path

import pytest

from benchmarks.reliability.small_run import small_program
from planner.program import save_program
from rig.machine_file import SIMULATED_RIG


@pytest.fixture(scope="session")
def program(tmp_path_factory) -> Path:
    return save_program(small_program(), tmp_path_factory.mktemp("small") / "program.json")


def test_a_run_of_a_plan_and_the_shape_of_what_was_scratched(lce, planned: Path, tmp_path: Path) -> None:
    run = lce("run", planned, "--out", tmp_path / "run", "--no-score")
    assert run.code == 0, run.err
    assert "finished in" in run.out
    assert run.err == ""  # no live view in a pipe
    summary = json.loads((tmp_path / "run" / "run.json").read_text())
    assert summary["finished"] is True
    for name in ("journal.jsonl", "as-run.jsonl", "wire-stage.jsonl", "wire-pump.jsonl", "target.npz"):
        assert (tmp_path / "run" / name).stat().st_size > 0
    scores = []
    for source in (planned, tmp_path / "run"):
        predicted = lce(
            "predict", source, "--mesh-mm", 2.0, "--fading-tau-h", 2.5, "--out", tmp_path / f"hot-{source.name}"
        )
        assert predicted.code == 0, predicted.err
        scores.append(json.loads((tmp_path / f"hot-{source.name}" / "result.json").read_text())["ssim_eq4"])
    assert scores[1] == pytest.approx(scores[0], abs=0.02)
    lce("run", planned, "--out", tmp_path / "run").assert_refused("holds a finished run")
    lce("run", planned, "--out", tmp_path / "new", "--resume").assert_refused("holds no run that was begun")


def test_a_dry_run_opens_nothing_and_writes_nothing(lce, program: Path, tmp_path: Path) -> None:
    text = SIMULATED_RIG.read_text().replace('transport = "simulated"', 'transport = "serial"\nport = "/dev/absent"', 1)
    (tmp_path / "RIG.toml").write_text(text)
    ran = lce("run", program, "--rig", tmp_path / "RIG.toml", "--out", tmp_path / "run", "--dry-run")
    assert ran.code == 0, ran.err
    assert not (tmp_path / "run").exists()
    lines = ran.out.splitlines()
    assert sum("16 " in line and "/16 " in line for line in lines) == 16
    assert any(line.endswith("stage G1X4Y0F120") for line in lines)
    assert any(line.endswith("pump  0RUN") for line in lines)
    assert "nothing was opened" in lines[-1]


def test_a_rig_that_fails_ends_with_3(lce, program: Path, tmp_path: Path) -> None:
    text = SIMULATED_RIG.read_text().replace('transport = "simulated"', 'transport = "serial"\nport = "/dev/absent"', 1)
    (tmp_path / "RIG.toml").write_text(text)
    ran = lce("run", program, "--rig", tmp_path / "RIG.toml", "--out", tmp_path / "run")
    assert ran.code == 3
    assert "Serial port /dev/absent cannot be opened" in ran.err
    assert "Traceback" not in ran.err


def test_wrong_inputs_are_told_before_anything_is_opened(lce, program: Path, tmp_path: Path) -> None:
    rig = SIMULATED_RIG.read_text().replace('lamp = "simulated"', 'lamp = "wired"').replace("seed = 0", "seed = -1")
    (tmp_path / "RIG.toml").write_text(rig)
    lce("run", program, "--rig", tmp_path / "RIG.toml", "--out", tmp_path / "run").assert_refused("lamp", "seed")
    (tmp_path / "as-run.jsonl").write_text('{"record": "note", "at_s": 0}\n')
    lce("predict", tmp_path / "as-run.jsonl", "--out", tmp_path / "hot").assert_refused("text: this field is missing")
    assert not (tmp_path / "run").exists()
