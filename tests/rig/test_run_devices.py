"""A small run with each of the devices that a rig may have."""

from pathlib import Path
from typing import Any

import pytest

from benchmarks.reliability.scene import as_run_records
from benchmarks.reliability.small_run import small_program
from planner.errors import InputError, RigError
from planner.program.as_run import ENDED
from rig.assembly import logged_in, open_rig
from rig.executor.interrupts import Interrupts, StoppedError
from rig.executor.prompts import SimulatedOperator
from rig.executor.session import run_session
from rig.executor.view import Moment
from rig.machine_file import SIMULATED_RIG, RigDescription, load_rig
from rig.transport import VirtualClock
from rig.virtual.machine import VirtualMachine

BALANCE = ('balance = "none"', 'balance = "sics"')
BALANCE_LINE = '[balance_line]\ntransport = "simulated"\nat_mm = [60.0, 0.0]\npan_mm = 1.0\n'
NAMUR = ('hot_plate = "simulated"', 'hot_plate = "namur"')
NAMUR_LINE = '[hot_plate_line]\ntransport = "simulated"\nwatchdog_s = 20\n'
MARLIN = (
    ('controller = "grbl"', 'controller = "marlin"'),
    ("origin_mm = [-100.0, -100.0, -25.0]", "origin_mm = [100.0, 100.0, 25.0]"),
)


def rig_of(folder: Path, *changes: tuple[str, str], more: str = "") -> RigDescription:
    text = SIMULATED_RIG.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / "RIG.toml"
    path.write_text(text + more)
    return load_rig(path)


def run(folder: Path, rig: RigDescription, **options: Any) -> tuple[VirtualMachine, list[dict]]:
    machine = VirtualMachine(rig, VirtualClock())
    run_session(small_program(), rig, folder / "run", virtual=machine, **options)
    return machine, [record for record in as_run_records(folder / "run") if record["record"] == "operation"]


def of_kind(operations: list[dict], kind: str) -> list[dict]:
    return [operation for operation in operations if operation["kind"] == kind]


def test_temperatures_ink_and_light_are_those_that_were_measured(tmp_path: Path) -> None:
    machine, operations = run(tmp_path, rig_of(tmp_path, ("warm_up_s = 0.0", "warm_up_s = 30.0")))
    for kind, wanted_c in (("reset_alignment", 120.0), ("actuate", 150.0)):
        for operation in of_kind(operations, kind):
            assert operation["temperature_c"] == pytest.approx(wanted_c, abs=2.5)
            assert operation["temperature_c"] != wanted_c
    assert [op["deposited_ml"] for op in of_kind(operations, "deposit")] == [pytest.approx(0.32, abs=0.001)] * 2
    for cure in of_kind(operations, "cure"):
        assert cure["end_s"] - cure["start_s"] == pytest.approx(40.0, abs=1.0)
    assert machine.lamp.dose_s() == pytest.approx(2 * (10 + 30 - 6), abs=0.5)  # the lamp's own time is 6 s


def test_a_plate_on_a_line_is_fed_while_it_holds(tmp_path: Path) -> None:
    program = small_program()
    finish = tuple(op.model_copy(update={"hold_s": 90.0}) if op.kind == "actuate" else op for op in program.finish)
    rig = rig_of(tmp_path, NAMUR, more=NAMUR_LINE)
    machine = VirtualMachine(rig, VirtualClock())
    run_session(program.model_copy(update={"finish": finish}), rig, tmp_path / "run", virtual=machine)
    assert machine.plate.error_2 is False
    assert machine.plate.heats is False
    assert machine.hot_plate.hottest_c == pytest.approx(150.0, abs=5.0)
    records = as_run_records(tmp_path / "run")
    session = next(record for record in records if record["record"] == "session")
    assert session["devices"]["hot_plate"] == "C-MAG HS7"
    assert (tmp_path / "run" / "wire-hot_plate.jsonl").stat().st_size > 0
    # identified before the stage moved
    assert machine.plate.log[0] == "IN_NAME"


def test_a_plate_that_is_not_there_is_told_before_anything_moves(tmp_path: Path) -> None:
    rig = rig_of(tmp_path, NAMUR, more=NAMUR_LINE)
    machine = VirtualMachine(rig, VirtualClock())
    machine.plate.deaf = True
    with pytest.raises(RigError, match="no NAMUR hot plate answers"):
        run_session(small_program(), rig, tmp_path / "run", virtual=machine)
    assert machine.grbl.motion.trace == []


def test_a_dead_element_ends_the_run_with_everything_off(tmp_path: Path) -> None:
    rig = rig_of(tmp_path)
    machine = VirtualMachine(rig, VirtualClock())
    machine.hot_air.broken_at_s = 0.0
    with pytest.raises(RigError, match=r"hot air rose from .* expected are"):
        run_session(small_program(), rig, tmp_path / "run", virtual=machine)
    assert machine.hot_air.target_c is None
    machine.hot_air.broken_at_s = float("inf")
    run_session(small_program(), rig, tmp_path / "run", virtual=machine, resume=True)


def test_the_balance_weighs_the_load_once_a_layer(tmp_path: Path) -> None:
    machine, operations = run(tmp_path, rig_of(tmp_path, BALANCE, more=BALANCE_LINE))
    weighed = {op["number"]: op["weighed_load_g"] for op in operations if op["weighed_load_g"] is not None}
    # 2 g less the guide's friction when loaded, 1 g more when unloaded from 3 g
    assert weighed == {2: pytest.approx(1.99, abs=0.005), 10: pytest.approx(1.01, abs=0.005)}
    assert machine.pan_g() == 0.0


def test_a_leak_that_no_counter_sees_is_told_by_the_balance(tmp_path: Path) -> None:
    class Emptied(SimulatedOperator):
        def confirm(self, question: str) -> bool:
            asked.append(question)
            if "empty now" in question:
                machine.pump.plunger.moved_ml = machine.pump.plunger.water_ml = 0.0
                machine._arrives = 1.0
            return True

    asked: list[str] = []
    rig = rig_of(tmp_path, BALANCE, ("pump_leak = 0.0", "pump_leak = 0.2"), more=BALANCE_LINE)
    machine = VirtualMachine(rig, VirtualClock())
    with pytest.raises(RigError, match=r"the balance shows 1\.59 g where 2\.00 g were counted"):
        run_session(small_program(), rig, tmp_path / "run", virtual=machine)
    assert machine.post_mm()[2] >= rig.machine.stage.lift_mm - 0.01
    # the tube is mended, the chamber emptied: the load is pumped anew
    run_session(small_program(), rig, tmp_path / "run", virtual=machine, resume=True, operator=Emptied())
    assert any("the balance shows" in question or "load was never read" in question for question in asked)
    strokes = of_kind([r for r in as_run_records(tmp_path / "run") if r["record"] == "operation"], "pass")
    assert strokes[0]["post_load_g"][0] == pytest.approx(2.0, abs=0.05)


def test_a_balance_on_the_film_is_refused(tmp_path: Path) -> None:
    rig = rig_of(tmp_path, BALANCE, more=BALANCE_LINE.replace("60.0", "15.0"))
    with pytest.raises(InputError, match=r"balance_line.at_mm: \(15, 0\) lies on the film"):
        run(tmp_path, rig)
    assert not (tmp_path / "run").exists()


def test_the_same_run_behind_a_marlin(tmp_path: Path) -> None:
    machine, operations = run(tmp_path, rig_of(tmp_path, *MARLIN))
    assert machine.marlin is not None
    assert all(operation["outcome"] in ENDED for operation in operations)
    strokes = of_kind(operations, "pass")
    assert strokes[0]["position_mm"] == pytest.approx((4.0, 0.0, 2.0), abs=0.005)
    assert strokes[0]["post_load_g"] is not None
    assert machine.post_mm()[2] == pytest.approx(2.0, abs=0.005)


def test_a_marlin_that_was_stopped_homes_and_goes_on(tmp_path: Path) -> None:
    class Stopping:
        def begin(self, moment: Moment) -> None:
            if moment.operation.number == 4:
                interrupts.wanted = "stop"

        def move(self, moment: Moment) -> None: ...

        def clear(self) -> None: ...

    interrupts, rig = Interrupts(), rig_of(tmp_path, *MARLIN)
    machine = VirtualMachine(rig, VirtualClock())
    with pytest.raises(StoppedError):
        run_session(small_program(), rig, tmp_path / "run", virtual=machine, interrupts=interrupts, view=Stopping())
    run_session(small_program(), rig, tmp_path / "run", virtual=machine, resume=True)
    ended = [r for r in as_run_records(tmp_path / "run") if r["record"] == "operation" and r["outcome"] in ENDED]
    assert [record["number"] for record in ended] == list(range(16))


def test_heat_is_off_before_a_dead_line_is_waited_for(tmp_path: Path) -> None:
    rig = rig_of(tmp_path)
    opened = open_rig(rig, SimulatedOperator(), wrap=logged_in(tmp_path))
    devices, machine = opened.devices, opened.virtual
    devices.stage.home()
    devices.load.load_g()
    devices.hot_plate.set_temperature(100.0)
    devices.lamp.turn_on()
    off_s = []

    machine.grbl.receive = machine.pump.receive = lambda data, now_s: None  # type: ignore[method-assign]
    regulate = machine.hot_plate.regulate

    def regulated(target_c: float | None, now_s: float) -> None:
        off_s.append(now_s)
        regulate(target_c, now_s)

    machine.hot_plate.regulate = regulated  # type: ignore[method-assign]
    begun_s = machine.clock.now_s()
    problems = devices.stop()
    assert [problem.partition(":")[0] for problem in problems] == ["stage", "pump"]
    assert off_s == [begun_s]
    assert not machine.lamp.shines
    assert machine.clock.now_s() - begun_s < 30.0
    opened.close()
