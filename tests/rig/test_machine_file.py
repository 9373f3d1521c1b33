"""The rig's file: what is read, and that all mistakes are told at once."""

from pathlib import Path

import pytest

from benchmarks.reliability.small_run import small_program
from planner.errors import InputError
from planner.program import load_machine
from planner.program.machine import PAPER_MACHINE
from rig.executor.session import preflight
from rig.machine_file import SIMULATED_RIG, load_rig
from rig.pump_load import PumpLoad
from rig.transport import SimulatedTransport, VirtualClock
from rig.virtual.new_era import VirtualPump


def edited(folder: Path, *changes: tuple[str, str]) -> Path:
    text = SIMULATED_RIG.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / "RIG.toml"
    path.write_text(text)
    return path


def problems(path: Path) -> tuple[str, ...]:
    with pytest.raises(InputError) as caught:
        load_rig(path)
    return caught.value.problems


def test_the_example_is_the_papers_machine_and_its_pump_can_be_driven() -> None:
    rig = load_rig()
    assert rig.machine == load_machine()
    assert rig.file.lamp == "simulated"
    pump = VirtualPump()
    load = PumpLoad(SimulatedTransport(pump, VirtualClock()), rig.pump_setup())
    load.set_load(rig.machine.pump.load_g_max)
    load.wait_settled(60.0)
    assert pump.safe_s == 30
    assert pump.plunger.moved_ml == pytest.approx(6.5, abs=0.001)


def test_basic_mode_has_no_watchdog(tmp_path: Path) -> None:
    assert load_rig(edited(tmp_path, ('mode = "safe"', 'mode = "basic"'))).pump_setup().watchdog_s == 0


def test_all_mistakes_are_told_at_once(tmp_path: Path) -> None:
    found = problems(
        edited(
            tmp_path,
            ('lamp = "simulated"', 'lamp = "wired"'),
            ("address = 0", "address = 100"),
            ("watchdog_s = 30", "watchdog_s = 5"),
            ("hot_air_needs_lifted_post", "hot_air_needs_luck"),
            ('[stage]\ntransport = "simulated"', '[stage]\ntransport = "serial"'),
            ("baud = 19200", 'baud = "fast"'),
        )
    )
    text = "\n".join(found)
    assert len(found) == 6
    for place in ("lamp", "pump.address", "pump.watchdog_s", "interlocks.hot_air_needs_luck", "stage", "pump.baud"):
        assert f"RIG.toml: {place}: " in text
    assert "port is missing" in text


def test_mistakes_between_the_parts(tmp_path: Path) -> None:
    machine = tmp_path / "wide.toml"
    machine.write_text(PAPER_MACHINE.read_text().replace("syringe_ml = 10.0", "syringe_ml = 5.0"))
    found = problems(
        edited(
            tmp_path,
            ('machine = "paper" ', 'machine = "wide.toml" '),
            ('transport = "simulated"', 'transport = "serial"'),
            ("# port", "port"),
            ("syringe_diameter_mm = 15.9", "syringe_diameter_mm = 14.43"),
        )
    )
    assert len(found) == 3
    assert "the stage's port too" in found[0]
    assert "8.341 mL/min" in found[1]
    assert "pump.syringe_ml = 5" in found[2]


def test_a_machine_that_is_not_there(tmp_path: Path) -> None:
    (problem,) = problems(edited(tmp_path, ('machine = "paper" ', 'machine = "gone.toml" ')))
    assert f"{tmp_path / 'gone.toml'}: no such machine file" in problem


def test_what_the_peripherals_need_is_told_at_once(tmp_path: Path) -> None:
    port = 'transport = "serial"\nport = "/dev/ttyUSB7"\n'
    found = problems(
        edited(
            tmp_path,
            ('hot_plate = "simulated"', 'hot_plate = "namur"'),
            ('balance = "none"', 'balance = "sics"'),
            ("[deposition]\nflow_ml_min = 1.0", f"[balance_line]\n{port}at_mm = [70.0, 0.0]\npan_mm = 1.0\n"),
            ('[pump]\ntransport = "simulated"\n', f"[pump]\n{port}"),
        )
    )
    assert len(found) == 3
    assert "balance_line.port is '/dev/ttyUSB7', which is the pump's port too" in found[0]
    assert "extruder is 'simulated', but section [deposition] is missing" in found[1]
    assert "hot_plate is 'namur', but section [hot_plate_line] is missing" in found[2]


def test_bounds_of_the_peripherals_are_named(tmp_path: Path) -> None:
    plate = '[hot_plate_line]\ntransport = "simulated"\nwatchdog_s = 5\n'
    found = problems(
        edited(
            tmp_path,
            ("flow_ml_min = 1.0", "flow_ml_min = 0.0"),
            ("warm_up_s = 0.0", "warm_up_s = -1"),
            ("within_s = 60.0", "within_s = 1.0"),
            ("[interlocks]", f"{plate}\n[interlocks]"),
            ('enclosure = "simulated"', 'enclosure = "open"'),
        )
    )
    text = "\n".join(found)
    assert len(found) == 5
    for place, bound in (
        ("deposition.flow_ml_min", "greater than 0"),
        ("curing.warm_up_s", "0"),
        ("heating.within_s", "5"),
        ("hot_plate_line.watchdog_s", "20"),
        ("enclosure", "simulated"),
    ):
        (line,) = [line for line in found if place in line]
        assert bound in line, text


def test_simulated_devices_beside_real_ones_are_told(tmp_path: Path) -> None:
    assert not preflight(small_program(), load_rig())
    line = 'transport = "serial"\nport = "/dev/absent"'
    path = edited(
        tmp_path, ('[stage]\ntransport = "simulated"', f"[stage]\n{line}"), ('lamp = "simulated"', 'lamp = "operator"')
    )
    told = preflight(small_program(), load_rig(path))
    assert [problem.where for problem in told] == [
        f"rig, {name}" for name in ("extruder", "hot_air", "hot_plate", "enclosure")
    ]
    assert all(problem.severity == "warning" for problem in told)
    assert "nothing guards the UV light" in told[-1].message
