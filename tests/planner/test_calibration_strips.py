"""Reading measured strips: every fault of a file told at once, each with its place."""

from pathlib import Path

import numpy as np
import pytest

from planner.calibration import read_strips
from planner.errors import InputError

HEADER = "load_g,speed_mm_s,radius_mm,side,width_mm,repeat"
ROWS = [f"{load},{speed},{2 + 3 / load + speed},bottom,8,1" for load in (0.5, 1, 2, 4) for speed in (0.5, 1, 2)]


def file_of(tmp_path: Path, lines: list[str], encoding: str = "utf-8") -> Path:
    path = tmp_path / "strips.csv"
    path.write_bytes(("\n".join(lines) + "\n").encode(encoding))
    return path


def problems_of(path: Path) -> tuple[str, ...]:
    with pytest.raises(InputError) as caught:
        read_strips(path)
    return caught.value.problems


def test_a_good_file_is_read_whatever_its_order_mark_and_other_columns(tmp_path):
    plain = read_strips(file_of(tmp_path, [HEADER, *ROWS]))
    lines = ["repeat,side,comment,radius_mm,load_g,width_mm,speed_mm_s"]
    for row in ROWS:
        load, speed, radius, side, width, repeat = row.split(",")
        lines += [f'{repeat}, {side} ,"dry, warm",{radius},{load},{width},{speed}', ""]
    other = read_strips(file_of(tmp_path, lines, "utf-8-sig"))
    for name in ("load_g", "speed_mm_s", "radius_mm", "width_mm", "top", "repeat"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(other, name))
    assert len(plain) == 12
    assert plain.row.tolist() == list(range(2, 14))
    assert other.row.tolist() == list(range(2, 26, 2))
    assert other.unread_columns == ("comment",)
    assert plain.digest != other.digest


def changed(row: int, column: str, value: str) -> list[str]:
    cells = [line.split(",") for line in [HEADER, *ROWS]]
    cells[row - 1][cells[0].index(column)] = value
    return [",".join(line) for line in cells]


@pytest.mark.parametrize(
    ("lines", "sentences"),
    [
        ([], ["is empty"]),
        ([HEADER], ["has 0 strips, allowed are 8"]),
        ([HEADER, *ROWS[:5]], ["has 5 strips", "load_g: found only 0.5, 1 g, allowed are 3"]),
        (["a,b"], ["row 1: the header is 'a', 'b' and lacks load_g, speed_mm_s"]),
        ([HEADER.replace("radius_mm", "radius"), *ROWS], ["lacks radius_mm"]),
        ([HEADER + ",side", *ROWS], ["row 1, side: the header has this column 2 times"]),
        ([HEADER.replace(",", ";"), *ROWS], ["separated by semicolons, allowed are commas"]),
        ([HEADER.replace(",", "\t"), *ROWS], ["separated by tabs"]),
        ([HEADER, "2,4,1,4,5,bottom,8,1", *ROWS], ["row 2, whole row: found 8 values, the header has 6 columns"]),
        (changed(4, "radius_mm", '"4,5"'), ["row 4, radius_mm: found '4,5', allowed is a number"]),
        (changed(4, "radius_mm", "abc"), ["row 4, radius_mm: found 'abc', allowed is a number from 1 to 300 mm"]),
        (changed(4, "radius_mm", ""), ["row 4, radius_mm: found ''"]),
        (changed(4, "radius_mm", "-4.5"), ["row 4, radius_mm: found -4.5, allowed are 1 to 300 mm"]),
        (changed(4, "radius_mm", "nan"), ["row 4, radius_mm: found nan"]),
        (changed(3, "load_g", "0.0049"), ["row 3, load_g: found 0.0049, allowed are 0.05 to 100 g; convert N"]),
        (changed(3, "speed_mm_s", "60"), ["row 3, speed_mm_s: found 60, allowed are 0.02 to 20 mm/s; convert mm/min"]),
        (changed(3, "width_mm", "0"), ["row 3, width_mm: found 0"]),
        (changed(5, "side", "botom"), ["row 5, side: found 'botom', allowed are bottom and top; did you mean bottom?"]),
        (changed(5, "side", "concave"), ["did you mean top?"]),
        (changed(5, "repeat", "1.5"), ["row 5, repeat: found '1.5', allowed is a whole number from 1"]),
        ([HEADER, *(row.replace("bottom", "left") for row in ROWS)], ["row 2, side: found 'left'"]),
        ([HEADER, *(f"2.4,{s},3,top,8,1" for s in range(1, 11))], ["load_g: found only 2.4 g, allowed are 3"]),
        ([HEADER, *(f"{f},1,3,top,8,1" for f in range(1, 11))], ["all rows, speed_mm_s: found only 1 mm/s"]),
    ],
)  # fmt: skip
def test_a_wrong_file_is_refused_with_one_sentence_for_each_problem(tmp_path, lines, sentences):
    path = file_of(tmp_path, lines) if lines else tmp_path / "strips.csv"
    path.touch()
    found = problems_of(path)
    assert len(found) == len(sentences), found
    for problem, words in zip(found, sentences, strict=True):
        assert words in problem
        assert str(path) in problem
        assert problem.endswith((".", "?", "likewise)"))
        assert ";" in problem


def test_all_problems_are_told_at_once_and_a_shared_one_once(tmp_path):
    rows = [row.replace("bottom", "left") for row in ROWS]
    rows[3] = "1,-3,oops,top,8,0"
    found = problems_of(file_of(tmp_path, [HEADER, *rows]))
    assert len(found) == 4
    assert "row 2, side: found 'left'" in found[0]
    assert "and 10 more rows likewise" in found[0]
    for problem, column in zip(found[1:], ("speed_mm_s", "radius_mm", "repeat"), strict=True):
        assert f"row 5, {column}: found" in problem


@pytest.mark.parametrize(("content", "words"), [(b"\xff\xfel\x00o\x00", "UTF-8"), (b"\x00\x01", "zero bytes")])
def test_what_is_no_text_is_refused(tmp_path, content, words):
    path = tmp_path / "strips.csv"
    path.write_bytes(content)
    assert words in problems_of(path)[0]
    assert "cannot be read" in problems_of(tmp_path)[0]
    assert "no such file" in problems_of(tmp_path / "absent.csv")[0]
