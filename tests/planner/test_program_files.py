import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.errors import InputError
from planner.program import (
    Actuate,
    CalibrationLimits,
    CalibrationRecord,
    CreatedBy,
    Cut,
    Film,
    Inputs,
    Layer,
    Pass,
    Program,
    ResetAlignment,
    SaturatingModel,
    load_program,
    program_schema,
    save_program,
)
from planner.program.geometry import self_crossing

SQUARE = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))


def record() -> CalibrationRecord:
    return CalibrationRecord(
        name="test",
        placeholder=True,
        provenance={"source": "made up"},
        limits=CalibrationLimits(
            load_g_min=0.5,
            load_g_max=6.5,
            speed_mm_s_min=0.5,
            speed_mm_s_max=2.0,
            radius_mm_min=1.8,
            radius_mm_max=14.4,
        ),
        model=SaturatingModel(load_scale_g=2.0, speed_exponent=0.4),
    )


def stroke(count: int = 3, y: float = 0.0, **changes: Any) -> Pass:
    values: dict[str, Any] = {
        "points_mm": tuple((-5 + 10 * i / (count - 1), y) for i in range(count)),
        "speed_mm_s": (1.0,) * (count - 1),
        "load_g": (3.0,),
        "side": "convex",
    }
    return Pass(**{**values, **changes})


def program(passes: tuple[Pass, ...] = (), **changes: Any) -> Program:
    passes = passes or (stroke(),)
    values: dict[str, Any] = {
        "name": "square",
        "seed": 7,
        "created_by": CreatedBy(name="tests", version="0"),
        "inputs": Inputs(method="manual", settings={"step_mm": 0.8, "order": True}),
        "calibration": record(),
        "film": Film(outline_mm=SQUARE, layer_thickness_mm=(0.2,) * 4),
        "layers": tuple(Layer.of(i, 0.2, passes if i < 2 else ()) for i in range(4)),
        "finish": (Cut(line_mm=((-6, -1), (6, -1), (6, 1), (-6, 1))), Actuate()),
    }
    return Program(**{**values, **changes})


def problems(**changes: Any) -> str:
    with pytest.raises(InputError) as caught:
        program(**changes)
    return str(caught.value)


def rewritten(path: Path, change: Any) -> Path:
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))
    return path


def test_a_round_trip_keeps_everything(tmp_path: Path) -> None:
    written = program()
    path = save_program(written, tmp_path / "program.json")
    assert load_program(path) == written
    assert load_program(tmp_path).digest == written.digest
    assert [entry.name for entry in tmp_path.iterdir()] == ["program.json"]


def test_lengths_and_times_of_a_pass() -> None:
    bent = stroke(points_mm=((0, 0), (3, 4), (3, 6)), speed_mm_s=(1.0, 2.0))
    assert bent.segment_lengths_mm == (5.0, 2.0)
    assert bent.length_mm == 7.0
    assert bent.scratch_s == 6.0


def test_the_digest_sees_one_changed_number(tmp_path: Path) -> None:
    path = save_program(program(), tmp_path / "program.json")
    rewritten(path, lambda d: d["layers"][0]["operations"][2]["passes"][0]["load_g"].__setitem__(0, 3.1))
    with pytest.raises(InputError, match="digest"):
        load_program(path)


def test_the_digest_does_not_depend_on_layout(tmp_path: Path) -> None:
    path = save_program(program(), tmp_path / "program.json")
    path.write_text(json.dumps(json.loads(path.read_text()), indent=3, sort_keys=True))
    assert load_program(path) == program()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d.update(schema_version="2.0"), ["schema_version", "'2.0'", "'1.0'"]),
        (lambda d: d.pop("seed"), ["seed", "missing"]),
        (lambda d: d.pop("digest"), ["digest", "None"]),
        (lambda d: d.update(sede=1), ["sede", "unknown field"]),
        (lambda d: d.update(seed="7"), ["seed", "'7'", "integer"]),
        (lambda d: d["layers"].pop(), ["3 layers", "4 values"]),
        (lambda d: d["layers"].reverse(), ["layers[0].index: found 3, allowed is 0"]),
        (lambda d: d["layers"][3]["operations"].pop(), ["layers[3].operations", "deposit, reset_alignment"]),
        (lambda d: d["film"]["layer_thickness_mm"].__setitem__(1, 0.1), ["layers[1]", "0.2 mm", "0.1 mm"]),
        (
            lambda d: d["layers"][1]["operations"][2]["passes"][0]["load_g"].__setitem__(0, -1),
            ["layers[1].operations[2].passes[0].load_g[0]", "-1", "greater than 0"],
        ),
        (lambda d: d["finish"].reverse(), ["finish", "actuate, cut"]),
        (lambda d: d["calibration"]["limits"].update(load_g_min=9), ["load_g_min is 9"]),
    ],
)
def test_a_wrong_file_says_where(tmp_path: Path, change: Any, words: list[str]) -> None:
    path = rewritten(save_program(program(), tmp_path / "program.json"), change)
    with pytest.raises(InputError) as caught:
        load_program(path)
    for word in [str(path), *words]:
        assert word in str(caught.value)


@pytest.mark.parametrize("content", ["", "[1, 2]", "{", "[" * 100_000, '"program"', "null", "\x00\x01", '{"a": NaN}'])
def test_what_is_no_program_is_refused(tmp_path: Path, content: str) -> None:
    path = tmp_path / "program.json"
    path.write_text(content)
    with pytest.raises(InputError, match=r"program\.json"):
        load_program(path)


def test_a_missing_file_and_a_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        load_program(tmp_path)
    with pytest.raises(InputError, match="cannot be written"):
        save_program(program(), tmp_path / "absent" / "program.json")


def test_passes_that_cannot_be_scratched() -> None:
    assert "2 segments" in problems(passes=(stroke(speed_mm_s=(1.0,)),))
    assert "each of its 3 points" in problems(passes=(stroke(load_g=(1.0, 2.0)),))
    assert "0.5 to 2 mm/s" in problems(passes=(stroke(speed_mm_s=(1.0, 2.5)),))
    assert "0.5 to 6.5 g" in problems(passes=(stroke(load_g=(7.0,)),))
    assert "outside the deposited region" in problems(passes=(stroke(y=10.1),))
    assert "repeats a point" in problems(passes=(stroke(points_mm=((0, 0), (0, 0), (1, 0))),))


def test_all_problems_at_once_and_repeated_ones_counted() -> None:
    text = problems(passes=(stroke(y=11), stroke(y=12), stroke(load_g=(9.0,))))
    assert len(text.splitlines()) == 4
    assert text.count("(and 1 more passes of this layer likewise)") == 2


def test_outlines_that_no_extruder_deposits() -> None:
    for outline in (SQUARE[::-1], ((0, 0), (9, 0), (2, 2), (0, 9)), ((0, 0), (1, 1), (2, 2))):
        film = Film(outline_mm=outline, layer_thickness_mm=(0.2,) * 4)
        assert "not a convex" in problems(film=film)


@pytest.mark.parametrize("step", [Actuate, ResetAlignment])
def test_temperatures_that_no_heater_is_told(step: type) -> None:
    with pytest.raises(ValueError, match="greater than 0"):
        step(temperature_c=0.0)


def test_cut_lines_that_no_scissors_follow() -> None:
    bow = Cut(line_mm=((-6, -1), (6, 1), (6, -1), (-6, 1)))
    assert "crosses itself" in problems(finish=(bow, Actuate()))
    notched = ((5, -6), (5, -3), (0, -3), (0, 3), (5, 3), (5, 6), (-5, 6), (-5, -6))
    for line in (notched, tuple((-y, x) for x, y in notched)):
        assert self_crossing(line) is None
    wide = Cut(line_mm=((-11, -1), (6, -1), (6, 1)))
    assert "outside the deposited region" in problems(finish=(wide, Actuate()))


def test_the_schema_names_the_contract() -> None:
    schema = program_schema()
    assert schema["properties"]["schema_version"]["const"] == "1.0"
    assert {"digest", "layers", "calibration", "finish"} <= set(schema["required"])
    assert schema["additionalProperties"] is False
    json.dumps(schema)


def test_a_full_program_survives_a_round_trip(tmp_path: Path) -> None:
    passes = tuple(stroke(count=30, y=-9 + 18 * i / 499) for i in range(500))
    path = save_program(program(passes), tmp_path / "program.json")
    assert load_program(path).layers[0].passes == passes


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-10, 10), st.floats(-10, 10)), min_size=2, max_size=5, unique=True),
    st.floats(0.5, 2.0),
    st.floats(0.5, 6.5),
)
def test_any_pass_inside_the_limits_survives_a_round_trip(
    tmp_path_factory: pytest.TempPathFactory, points: list[tuple[float, float]], speed: float, load: float
) -> None:
    one = Pass(points_mm=tuple(points), speed_mm_s=(speed,) * (len(points) - 1), load_g=(load,), side="concave")
    path = save_program(program((one,)), tmp_path_factory.mktemp("round") / "program.json")
    assert load_program(path).layers[0].passes == (one,)
