"""A run is killed at random instants, a real process by a real signal, and resumed until it is finished."""

import json
import random
import subprocess
import sys
import time
from pathlib import Path
from signal import SIGKILL

import pytest

from benchmarks.reliability.scene import as_run_records
from benchmarks.reliability.small_run import small_program
from planner.program import load_program, save_program
from planner.program.as_run import ENDED
from planner.program.as_run_film import load_as_run
from rig.executor.operations import list_operations
from rig.executor.session import run_session
from rig.machine_file import load_rig

WORKER = """
import sys
from pathlib import Path
from planner.program import load_program
from rig.executor.session import run_session
from rig.machine_file import load_rig
program, rig = load_program(sys.argv[1]), load_rig(sys.argv[2])
print("ready", flush=True)
while folder := sys.stdin.readline().strip():
    journal = Path(folder) / "journal.jsonl"
    begun = journal.exists() and b'"event":"session"' in journal.read_bytes()
    run_session(program, rig, Path(folder), resume=begun)
    print("finished", flush=True)
"""
PACE = 200.0
"""Machine time over wall time: the small run then takes two seconds, and kills fall evenly into its operations."""


class Killer:
    """Starts sessions in processes of their own, one ahead, and kills them."""

    def __init__(self, program: Path, rig: Path, rng: random.Random) -> None:
        self._command = [sys.executable, "-c", WORKER, str(program), str(rig)]
        self._rng = rng
        self.kills = 0

    def start(self) -> subprocess.Popen:
        return subprocess.Popen(self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def run_with_kills(self, folder: Path, kills: int) -> None:
        """Kill a run so many times, then let it finish.

        At this pace a slow host looks dead to the drivers now and then; what they tell is one more reason to resume.
        """
        for number in range(kills + 10):
            with self.start() as process:
                assert process.stdin is not None
                assert process.stdout is not None
                assert process.stdout.readline() == "ready\n"
                process.stdin.write(f"{folder}\n\n")
                process.stdin.flush()
                if number < kills:
                    time.sleep(self._rng.uniform(0.05, 1.2))
                    process.kill()
            self.kills += process.returncode == -SIGKILL
            if self._finished(folder):
                return
        raise AssertionError("it did not finish")

    def _finished(self, folder: Path) -> bool:
        path = folder / "journal.jsonl"
        entries = path.read_bytes().splitlines() if path.exists() else []
        return bool(entries) and b'"outcome":"finished"' in entries[-1]


def check_complete(folder: Path, program_path: Path, rig_path: Path) -> None:
    """Each operation ended exactly once, in order, and what ended is what the Program says."""
    program, rig = load_program(program_path), load_rig(rig_path)
    operations = list_operations(program, rig.machine)
    ended = [
        record for record in as_run_records(folder) if record["record"] == "operation" and record["outcome"] in ENDED
    ]
    assert [record["number"] for record in ended] == list(range(len(operations)))
    film = load_as_run(folder / "as-run.jsonl")
    for planned, made in zip(program.layers, film.program.layers, strict=True):
        assert [stroke.points_mm for stroke in made.passes] == [stroke.points_mm for stroke in planned.passes]


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    program, rig = tmp_path / "program.json", tmp_path / "RIG.toml"
    save_program(small_program(), program)
    text = (Path(load_rig.__code__.co_filename).parent / "machines" / "simulated.toml").read_text()
    rig.write_text(text.replace("pace = 0.0", f"pace = {PACE}"))
    return program, rig


def killed_runs(tmp_path: Path, files: tuple[Path, Path], *, runs: int, kills_each: int, seed: int) -> Killer:
    killer = Killer(*files, random.Random(seed))
    for number in range(runs):
        folder = tmp_path / f"run-{number}"
        killer.run_with_kills(folder, kills_each)
        check_complete(folder, *files)
    return killer


def test_a_few_kills(tmp_path: Path, files: tuple[Path, Path]) -> None:
    assert killed_runs(tmp_path, files, runs=1, kills_each=3, seed=1).kills >= 2


@pytest.mark.slow
def test_200_kills(tmp_path: Path, files: tuple[Path, Path]) -> None:
    killer = Killer(*files, random.Random(0))
    number = 0
    while killer.kills < 200:
        folder = tmp_path / f"run-{number}"
        killer.run_with_kills(folder, 8)
        check_complete(folder, *files)
        number += 1
    sys.stderr.write(f"{killer.kills} kills in {number} runs\n")


def test_a_journal_cut_at_any_byte_is_taken_up_without_loss_or_repetition(tmp_path: Path, files) -> None:
    program, rig = load_program(files[0]), load_rig()
    run_session(program, rig, tmp_path / "whole")
    journal = (tmp_path / "whole" / "journal.jsonl").read_bytes()
    begun = journal.index(b'"event":"session"')
    begun = journal.index(b"\n", begun) + 1
    rng = random.Random(2)
    for cut in sorted(rng.sample(range(begun, len(journal) - 200), 60)):
        folder = tmp_path / f"cut-{cut}"
        folder.mkdir()
        (folder / "journal.jsonl").write_bytes(journal[:cut])
        before = [json.loads(line) for line in journal[:cut].split(b"\n")[:-1]]
        done = {entry["op"] for entry in before if entry["event"] == "end"}
        run_session(program, rig, folder, resume=True)
        check_complete(folder, files[0], files[1])
        begun_again = [
            entry["op"]
            for entry in map(json.loads, (folder / "journal.jsonl").read_bytes().splitlines()[len(before) :])
            if entry["event"] == "begin"
        ]
        assert not done & set(begun_again), cut
