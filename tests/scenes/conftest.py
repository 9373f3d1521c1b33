"""Fixtures of the command line's tests: `lce` in this process, and a small planned dome."""

import sys
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import pytest

from scenes.cli import main
from twin.inverse import Field

DOME = """
name = "small dome"
description = "A dome small enough for tests."
target = {kind = "dome", radius_mm = 8, height_mm = 4, cut = 0.9}
"""


@dataclass(frozen=True, kw_only=True)
class Ran:
    """How a command ended and what it said."""

    code: int
    out: str
    err: str

    def assert_refused(self, *sentences: str) -> None:
        """Assert that the input was refused with exactly these problems, each told in one line."""
        assert "Traceback" not in self.err
        told = self.err.splitlines()
        assert self.code == 2, self.err
        assert len(told) == len(sentences), self.err
        assert all(line.startswith("lce: ") for line in told), self.err
        for line, words in zip(told, sentences, strict=True):
            assert words in line


@pytest.fixture
def field() -> Field:
    """Fields of an inverse design's stage, of no meaning."""
    rng = np.random.default_rng(0)
    made = {"stage": "coarse", "outline_mm": rng.normal(size=(9, 2)), "triangles": np.array([(0, 1, 2), (1, 2, 3)])}
    for part in fields(Field):
        made.setdefault(part.name, 0.01 if part.type is float else rng.normal(size=(4, 2)))
    return Field(**made)


@pytest.fixture
def lce(monkeypatch, capfd):
    """Run the command line in this process."""

    def run(*arguments: object) -> Ran:
        monkeypatch.setattr(sys, "argv", ["lce", *map(str, arguments)])
        capfd.readouterr()
        with pytest.raises(SystemExit) as stop:
            main()
        seen = capfd.readouterr()
        return Ran(code=int(stop.value.code or 0), out=seen.out, err=seen.err)

    return run


@pytest.fixture(scope="session")
def dome_case(tmp_path_factory) -> Path:
    """A case file of a small dome."""
    path = tmp_path_factory.mktemp("case") / "dome.toml"
    path.write_text(DOME)
    return path


@pytest.fixture(scope="session")
def planned(tmp_path_factory, dome_case) -> Path:
    """The folder of the small dome's plan; read it, do not write into it."""
    from scenes.case import load_case
    from scenes.planning import plan_into

    folder = tmp_path_factory.mktemp("planned") / "plan"
    plan_into(folder, load_case(dome_case).make_target())
    return folder


@pytest.fixture
def no_pictures(monkeypatch):
    """Leave out the pictures, which take most of the time of a coarse prediction."""
    for room in ("planning", "prediction"):
        monkeypatch.setattr(f"scenes.{room}.draw_plan", lambda *_, **__: None)
        monkeypatch.setattr(f"scenes.{room}.draw_target", lambda *_, **__: None)
    for name in ("draw_hot_shape", "draw_depth_images", "draw_error_map", "draw_side_by_side"):
        monkeypatch.setattr(f"scenes.prediction.{name}", lambda *_, **__: None)
