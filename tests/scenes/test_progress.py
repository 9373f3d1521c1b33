"""Progress for another program: lines of JSON into the file that it names."""

import json
import os

import pytest

from scenes.progress import LINES_VARIABLE, progress_bar


@pytest.fixture
def pipe(monkeypatch):
    """Reading and writing end; the writing one is where progress is asked for."""
    reading, writing = os.pipe()
    monkeypatch.setenv(LINES_VARIABLE, str(writing))
    yield reading, writing
    for end in (reading, writing):
        os.close(end)


def lines_of(reading: int) -> list[dict]:
    return [json.loads(line) for line in os.read(reading, 1 << 16).splitlines()]


def test_each_stage_begins_and_ends_with_a_line(pipe):
    with progress_bar() as progress:
        progress("flattening", 0.0)
        progress("flattening", 1.0)
        progress("toolpaths", 0.25)
        progress("toolpaths", 1.0)
    found = [(line["stage"], line["share"]) for line in lines_of(pipe[0])]
    assert found == [("flattening", 0.0), ("flattening", 1.0), ("toolpaths", 0.25), ("toolpaths", 1.0)]


def test_lines_of_one_stage_pause(pipe):
    with progress_bar() as progress:
        for step in range(1000):
            progress("heating", step / 1000)
    # However slow this machine is, a thousand steps do not take a hundred seconds.
    assert 1 <= len(lines_of(pipe[0])) < 1000


def test_a_note_comes_with_the_next_line_of_its_stage(pipe):
    with progress_bar() as progress:
        progress("searching", 0.0)
        progress.note("searching", "SSIM 0.8")
        progress("searching", 1.0)
        progress("pictures", 1.0)
    assert [line["note"] for line in lines_of(pipe[0])] == ["", "SSIM 0.8", ""]


def test_work_that_nobody_waits_for_is_interrupted(monkeypatch):
    reading, writing = os.pipe()
    monkeypatch.setenv(LINES_VARIABLE, str(writing))
    os.close(reading)
    try:
        with progress_bar() as progress, pytest.raises(KeyboardInterrupt):
            progress("heating", 0.1)
    finally:
        os.close(writing)


def test_without_such_a_program_nothing_is_written(monkeypatch, capfd):
    monkeypatch.delenv(LINES_VARIABLE, raising=False)
    with progress_bar() as progress:
        progress("heating", 0.5)
        progress.note("heating", "words")
    assert capfd.readouterr() == ("", "")
