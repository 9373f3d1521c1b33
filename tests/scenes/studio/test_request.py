"""What the page asks for, as command lines."""

from pathlib import Path

import pytest

from planner.errors import InputError
from scenes.studio.form import OPTIONS, SOURCES, form_request, scene_items, scene_settings
from scenes.studio.request import HOT, PLAN, JobRequest, read_request

UPLOAD = "uploads/0123456789abcdef/my_face.stl"
FORM = {**OPTIONS, **SOURCES}


def commands(request: JobRequest) -> dict[str, list[str]]:
    return request.commands(Path("/ws"), Path("/ws/jobs/1"))


def test_an_untouched_form_leaves_everything_to_the_commands():
    asked = commands(form_request({**FORM, "scene": "face"}))
    assert asked == {
        PLAN: ["plan", "face", "--out", "/ws/jobs/1/plan", "--method=perpendicular"],
        HOT: ["predict", "/ws/jobs/1/plan", "--out", "/ws/jobs/1/hot"],
    }


def test_an_uploaded_file_has_its_size_and_axes():
    asked = commands(form_request({**FORM, "upload": UPLOAD, "width_mm": "40", "height_mm": "60", "up": "-y"}))
    assert asked[PLAN][1] == f"/ws/{UPLOAD}"
    assert {"--size-mm=40x60", "--up=-y"} <= set(asked[PLAN])


def test_the_options_of_a_method_do_not_reach_the_others():
    fields = {"scene": "face", "tracer": "dense", "margin_mm": "2", "budget_s": "60", "robust": True, "stack": "pairs"}
    direct = commands(form_request({**FORM, **fields, "method": "maximum"}))[PLAN]
    inverse = commands(form_request({**FORM, **fields, "method": "inverse"}))[PLAN]
    assert {"--tracer=dense", "--margin-mm=2.0"} <= set(direct)
    assert not {"--budget-s=60.0", "--robust", "--stack=pairs"} & set(direct)
    assert {"--budget-s=60.0", "--robust", "--stack=pairs"} <= set(inverse)
    assert not {"--tracer=dense", "--margin-mm=2.0"} & set(inverse)


def test_an_inverse_design_is_made_for_the_film_as_it_is_heated():
    fields = {"scene": "face", "temperature_c": "120", "support": "free", "modulus_mpa": "1", "mesh_mm": "1.5"}
    heated = {"--temperature-c=120.0", "--support=free", "--modulus-mpa=1.0"}
    direct = commands(form_request({**FORM, **fields}))
    inverse = commands(form_request({**FORM, **fields, "method": "inverse"}))
    assert not heated & set(direct[PLAN])
    assert heated <= set(inverse[PLAN])
    for asked in (direct, inverse):
        assert heated | {"--mesh-mm=1.5"} <= set(asked[HOT])


def test_no_value_passes_for_a_flag():
    asked = commands(form_request({**FORM, "scene": "face", "layers_mm": "--help"}))[PLAN]
    assert "--layers-mm=--help" in asked
    assert "--help" not in asked


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("scene", "/etc/scene.toml"),
        ("scene", "--help"),
        ("upload", "/etc/passwd"),
        ("upload", "uploads/0123456789abcdef/../../x.stl"),
        ("calibration", "../calibration.toml"),
        ("method", "guess"),
        ("seed", "1.5"),
        ("mesh_mm", "nan"),
        ("depth_mm", "deep"),
        ("layers_mm", "0" * 1000),
    ],
)
def test_wrong_fields_are_refused_by_name(field, value):
    with pytest.raises(InputError) as refused:
        form_request({**FORM, "scene": "face", field: value})
    assert [problem.partition(":")[0] for problem in refused.value.problems] == [field]


def test_all_wrong_fields_are_told_at_once():
    with pytest.raises(InputError) as refused:
        read_request({"seed": "x", "mesh_mm": "y", "colour": "red"})
    assert {problem.partition(":")[0] for problem in refused.value.problems} == {"seed", "mesh_mm", "colour"}


def test_a_request_without_a_target_is_refused():
    with pytest.raises(InputError, match="none is chosen"):
        JobRequest().source(Path("/ws"))


def test_a_request_says_what_it_is():
    request = form_request({**FORM, "upload": UPLOAD, "width_mm": "40", "height_mm": "60", "mesh_mm": "1.5"})
    assert request.title == "my_face, perpendicular, 40x60 mm"
    assert request.options == "mesh_mm 1.5"


def test_every_scene_of_the_list_has_a_method():
    names = [item["name"] for item in scene_items()]
    assert "face" in names
    for name in names:
        assert form_request({**FORM, "scene": name, **scene_settings(name)}).scene == name
