"""The gallery's examples run as they stand, and each ends with a picture."""

import runpy
from pathlib import Path

import imageio.v2 as imageio
import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SLOW = "_slow.py"
"""How the names of examples end that take minutes; docs/conf.py goes by the same ending."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(path.name, marks=pytest.mark.slow if path.name.endswith(SLOW) else ())
        for path in sorted(EXAMPLES.glob("*.py"))
    ],
)
def test_an_example_runs_and_draws(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.setenv("LCE_RENDERER", "relief")
    runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    assert capsys.readouterr().out, "an example tells its numbers"
    pictures = list((tmp_path / "out").rglob("*.png"))
    assert pictures
    assert all(imageio.imread(path).std() > 5.0 for path in pictures), "no picture is blank"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
