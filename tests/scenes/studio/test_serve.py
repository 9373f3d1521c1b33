"""What keeps the studio from opening, each told in a sentence."""

import socket

import pytest

from planner.errors import InputError
from scenes.studio import serve
from scenes.studio.workspace import Workspace


def open_studio(workspace, port=0):
    serve.run_studio(workspace, port=port, at_once=1, browser=False)


def test_without_the_extra_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(serve, "find_spec", lambda name: None if name.startswith("trame") else object())
    with pytest.raises(InputError) as refused:
        open_studio(tmp_path / "workspace")
    assert refused.value.problems == (
        "studio: trame, trame_vtk, trame_vuetify not found; install the extra `studio`, in a clone by: pip "
        "install -e '.[studio]'.",
    )
    assert not (tmp_path / "workspace").exists()


def test_a_port_that_is_taken_is_told(tmp_path):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        with pytest.raises(InputError, match="--port: cannot listen"):
            open_studio(tmp_path, port=other.getsockname()[1])


def test_a_workspace_of_another_studio_is_told(tmp_path):
    with Workspace(tmp_path).locked(), pytest.raises(InputError, match="open in another studio"):
        open_studio(tmp_path)
