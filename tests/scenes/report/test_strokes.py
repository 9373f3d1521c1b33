"""The playback tells the times of the timing, and every pass in its order."""

import pytest

from planner.calibration import load_calibration
from planner.program import layer_times, load_machine, load_program
from planner.strips import strip_program
from scenes.report.strokes import pack_strokes

MACHINE = load_machine()


@pytest.fixture(scope="module")
def strip():
    return strip_program(load_calibration(), name="strip", length_mm=12, width_mm=5, radius_mm=5)


def test_passes_follow_each_other_up_to_the_layers_time(planned):
    program = load_program(planned)
    packed = pack_strokes(program, MACHINE)
    for layer, times in zip(packed["layers"], layer_times(program, MACHINE), strict=True):
        strokes = packed["passes"][layer["passes"]]
        assert layer["total_s"] == times.total_s
        if not strokes:
            continue
        starts = layer["start_s"]
        ends = [start + stroke["at_s"][-1] for start, stroke in zip(starts, strokes, strict=True)]
        assert all(end <= start + 1e-2 for end, start in zip(ends, starts[1:], strict=False))
        assert ends[-1] == pytest.approx(times.total_s, abs=1e-2)
        assert sum(stroke["at_s"][-1] for stroke in strokes) == pytest.approx(times.motion_s, rel=1e-3)


def test_layers_alike_share_their_passes(planned):
    program = load_program(planned)
    packed = pack_strokes(program, MACHINE)
    assert [layer["passes"] for layer in packed["layers"]] == [0, 0, 1, 1]
    assert len(packed["passes"][0]) == len(program.layers[0].passes)
    assert packed["passes"][1] == []


def test_a_pass_says_load_radius_and_colour_of_each_segment(strip):
    packed = pack_strokes(strip, MACHINE)
    stroke = packed["passes"][0][0]
    segments = len(stroke["points_mm"]) - 1
    assert len(stroke["at_s"]) == segments + 1
    assert len(stroke["speed_mm_s"]) == len(stroke["radius_mm"]) == len(stroke["colour"]) == segments
    assert stroke["radius_mm"] == [pytest.approx(5.0, rel=1e-2)] * segments
    assert stroke["concave"] is False
    low, high = packed["radius_mm"]
    assert low < 5.0 < high
    assert 0 < stroke["colour"][0] < len(packed["colours"]) - 1
