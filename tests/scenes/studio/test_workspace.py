"""The folder of a studio: names of uploaded files, one studio at a time."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.errors import InputError
from planner.target import TARGET_SUFFIXES
from scenes.studio.request import JobRequest
from scenes.studio.workspace import Workspace, owner_of, upload_suffixes


@pytest.fixture(scope="session")
def workspace(tmp_path_factory):
    return Workspace(tmp_path_factory.mktemp("workspace"))


@given(stem=st.text(max_size=80), suffix=st.sampled_from(TARGET_SUFFIXES))
def test_an_uploaded_file_is_stored_in_the_workspace_whatever_its_name(workspace, stem, suffix):
    path = workspace.new_upload(f"a{stem}{suffix}", TARGET_SUFFIXES)
    assert path.resolve().parent.parent == workspace.uploads.resolve()
    # what the page may name later
    name = str(path.relative_to(workspace.folder))
    assert JobRequest(upload=name).upload == name


def test_two_files_of_one_name_do_not_meet(workspace):
    one, other = (workspace.new_upload("face.stl", TARGET_SUFFIXES) for _ in range(2))
    assert one != other
    assert one.name == other.name == "face.stl"


@pytest.mark.parametrize("name", ["face.exe", "face", "face.stl.sh", "..", ".stl"])
def test_other_suffixes_are_refused_with_those_allowed(workspace, name):
    with pytest.raises(InputError, match=r"allowed are \.stl") as refused:
        workspace.new_upload(name, TARGET_SUFFIXES)
    assert len(refused.value.problems) == 1


def test_calibrations_and_targets_have_their_own_suffixes():
    assert upload_suffixes("calibration") == (".toml",)
    assert upload_suffixes("target") == TARGET_SUFFIXES


def test_messages_name_files_as_the_user_does(workspace):
    path = workspace.new_upload("face.stl", TARGET_SUFFIXES)
    assert workspace.plain(f"target: {path} is empty") == "target: face.stl is empty"


def test_a_second_studio_is_kept_out(workspace):
    with (
        workspace.locked(),
        pytest.raises(InputError, match="open in another studio"),
        Workspace(workspace.folder).locked(),
    ):
        pass
    with Workspace(workspace.folder).locked():
        pass


def test_a_file_in_the_way_is_told(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="--workspace"):
        Workspace(tmp_path / "file")


def test_nobody_can_tell_a_browsers_cookie_from_its_owner():
    assert owner_of("cookie") == owner_of("cookie") != owner_of("cookies")
    assert "cookie" not in owner_of("cookie")
