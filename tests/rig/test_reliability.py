"""Every fault once, at one of the operations in turn; and that the check itself can fail."""

import logging
from pathlib import Path

import pytest

from benchmarks.reliability.faults import FAULTS
from benchmarks.reliability.scene import Ended, Scene
from rig.path_audit import PathAudit
from rig.transport import Fault

STAGES = 16


def run(folder: Path, arm, stage: int) -> Ended:
    logging.getLogger("rig").setLevel(logging.ERROR)
    return Scene(folder / f"run-{stage}", arm, stage).run()


@pytest.mark.parametrize("place", range(len(FAULTS)), ids=list(FAULTS))
def test_a_fault_is_survived_or_told(tmp_path: Path, place: int) -> None:
    arm = list(FAULTS.values())[place]
    end = run(tmp_path, arm, (7 * place) % STAGES)
    assert end.finished
    assert not end.hung
    assert end.wrong == end.twice == end.missing == ()


def test_without_a_fault_nothing_is_told(tmp_path: Path) -> None:
    assert run(tmp_path, lambda scene: None, 0) == Ended(
        finished=True, told=(), wrong=(), twice=(), missing=(), hung=False
    )


def test_lost_steps_and_water_that_came_from_elsewhere_are_seen_by_the_check(tmp_path: Path) -> None:
    def lose_steps(scene: Scene) -> None:
        scene.machine.grbl.offset_steps = (40, 0, 0)

    def add_water(scene: Scene) -> None:
        scene.machine.pump.plunger.moved_ml += 0.5

    assert any("wrong by (40, 0, 0) steps" in text for text in run(tmp_path / "a", lose_steps, 4).wrong)
    assert any("chamber holds 2.5" in text for text in run(tmp_path / "b", add_water, 4).wrong)


def test_a_lamp_that_stays_dark_and_a_clogged_nozzle_are_seen_by_the_check(tmp_path: Path) -> None:
    def burn_out(scene: Scene) -> None:
        scene.machine.lamp.burnt_out = True

    def clog(scene: Scene) -> None:
        scene.machine.extruder.flow_ml_min /= 2

    assert any("was cured for 0.00 s, not 10" in text for text in run(tmp_path / "a", burn_out, 7).wrong)
    assert any("has 0.160 cm3 of ink" in text for text in run(tmp_path / "b", clog, 8).wrong)


def test_without_the_position_audit_wrong_positions_are_silent(tmp_path: Path, monkeypatch) -> None:
    def flip(at: int):
        return lambda scene: scene.lines["stage"].arm(Fault(kind="flip", way="out", at=at, bit=2))

    assert not any(run(tmp_path / f"with-{at}", flip(at), 3).wrong for at in range(40))
    monkeypatch.setattr(PathAudit, "on_path", lambda *_: None)
    monkeypatch.setattr(PathAudit, "at_end", lambda *_: None)
    assert any(run(tmp_path / f"without-{at}", flip(at), 3).wrong for at in range(40))
