"""The journal: on the disk before anything is done, whole lines only, one writer."""

import errno
import os
from pathlib import Path

import pytest

from planner.errors import InputError, RigError
from rig.executor.journal import Journal, read_journal


def test_what_is_written_is_read(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "j")
    journal.write({"event": "note", "text": "Ü"})
    journal.write({"event": "begin", "op": 3})
    journal.close()
    journal.close()
    assert read_journal(tmp_path / "j") == [{"event": "note", "text": "Ü"}, {"event": "begin", "op": 3}]


def test_a_torn_last_line_is_left_out_and_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "j"
    path.write_bytes(b'{"event":"a"}\n{"event":"b')
    assert read_journal(path) == [{"event": "a"}]
    journal = Journal(path)
    journal.write({"event": "c"})
    journal.close()
    assert read_journal(path) == [{"event": "a"}, {"event": "c"}]


def test_damage_in_the_middle_is_told(tmp_path: Path) -> None:
    path = tmp_path / "j"
    path.write_bytes(b'{"event":"a"}\n\x00\x00\n{"event":"b"}\n')
    with pytest.raises(InputError, match="line 2 is damaged"):
        read_journal(path)


def test_two_runs_do_not_share_a_folder(tmp_path: Path) -> None:
    first = Journal(tmp_path / "j")
    with pytest.raises(RigError, match="in use by another run"):
        Journal(tmp_path / "j")
    first.close()
    Journal(tmp_path / "j").close()


def test_a_full_disk_and_an_unwritable_place_are_told(tmp_path: Path, monkeypatch) -> None:
    with pytest.raises(RigError, match="cannot be written"):
        Journal(tmp_path / "absent" / "j")
    journal = Journal(tmp_path / "j")

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("rig.executor.journal.os.write", full)
    with pytest.raises(RigError, match=r"No space left on device\): free the disk, then resume"):
        journal.write({"event": "a"})
    journal.close()
    assert read_journal(tmp_path / "j") == []


def test_an_entry_that_was_half_written_does_not_spoil_the_next(tmp_path: Path, monkeypatch) -> None:
    journal = Journal(tmp_path / "j")
    journal.write({"event": "a"})
    write = os.write

    def short(file: int, data: bytes) -> int:
        if len(data) < 9:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(file, data[:-5])

    with monkeypatch.context() as full:
        full.setattr("rig.executor.journal.os.write", short)
        with pytest.raises(RigError, match="free the disk"):
            journal.write({"event": "lost"})
    journal.write({"event": "b"})
    journal.close()
    assert read_journal(tmp_path / "j") == [{"event": "a"}, {"event": "b"}]
