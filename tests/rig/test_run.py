"""A small run: what is listed, done, written down, refused, paused and asked."""

from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.reliability.scene import BoundedClock, Scene, as_run_records
from benchmarks.reliability.small_run import small_program, small_rig
from planner.errors import InputError, RigError
from planner.program import Pass, layer_times
from planner.program.as_run_film import load_as_run
from rig.executor import session
from rig.executor.interlocks import Guard
from rig.executor.interrupts import Interrupts, PausedError
from rig.executor.machine import Devices
from rig.executor.operations import list_operations
from rig.executor.prompts import SimulatedOperator
from rig.executor.session import run_session
from rig.executor.view import Moment, Unseen
from rig.machine_file import RigDescription
from rig.machine_sections import Interlocks
from rig.virtual.machine import VirtualMachine

KINDS = (
    *("deposit", "reset_alignment", "load", "pass", "pass", "load", "pass", "cure"),
    *("deposit", "reset_alignment", "load", "pass", "cure"),
    *("load", "cut", "actuate"),
)


def operations_of(folder: Path) -> list[dict]:
    return [record for record in as_run_records(folder) if record["record"] == "operation"]


def at(stage: int, folder: Path, arm: Callable[[Scene], None]) -> Scene:
    return Scene(folder / "run", arm, stage)


def test_the_operations_of_a_program() -> None:
    operations = list_operations(small_program(), small_rig().machine)
    assert tuple(operation.kind for operation in operations) == KINDS
    assert [operation.number for operation in operations] == list(range(len(KINDS)))
    assert operations[3].title == "layer 1: pass 0, 8.0 mm"


def test_a_run_says_what_was_done(tmp_path: Path) -> None:
    program, rig = small_program(), small_rig()
    ran = run_session(program, rig, tmp_path / "run")
    film = load_as_run(tmp_path / "run" / "as-run.jsonl")
    assert film.planned == program
    assert film.notes == ()
    for planned, made, time, waits in zip(
        program.layers, film.program.layers, layer_times(program, rig.machine), film.pass_to_cure_s, strict=True
    ):
        assert [stroke.points_mm for stroke in made.passes] == [stroke.points_mm for stroke in planned.passes]
        assert [stroke.speed_mm_s for stroke in made.passes] == [stroke.speed_mm_s for stroke in planned.passes]
        for a, b in zip(planned.passes, made.passes, strict=True):
            assert b.load_g == pytest.approx(a.load_g if len(b.load_g) > 1 else a.load_g[:1], abs=0.2)
        # the model counts neither the wire nor the water's rest
        assert waits == pytest.approx(time.pass_to_cure_s, abs=8.0)
    records = as_run_records(tmp_path / "run")
    assert [record["record"] for record in records[:2]] == ["program", "answer"]
    assert records[-1] == {"record": "end", "at_s": pytest.approx(ran.run_s), "outcome": "finished", "message": ""}
    session_record = next(record for record in records if record["record"] == "session")
    assert session_record["devices"]["stage"].startswith("1.1")
    assert session_record["devices"]["pump"].startswith("NE1000")
    assert session_record["simulated"] is True
    strokes = [record for record in operations_of(tmp_path / "run") if record["kind"] == "pass"]
    assert all(record["post_load_g"] for record in strokes)
    assert strokes[0]["load_g"] == pytest.approx(2.0, abs=0.003)
    assert strokes[0]["position_mm"] == pytest.approx((4, 0, 2), abs=0.005)


def test_a_program_that_fails_its_preflight_opens_nothing(tmp_path: Path, monkeypatch) -> None:
    def opened(*_, **__):
        raise AssertionError("a port was opened")

    monkeypatch.setattr(session, "open_rig", opened)
    program, rig = small_program(), small_rig()
    stage = rig.machine.stage.model_copy(update={"x_mm": (-3.0, 3.0), "scratch_speed_mm_s": (0.1, 0.5)})
    machine = rig.machine.model_copy(update={"stage": stage})
    with pytest.raises(InputError) as caught:
        run_session(program, type(rig)(file=rig.file, machine=machine), tmp_path / "run")
    assert len(caught.value.problems) == 4
    assert not (tmp_path / "run").exists()


def test_a_folder_with_a_run_in_it(tmp_path: Path) -> None:
    program, rig, folder = small_program(), small_rig(), tmp_path / "run"
    with pytest.raises(InputError, match="holds no run that was begun"):
        run_session(program, rig, folder, resume=True)
    interrupted = at(4, tmp_path, lambda scene: scene.interrupts.pause())
    interrupted.operator.refusals = 0
    interrupted._session(resume=False)
    with pytest.raises(InputError, match="finished run"):
        run_session(program, rig, folder)
    with pytest.raises(InputError, match="is finished"):
        run_session(program, rig, folder, resume=True)


def test_an_unfinished_run_wants_resume_and_the_same_program_and_rig(tmp_path: Path) -> None:
    def refuse(scene: Scene) -> None:
        scene.operator.refusals = 1
        scene.interrupts.pause()

    scene = at(4, tmp_path, refuse)
    with pytest.raises(PausedError, match="paused before layer 1: load 3 g"):
        scene._session(resume=False)
    assert scene.machine.lamp.dose_s() == 0
    program, rig, folder = small_program(), small_rig(), tmp_path / "run"
    with pytest.raises(InputError, match="unfinished run; go on with it with --resume"):
        run_session(program, rig, folder)
    with pytest.raises(InputError, match="another Program"):
        run_session(program.model_copy(update={"name": "other"}), rig, folder, resume=True)
    weak = rig.file.simulated.model_copy(update={"post_friction_g": 1.0})
    other = type(rig)(file=rig.file.model_copy(update={"simulated": weak}), machine=rig.machine)
    with pytest.raises(InputError, match="another rig file"):
        run_session(program, other, folder, resume=True)
    line = rig.file.stage.model_copy(update={"port": "/dev/ttyUSB7"})
    renamed = type(rig)(file=rig.file.model_copy(update={"stage": line}), machine=rig.machine)
    assert run_session(program, renamed, folder, resume=True).sessions == 2


def test_a_run_that_needs_nobody_pauses_all_the_same(tmp_path: Path) -> None:
    class Pausing(Unseen):
        def begin(self, moment: Moment) -> None:
            if moment.operation.number == 4:
                interrupts.pause()

    interrupts, program, rig = Interrupts(), small_program(), small_rig()
    with pytest.raises(PausedError, match="paused before layer 1: load 3 g"):
        run_session(program, rig, tmp_path / "run", view=Pausing(), interrupts=interrupts)
    assert run_session(program, rig, tmp_path / "run", resume=True).sessions == 2


def test_a_disturbed_stroke_is_offered_for_redo(tmp_path: Path) -> None:
    def hold(scene: Scene) -> None:
        scene.on_move += [
            lambda data=data: scene.machine.grbl.receive(data, scene.now_s)
            for data in (*[b""] * 45, b"!", b"", b"", b"~")
        ]

    for yes in (True, False):
        folder = tmp_path / str(yes)
        scene = at(3, folder, hold)
        answers = []
        scene.operator.confirm = lambda question, answers=answers, yes=yes: (  # type: ignore[method-assign]
            answers.append(question) or (yes if "Scratch it again" in question else True)
        )
        assert scene.run().finished
        attempts = [(op["attempt"], op["outcome"]) for op in operations_of(folder / "run") if op["number"] == 3]
        assert attempts == ([(1, "spoiled"), (2, "done")] if yes else [(1, "spoiled")])


def test_a_disturbed_stroke_is_offered_again_if_the_host_dies_before_its_redo(tmp_path: Path) -> None:
    def hold(scene: Scene) -> None:
        scene.on_move += [
            lambda data=data: scene.machine.grbl.receive(data, scene.now_s)
            for data in (*[b""] * 45, b"!", b"", b"", b"~")
        ]

    for yes in (True, False):
        folder = tmp_path / str(yes)
        scene, asked = at(3, folder, hold), []

        def confirm(question: str, scene=scene, asked=asked, yes=yes) -> bool:
            if "Scratch it again" not in question:
                return True
            asked.append(question)
            if len(asked) == 1:
                scene.kill()
            return yes

        scene.operator.confirm = confirm  # type: ignore[method-assign]
        ended = scene.run()
        assert ended.finished
        assert ended.wrong == ()
        assert len(asked) == 2
        attempts = [(op["attempt"], op["outcome"]) for op in operations_of(folder / "run") if op["number"] == 3]
        assert attempts == ([(1, "spoiled"), (2, "done")] if yes else [(1, "spoiled")])


def test_the_pot_life_is_watched(tmp_path: Path) -> None:
    asked, told = [], []

    def age(scene: Scene) -> None:
        scene.machine.clock.sleep(11_000.0)
        scene.operator.confirm = lambda question: bool(asked.append(question))  # type: ignore[method-assign]
        scene.operator.tell = told.append  # type: ignore[method-assign]

    scene = at(5, tmp_path, age)
    with pytest.raises(PausedError, match="older than its alignment lasts"):
        scene._session(resume=False)
    assert "min old and their alignment" in asked[0]
    assert scene.machine.lamp.dose_s() == 0


def test_a_layer_over_its_budget_is_noted(tmp_path: Path) -> None:
    scene = at(5, tmp_path, lambda scene: scene.machine.clock.sleep(4000.0))
    assert scene.run().finished
    notes = [record["text"] for record in as_run_records(tmp_path / "run") if record["record"] == "note"]
    assert len(notes) == 1
    assert "its first passes fade a little" in notes[0]


def test_an_open_enclosure_keeps_the_lamp_dark(tmp_path: Path) -> None:
    def open_it(scene: Scene) -> None:
        scene.machine.enclosure.door_is_closed = False

    scene = at(0, tmp_path, open_it)
    with pytest.raises(RigError, match="enclosure is open"):
        scene._session(resume=False)
    assert scene.machine.lamp.dose_s() == 0
    assert scene.machine.hot_air.target_c is None


def test_an_enclosure_that_is_opened_while_it_cures_turns_the_lamp_off(tmp_path: Path) -> None:
    scene = at(99, tmp_path, lambda scene: None)
    switch = scene.machine.lamp.switch

    def switched(*, on: bool) -> None:
        switch(on=on)
        scene.machine.enclosure.door_is_closed = False

    scene.machine.lamp.switch = switched  # type: ignore[method-assign]
    with pytest.raises(RigError, match="enclosure is open"):
        scene._session(resume=False)
    assert scene.machine.lamp.dose_s() == pytest.approx(1.0)


def test_a_pump_that_somebody_ran_stops_the_run_before_the_pass(tmp_path: Path) -> None:
    def run_pump(scene: Scene) -> None:
        scene.machine.pump.plunger._counted_ml["INF"] += 0.1

    scene = at(3, tmp_path, run_pump)
    with pytest.raises(RigError, match=r"load is 2\.\d+ g by the pump's counters and the pass needs 2.000 g"):
        scene._session(resume=False)


class Fake:
    """Any device, that notes what it is told."""

    def __init__(self, name: str, told: list[str], *, fails: bool = False) -> None:
        self._name, self._told, self._fails = name, told, fails

    def stop(self) -> None:
        self._told.append(self._name)
        if self._fails:
            raise RigError(f"{self._name} does not answer")

    turn_off = stop

    def say_stop(self) -> None:
        self._told.append(f"{self._name}: say")
        if self._fails:
            raise RigError(f"{self._name} does not answer")

    def position_mm(self) -> tuple[float, float, float]:
        return (0.0, 0.0, 0.5)


def fakes(told: list[str], *fail: str) -> Devices:
    names = ("stage", "load", "extruder", "lamp", "hot_air", "hot_plate", "enclosure")
    made = {name: Fake(name, told, fails=name in fail) for name in names}
    return Devices(
        clock=BoundedClock(),
        operator=SimulatedOperator(),
        audited_load=lambda: None,
        connect=lambda: None,
        identities=dict,
        **made,  # type: ignore[arg-type]
    )


def test_everything_is_stopped_in_order_whatever_fails() -> None:
    told: list[str] = []
    problems = fakes(told, "stage", "hot_air").stop()
    assert told == ["stage: say", "load: say", "extruder", "hot_air", "lamp", "hot_plate", "stage", "load"]
    assert problems == ["stage: stage does not answer", "hot air: hot_air does not answer"]


def test_interlocks_want_the_post_up() -> None:
    guard = Guard(fakes([]), Interlocks(), small_rig().machine, tolerance_g=0.005, watched=True)
    with pytest.raises(RigError, match=r"0\.500 mm above the film.*hot air"):
        guard.before_hot_air()
    with pytest.raises(RigError, match="press into the film"):
        guard.before_load_change()


@pytest.mark.parametrize("stage", [2, 3, 7])
def test_a_stop_takes_a_bounded_time(tmp_path: Path, stage: int) -> None:
    times = []

    def stop(scene: Scene) -> None:
        times.append(scene.now_s)
        scene.interrupts.wanted = "stop"

    scene = at(stage, tmp_path, stop)
    with pytest.raises(RigError, match="stopped in the middle"):
        scene._session(resume=False)
    assert scene.now_s - times[0] < 5.0


def test_a_stop_with_dead_lines_takes_a_bounded_time(tmp_path: Path) -> None:
    times = []

    def deaden(scene: Scene) -> None:
        times.append(scene.now_s)
        for line in scene.lines.values():
            line.change_in = None
            line.read = lambda timeout_s: scene.machine.clock.sleep(timeout_s) or b""  # type: ignore[method-assign]

    scene = at(7, tmp_path, deaden)  # the cure: lamp on
    with pytest.raises(RigError):
        scene._session(resume=False)
    assert not scene.machine.lamp.shines
    assert scene.now_s - times[0] < 60.0


def rig_with(**simulated: float) -> RigDescription:
    rig = small_rig()
    changed = rig.file.simulated.model_copy(update=simulated)
    return RigDescription(file=rig.file.model_copy(update={"simulated": changed}), machine=rig.machine)


def test_a_post_that_sticks_shows_in_the_log_and_not_in_the_counters(tmp_path: Path) -> None:
    run_session(small_program(), rig_with(post_friction_g=0.8), tmp_path / "run")
    passes = [op for op in operations_of(tmp_path / "run") if op["kind"] == "pass"]
    assert passes[0]["load_g"] == pytest.approx(2.0, abs=0.003)
    assert passes[0]["post_load_g"][0] == pytest.approx(1.2, abs=0.05)
    assert passes[3]["post_load_g"][0] == pytest.approx(1.8, abs=0.05)  # unloaded from 3 g to 1 g
    film = load_as_run(tmp_path / "run" / "as-run.jsonl")
    assert film.program.layers[0].passes[0].load_g == pytest.approx((1.2,), abs=0.05)


def test_a_pump_that_leaks_shows_in_the_log_and_not_in_the_counters(tmp_path: Path) -> None:
    run_session(small_program(), rig_with(pump_leak=0.8), tmp_path / "run")
    first = next(op for op in operations_of(tmp_path / "run") if op["kind"] == "pass")
    assert first["load_g"] == pytest.approx(2.0, abs=0.003)
    assert first["post_load_g"][0] == pytest.approx(0.4, abs=0.05)
    film = load_as_run(tmp_path / "run" / "as-run.jsonl")
    assert film.pass_strength[1][0] < 1  # 0.2 g is below what was calibrated


def test_a_pass_that_was_left_in_the_middle_counts_as_far_as_it_was_seen(tmp_path: Path) -> None:
    def stop_later(scene: Scene) -> None:
        scene.on_move += [lambda: None] * 20 + [scene.interrupts.stop]
        scene.operator.confirm = lambda question: "from its start" not in question  # type: ignore[method-assign]

    scene = at(4, tmp_path, stop_later)
    assert scene.run().told
    film = load_as_run(tmp_path / "run" / "as-run.jsonl")
    left, whole = film.program.layers[0].passes[1], small_program().layers[0].passes[1]
    assert isinstance(left, Pass)
    assert left.points_mm == whole.points_mm[:2]


def test_a_virtual_machine_is_fresh() -> None:
    assert VirtualMachine(small_rig(), BoundedClock()).force_g() < 0.1
