import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.calibration import Calibration, load_calibration, wide_strip
from planner.errors import InputError
from planner.program import CalibrationRecord, TableModel

PLACEHOLDER = Path(__file__).resolve().parents[2] / "planner" / "calibration" / "placeholder.toml"


def table() -> Calibration:
    base = load_calibration().record
    loads, speeds = (0.5, 2.0, 6.5), (0.5, 1.0, 2.0)
    radius = tuple(tuple(1.8 * (6.5 / load) ** 0.54 * (speed / 0.5) ** 0.5 for speed in speeds) for load in loads)
    limits = base.limits.model_copy(update={"radius_mm_max": radius[0][2]})
    model = TableModel(load_g=loads, speed_mm_s=speeds, radius_mm=radius)
    return Calibration(base.model_copy(update={"model": model, "limits": limits}))


def test_the_placeholder_has_the_published_range_and_says_what_it_is() -> None:
    calibration = load_calibration()
    assert calibration.record.placeholder
    assert calibration.record.name == "placeholder"
    assert calibration.radius_mm(6.5, 0.5) == pytest.approx(1.8, rel=1e-4)
    assert calibration.radius_mm(0.5, 2.0) == pytest.approx(14.4, rel=1e-3)


@pytest.mark.parametrize("calibration", [load_calibration(), table()])
def test_radius_falls_with_load_and_rises_with_speed(calibration: Calibration) -> None:
    load, speed = np.meshgrid(np.linspace(0.5, 6.5, 9), np.linspace(0.5, 2, 9), indexing="ij")
    radius = calibration.radius_mm(load, speed)
    assert np.all(np.diff(radius, axis=0) < 0)
    assert np.all(np.diff(radius, axis=1) > 0)


@pytest.mark.parametrize("calibration", [load_calibration(), table()])
def test_the_contraction_bends_the_strip_to_the_promised_radius(calibration: Calibration) -> None:
    load, speed = np.array([0.6, 2.4, 5.0]), np.array([0.7, 1.5, 1.1])
    strip = calibration.record.strip
    bent = wide_strip(calibration.contraction(load, speed), strip.layer_thickness_mm, strip.aligned_layers)[0]
    np.testing.assert_allclose(bent, calibration.radius_mm(load, speed), rtol=1e-5)


@pytest.mark.parametrize("calibration", [load_calibration(), table()])
@settings(max_examples=25, deadline=None)
@given(radius=st.floats(1.81, 14.3))
def test_settings_give_the_wanted_radius(calibration: Calibration, radius: float) -> None:
    radius = min(radius, calibration.record.limits.radius_mm_max - 0.01)
    chosen = calibration.settings_for(radius)
    assert chosen.clamped == 0
    assert calibration.radius_mm(chosen.load_g, chosen.speed_mm_s) == pytest.approx(radius, rel=1e-6)


def test_settings_are_clamped_at_both_ends_and_say_so() -> None:
    calibration = load_calibration()
    chosen = calibration.settings_for([1.0, 5.0, 99.0, np.inf])
    np.testing.assert_array_equal(chosen.clamped, [-1, 0, 1, 1])
    np.testing.assert_allclose(chosen.load_g[[0, 2]], [6.5, 0.5])
    np.testing.assert_allclose(chosen.speed_mm_s[[0, 2]], [0.5, 2.0])


def test_a_given_load_leaves_only_the_speed() -> None:
    calibration = load_calibration()
    tight, wide = calibration.radius_range_mm(2.4)
    chosen = calibration.settings_for([tight / 2, (tight + wide) / 2, wide * 2], load_g=2.4)
    np.testing.assert_array_equal(chosen.load_g, 2.4)
    np.testing.assert_array_equal(chosen.clamped, [-1, 0, 1])
    np.testing.assert_allclose(chosen.radius_mm, [tight, (tight + wide) / 2, wide], rtol=1e-6)


def test_a_table_is_hit_at_its_nodes() -> None:
    calibration = table()
    assert isinstance(calibration.record.model, TableModel)
    assert calibration.radius_mm(2.0, 1.0) == pytest.approx(calibration.record.model.radius_mm[1][1])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("load_g_min = 0.5", "load_g_min = 7.0", ["limits", "load_g_min is 7"]),
        ("load_g_min = 0.5", "load_g_min = -1", ["limits.load_g_min", "-1"]),
        (
            "load_g_min = 0.5",
            "load_min = 0.5",
            ["limits.load_min", "unknown field", "limits.load_g_min", "missing"],
        ),
        (
            "radius_mm_max = 14.4",
            "radius_mm_max = 20.0",
            ["radius_mm_max is 20", "14.4 mm at 0.5 g and 2 mm/s"],
        ),
        ("radius_mm_min = 1.8", "radius_mm_min = 0.3", ["cannot be reached"]),
        ('kind = "saturating"', 'kind = "linear"', ["model", "'linear'"]),
        ("aligned_layers = [0, 1]", "aligned_layers = [0, 4]", ["strip", "aligned_layers"]),
        ("placeholder = true", "placeholder = 1", ["placeholder", "boolean"]),
        ("speed_exponent = 0.44324", "speed_exponent = nan", ["speed_exponent"]),
        ("[limits]", "[limits", ["not valid TOML", "line"]),
    ],
)
def test_a_wrong_file_says_where(tmp_path: Path, old: str, new: str, words: list[str]) -> None:
    text = PLACEHOLDER.read_text()
    assert old in text
    path = tmp_path / "mine.toml"
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_calibration(path)
    for word in ["mine.toml", *words]:
        assert word in str(caught.value)


def test_tables_that_cannot_be_inverted_are_refused() -> None:
    document = {**tomllib.loads(PLACEHOLDER.read_text())}
    for radius, words in (
        ([[9, 8], [3, 4]], "rise with speed"),
        ([[9, 10], [3]], "one row for each load"),
    ):
        document["model"] = {
            "kind": "table",
            "load_g": [0.5, 6.5],
            "speed_mm_s": [0.5, 2],
            "radius_mm": radius,
        }
        with pytest.raises(ValueError, match=words):
            CalibrationRecord.model_validate(document)


def test_a_missing_file() -> None:
    with pytest.raises(InputError, match="no such calibration file"):
        load_calibration("absent.toml")
