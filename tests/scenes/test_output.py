import errno
import json

import numpy as np
import pytest

from planner.errors import InputError
from scenes.output import output_folder, write_json


def write(folder, *, fault=None):
    with output_folder(folder) as scratch:
        (scratch / "a.txt").write_text("new")
        (scratch / "b.txt").write_text("new")
        if fault is not None:
            raise fault


def content(folder):
    return {path.name: path.read_text() for path in folder.iterdir()}


def test_files_appear_when_the_block_ends(tmp_path):
    folder = tmp_path / "new" / "deep"
    with output_folder(folder) as scratch:
        (scratch / "a.txt").write_text("a")
        assert not (folder / "a.txt").exists()
        assert scratch.parent == folder
    assert content(folder) == {"a.txt": "a"}


def test_old_results_are_replaced_and_foreign_files_left_alone(tmp_path):
    (tmp_path / "a.txt").write_text("old")
    (tmp_path / "mine.txt").write_text("mine")
    with output_folder(tmp_path) as scratch:
        (scratch / "a.txt").write_text("new")
    assert content(tmp_path) == {"a.txt": "new", "mine.txt": "mine"}


@pytest.mark.parametrize("fault", [RuntimeError("bug"), InputError("wrong."), KeyboardInterrupt(), FileNotFoundError()])
def test_after_a_fault_all_is_as_before(tmp_path, fault):
    (tmp_path / "a.txt").write_text("old")

    for folder in (tmp_path, tmp_path / "new" / "deep"):
        with pytest.raises(type(fault)) as caught:
            write(folder, fault=fault)
        assert caught.value is fault
        assert content(tmp_path) == {"a.txt": "old"}


def test_a_full_disk_is_told_and_leaves_nothing(tmp_path):
    full = OSError(errno.ENOSPC, "No space left on device")
    with pytest.raises(InputError, match=r"^--out: writing into .*new failed \(No space left.*make room"):
        write(tmp_path / "new", fault=full)
    assert not list(tmp_path.iterdir())


def test_a_folder_in_the_way_of_one_file_stops_all(tmp_path):
    (tmp_path / "b.txt").mkdir()
    with pytest.raises(InputError, match=r"folders named b\.txt"):
        write(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["b.txt"]


@pytest.mark.parametrize("where", ["file", "file/below", "file/far/below"])
def test_a_file_in_the_way_is_told(tmp_path, where):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match="a file of that name is in the way"), output_folder(tmp_path / where):
        pytest.fail("the block must not start")
    assert content(tmp_path) == {"file": "mine"}


def test_a_folder_that_cannot_be_made_is_told(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr("tempfile.mkdtemp", refuse)
    with pytest.raises(InputError, match=r"cannot write into .*\(Permission denied\)"), output_folder(tmp_path / "new"):
        pytest.fail("the block must not start")
    assert not list(tmp_path.iterdir())


def test_json_has_plain_numbers_only(tmp_path):
    path = tmp_path / "a.json"
    write_json(
        path,
        {
            "array": np.array([[1.0, np.nan], [np.inf, 2.0]]),
            "integer": np.int64(3),
            "flag": np.bool_(True),
            "nested": [{1: (float("nan"), "text", None)}],
        },
    )
    assert json.loads(path.read_text()) == {
        "array": [[1.0, None], [None, 2.0]],
        "integer": 3,
        "flag": True,
        "nested": [{"1": [None, "text", None]}],
    }
