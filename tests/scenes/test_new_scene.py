"""New scene files, and what the first commands of a newcomer say."""

import json
import tomllib

import pytest

from planner.calibration.files import PLACEHOLDER
from rig.transport import ports
from scenes.case import list_cases, load_case
from scenes.doctor import findings
from scenes.new_scene import scene_text


@pytest.mark.parametrize("name", [case.name for case in list_cases()])
def test_every_built_in_case_makes_a_scene_that_is_the_same_and_commented(tmp_path, name):
    case = load_case(name)
    path = tmp_path / "mine.toml"
    path.write_text(scene_text(case, "mine"), encoding="utf-8")
    made = load_case(path)
    assert made == case.model_copy(update={"name": "mine", "expected": None})
    keys = [line for line in path.read_text().splitlines() if " = " in line.partition("#")[0]]
    assert all(" # " in line for line in keys)


def test_a_new_scene_can_be_planned_as_it_is(lce, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ran = lce("new", "my_dome")
    assert ran.code == 0, ran.err
    assert "lce plan my_dome.toml" in ran.out
    assert lce("plan", "my_dome.toml", "--out", "out").code == 0
    assert json.loads((tmp_path / "out" / "plan.json").read_text())["name"] == "my_dome"


def test_a_new_scene_is_like_its_name_or_like_another(lce, tmp_path):
    for arguments, written, kind in (
        (("face",), "face.toml", "face"),
        (("a.toml", "--like", "saddle"), "a.toml", "saddle"),
    ):
        assert lce("new", tmp_path / arguments[0], *arguments[1:]).code == 0
        assert tomllib.loads((tmp_path / written).read_text())["target"]["kind"] == kind


def test_new_scenes_that_cannot_be_are_refused(lce, tmp_path):
    (tmp_path / "there.toml").write_text("mine")
    lce("new", tmp_path / "there").assert_refused("is already there and is not overwritten")
    assert (tmp_path / "there.toml").read_text() == "mine"
    lce("new", tmp_path / "x", "--like", "fcae").assert_refused("did you mean face?")
    lce("new", tmp_path / "absent" / "x").assert_refused("cannot be written")
    assert [path.name for path in tmp_path.iterdir()] == ["there.toml"]


def test_a_misspelt_key_is_told_with_the_nearest(lce, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(PLACEHOLDER.read_text().replace("speed_exponent", "sped_exponent"))
    refused = lce("plan", "ridge", "--calibration", path, "--out", tmp_path / "out")
    refused.assert_refused("model.speed_exponent: this field is missing", "did you mean speed_exponent?")


def test_doctor_tells_ports_display_and_cache(monkeypatch):
    class Port:
        device, description = "/dev/ttyACM7", "stage"

    monkeypatch.setattr(ports, "comports", lambda: [Port()])
    monkeypatch.setenv("DISPLAY", ":7")
    monkeypatch.setenv("LCE_RENDERER", "relief")
    found = dict(findings())
    assert found["/dev/ttyACM7"] == "stage"
    assert found["serial ports"] == "1"
    assert found["display"] == ":7"
    assert "files" in found["kernel cache"]
    assert "vtk" in found


def test_completion_can_be_written(lce, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    ran = lce("--install-completion", "--shell", "bash", "--output", tmp_path / "lce.bash")
    assert ran.code == 0, ran.err
    text = (tmp_path / "lce.bash").read_text()
    assert "calibrate" in text
    assert "--size-mm" in text
