from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.calibration import load_calibration
from planner.errors import InputError
from planner.program import (
    Actuate,
    CreatedBy,
    Cure,
    Cut,
    Deposit,
    Film,
    Inputs,
    Layer,
    Machine,
    Pass,
    Program,
    ResetAlignment,
    Scratch,
    check,
    layer_times,
    load_machine,
    split_layer,
)
from planner.program.machine import PAPER_MACHINE
from planner.program.timing import move_s, pass_s, scratch_time

SQUARE = ((-100.0, -100.0), (100.0, -100.0), (100.0, 100.0), (-100.0, 100.0))


def line(y: float, *, x: tuple[float, float] = (-10.0, 10.0), speed: float = 1.0, load: float = 3.0) -> Pass:
    return Pass(points_mm=((x[0], y), (x[1], y)), speed_mm_s=(speed,), load_g=(load,), side="convex")


def program(*layers: tuple[Pass, ...], **changes: Any) -> Program:
    values: dict[str, Any] = {
        "name": "lines",
        "seed": 0,
        "created_by": CreatedBy(name="tests", version="0"),
        "inputs": Inputs(method="manual"),
        "calibration": load_calibration().record,
        "film": Film(outline_mm=SQUARE, layer_thickness_mm=(0.2,) * len(layers)),
        "layers": tuple(Layer.of(i, 0.2, passes) for i, passes in enumerate(layers)),
        "finish": (Cut(line_mm=((-9, -9), (9, -9), (9, 9))), Actuate()),
    }
    return Program(**{**values, **changes})


def changed(**parts: dict[str, Any]) -> Machine:
    machine = load_machine()
    return machine.model_copy(
        update={name: getattr(machine, name).model_copy(update=values) for name, values in parts.items()}
    )


def test_the_paper_machine_has_the_published_limits() -> None:
    machine = load_machine()
    assert machine.stage.scratch_speed_mm_s == (0.5, 2.0)
    assert machine.pump.load_g_max == 6.5
    assert machine.layer.budget_s == 3600
    assert machine.pump.change_s(6.0) == pytest.approx(36.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("x_mm = [-75.0, 75.0]", "x_mm = [75.0, -75.0]", ["stage", "x_mm"]),
        ("rate_ml_min = 10.0", "rate_ml_min = 0", ["pump.rate_ml_min", "greater than 0"]),
        ("ml_per_g", "ml_per_gram", ["pump.ml_per_gram", "unknown field"]),
        ("[heat]", "[heat", ["not valid TOML"]),
        ("lift_max_mm = 20.0", "lift_max_mm = 1.0", ["lift_mm is 2"]),
    ],
)
def test_a_wrong_machine_file_says_where(tmp_path: Path, old: str, new: str, words: list[str]) -> None:
    path = tmp_path / "machine.toml"
    text = PAPER_MACHINE.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_machine(path)
    for word in ["machine.toml", *words]:
        assert word in str(caught.value)


def test_moves_from_rest_to_rest() -> None:
    # 10 mm/s at 100 mm/s2: 0.1 s and 0.5 mm each for speeding up and braking.
    assert move_s(11, 10, 100) == pytest.approx(0.1 + 1.0 + 0.1)
    assert move_s(0.25, 10, 100) == pytest.approx(2 * (0.25 / 100) ** 0.5)
    assert move_s(1.0, 10, 100) == pytest.approx(0.2)
    assert move_s(0, 10, 100) == 0


def test_a_pass_pays_for_its_speed_changes() -> None:
    stage = changed(stage={"acceleration_mm_s2": 10.0}).stage
    stroke = Pass(points_mm=((0, 0), (4, 0), (6, 0)), speed_mm_s=(2.0, 1.0), load_g=(1.0,), side="convex")
    # 2 s + 2 s, and 0 -> 2: 0.1 s, 2 -> 1 within the first segment: 0.025 s, 1 -> 0: 0.05 s.
    assert pass_s(stroke, stage) == pytest.approx(4 + 0.1 + 0.025 + 0.05)


def test_a_layer_adds_motion_travel_and_load() -> None:
    machine = load_machine()
    time = scratch_time((line(0), line(1, load=4.0)), machine)
    lift = 2.0 / 5 + 5 / 100
    # From (10, 0) back to (-10, 1): 20.025 mm at 20 mm/s.
    assert time.travel_s == pytest.approx(2 * lift + 401**0.5 / 20 + 20 / 100)
    assert time.motion_s == pytest.approx(2 * (20 + 1 / 100))
    assert time.load_s == pytest.approx(6 * 3 + 6 * 1)
    assert time.pass_to_cure_s[1] == pytest.approx(10.005)
    assert time.pass_to_cure_s[0] == pytest.approx(10.005 + time.travel_s + 6 + 20.01)


def test_the_load_stays_from_layer_to_layer() -> None:
    times = layer_times(program((line(0),), (), (line(0, load=3.5),)), load_machine())
    assert [time.load_s for time in times] == pytest.approx([18.0, 0.0, 3.0])
    assert times[1].total_s == 0


def test_a_program_within_limits_has_no_problems() -> None:
    assert check(program((line(0),), ()), load_machine()) == ()


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"stage": {"x_mm": (-5.0, 75.0)}}, ["x = -10.000 mm", "-5 to 75 mm"]),
        ({"stage": {"y_mm": (-75.0, -5.0)}}, ["y = 0.000 mm"]),
        ({"stage": {"scratch_speed_mm_s": (1.5, 2.0)}}, ["1 mm/s", "1.5 to 2 mm/s"]),
        ({"pump": {"load_g_max": 2.0}}, ["3 g", "2 g"]),
        ({"pump": {"syringe_ml": 2.5}}, ["3 mL", "2.5 mL"]),
        ({"heat": {"hot_air_c_max": 100.0}}, ["hot air", "120 C", "100 C"]),
        ({"heat": {"hot_plate_c_max": 100.0}}, ["plate", "150 C", "100 C"]),
        ({"heat": {"lamp_wavelength_nm": 405.0}}, ["365 nm", "405 nm"]),
    ],
)
def test_what_the_machine_cannot_do_is_an_error(parts: dict[str, Any], words: list[str]) -> None:
    problems = check(program((line(0), line(0.8))), changed(**parts))
    assert len(problems) == 1
    assert problems[0].severity == "error"
    for word in words:
        assert word in problems[0].message


def test_repeated_faults_are_counted_and_all_are_collected() -> None:
    machine = changed(pump={"load_g_max": 2.0}, heat={"lamp_wavelength_nm": 405.0})
    problems = check(program((line(0), line(1), line(2))), machine)
    assert len(problems) == 2
    assert "and 2 more passes" in problems[0].message
    assert problems[0].where == "layers[0], pass 0"


def test_a_load_that_changes_faster_than_the_pump() -> None:
    stroke = Pass(points_mm=((0, 0), (5, 0)), speed_mm_s=(1.0,), load_g=(1.0, 2.0), side="convex")
    problems = check(program((stroke,)), load_machine())
    assert "the pump needs 6.0 s" in problems[0].message
    assert not check(program((stroke,)), changed(pump={"rate_ml_min": 20.0}))


def test_own_temperatures_are_checked_where_they_stand() -> None:
    hot = Layer(index=0, operations=(Deposit(thickness_mm=0.2), ResetAlignment(temperature_c=300), Cure()))
    problems = check(program((), layers=(hot,)), load_machine())
    assert problems[0].where == "layers[0].operations[1]"


def test_a_layer_over_budget_is_a_warning_with_its_split() -> None:
    passes = tuple(line(0.8 * i, speed=0.5) for i in range(-50, 50))
    problems = check(program(passes), load_machine())
    assert [problem.severity for problem in problems] == ["warning"]
    assert "scratching takes 70 min, the budget is 60 min" in problems[0].message
    assert "2 segments (y below -0.4 mm: 35 min; y above -0.4 mm: 35 min)" in problems[0].message


def test_a_layer_beyond_the_life_of_its_alignment_is_an_error() -> None:
    passes = tuple(line(0.8 * i, speed=0.5) for i in range(-50, 50))
    problems = check(program(passes), changed(layer={"alignment_life_s": 4000.0}))
    assert [problem.severity for problem in problems] == ["error"]
    assert "loses its first passes" in problems[0].message


def test_a_pass_that_alone_breaks_the_budget() -> None:
    problems = check(program((line(0), line(5))), changed(layer={"budget_s": 10.0}))
    assert "one pass alone takes longer" in problems[0].message


def test_a_layer_that_fits_is_one_segment() -> None:
    (segment,) = split_layer((line(0), line(1)), load_machine())
    assert segment.passes == (0, 1)
    assert split_layer((), load_machine()) == ()


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=2, max_size=30),
    st.floats(60.0, 600.0),
)
def test_segments_share_all_passes_and_fit(places: list[tuple[float, float]], budget: float) -> None:
    passes = tuple(line(y, x=(x, x + 10)) for x, y in places)
    segments = split_layer(passes, changed(layer={"budget_s": budget}))
    assert sorted(i for segment in segments for i in segment.passes) == list(range(len(passes)))
    assert all(segment.scratch_s <= budget for segment in segments)


def test_scratch_free_layers_take_no_time() -> None:
    assert scratch_time((), load_machine()).total_s == 0
    assert Layer.of(0, 0.2).passes == ()
    assert isinstance(Layer.of(0, 0.2, (line(0),)).operations[2], Scratch)
