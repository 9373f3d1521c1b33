"""What is said first, and how times are said."""

import pytest

from scenes.report.time_budget import time_bars
from scenes.report.verdict import duration, make_verdict

LAYERS = [
    {"index": 0, "passes": 9, "length_mm": 80.0, "motion_s": 3000, "travel_s": 700, "load_s": 50, "total_s": 3750},
    {"index": 1, "passes": 0, "length_mm": 0.0, "motion_s": 0, "travel_s": 0, "load_s": 0, "total_s": 0},
]
PROBLEM = {"severity": "warning", "where": "layers[0]", "message": "takes 63 min; split it"}
BARE = {
    "layers": LAYERS,
    "machine": {"name": "paper", "budget_s": 3600, "reset_and_cure_s": 480, "problems": [PROBLEM]},
    "stops": [{"temperature_c": 150, "depth_mm": 3.21}, {"temperature_c": 25, "depth_mm": 0.0}],
    "warnings": ["The calibration is a placeholder."],
}
SCORED = BARE | {
    "ssim_eq4": 0.538,
    "paper_ssim": 0.845,
    "rms_mm": 1.81,
    "rms_percent_of_diagonal": 2.4,
    "hausdorff_mm": 6.3,
    "depth_mm": 5.3,
    "target_depth_mm": 16.2,
}
NOISE = {
    "count": 32,
    "mesh_mm": 1.2,
    "percentiles": {
        "ssim_eq4": {"10": 0.4, "50": 0.5, "90": 0.6},
        "rms_mm": {"10": 1.0, "50": 1.5, "90": 2.0},
    },
    "without_noise": {"ssim_eq4": 0.53, "rms_mm": 1.8},
}
BAND = {
    "calibration": "mine",
    "draws": 8,
    "mesh_mm": 1.2,
    "percent": (5, 50, 95),
    "ssim_eq4": {"low": 0.45, "high": 0.57, "expected": 0.54},
    "rms_mm": {"low": 1.6, "high": 2.1, "expected": 1.8},
}


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0, "0 s"), (99, "99 s"), (120, "2 min"), (3600, "1 h"), (3599, "1 h"), (6582, "1 h 50 min")],
)
def test_times_are_said_as_one_says_them(seconds, words):
    assert duration(seconds) == words


def test_the_score_stands_beside_the_papers():
    verdict = make_verdict(SCORED)
    assert "SSIM 53.8 %" in verdict.sentence
    assert "84.5 %" in verdict.sentence
    assert [figure.value for figure in verdict.figures] == ["53.8 %", "1.81 mm", "5.3 mm", "1 h 2 min"]
    assert verdict.meter is not None
    assert (verdict.meter.value_percent, verdict.meter.paper_percent) == pytest.approx((53.8, 84.5))
    assert verdict.meter.spread_percent is None
    assert verdict.spreads == ()


def test_warnings_are_those_of_the_result_and_of_the_machine():
    assert make_verdict(BARE).warnings == (
        "The calibration is a placeholder.",
        "layers[0]: takes 63 min; split it.",
    )


def test_noise_and_band_open_the_score():
    noisy, banded = make_verdict(SCORED | {"noise": NOISE}), make_verdict(SCORED | {"noise": NOISE, "score_band": BAND})
    assert noisy.meter is not None
    assert banded.meter is not None
    assert noisy.meter.spread_percent == pytest.approx((40, 60))
    assert banded.meter.spread_percent == pytest.approx((45, 57))
    assert "SSIM 40.0 to 60.0 %" in noisy.spreads[0]
    assert (
        "calibration 'mine' is known: SSIM 45.0 to 57.0 %, RMS 1.60 to 2.10 mm (5 to 95 % of 8 films"
        in banded.spreads[0]
    )


def test_what_has_no_target_is_said_to_have_none():
    verdict = make_verdict(BARE)
    assert verdict.meter is None
    assert "not scored" in verdict.sentence
    assert verdict.figures[0].value == "3.2 mm"
    strip = make_verdict(BARE | {"bending_radius_mm": 5.2, "promised_radius_mm": 5.0})
    assert "5.2 mm" in strip.sentence
    assert [figure.label for figure in strip.figures] == ["bending radius", "depth", "machine time"]


def test_bars_share_one_scale_with_the_budget():
    bars = time_bars(BARE)
    first, second = bars.bars
    assert (first.layer, first.over_budget, second.over_budget) == (1, True, False)
    assert sum(percent for _, _, percent in first.parts) == pytest.approx(100 / 1.05)
    assert bars.budget_percent == pytest.approx(100 / 1.05 * 3600 / 3750)
    assert second.parts == (("post on the film", 0, 0), ("travel", 0, 0), ("changing the load", 0, 0))
