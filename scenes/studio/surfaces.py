"""Surfaces side by side in 3-D, drawn by the browser, turned together."""

import asyncio
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
import trimesh
from trame.widgets import vtk as vtk_widgets
from vtkmodules.vtkCommonCore import vtkObject

from planner.target import Target, load_target
from scenes.pictures.graphics import prefer_headless_window
from scenes.pictures.relief import half_height, stage_relief
from scenes.pictures.target import drawn_target

ASPECT_ALONE, ASPECT_ABOVE_TABLE = 1.2, 1.9
"""Width of the whole view over its height, on a laptop."""
MOUSE = (
    "[{button: 1, action: 'Rotate'}, {button: 2, action: 'Pan'}, {button: 1, action: 'Pan', shift: true}, "
    "{button: 3, action: 'Zoom', scrollEnabled: true}]"
)
"""What dragging does, for the browser."""
ROOM_FOR_WORDS = 1.24
"""Around the surfaces, for the captions above them."""

_numbers = itertools.count(1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Surface3d:
    """A surface with its words."""

    vertices_mm: np.ndarray
    """Shape [n, 3]."""
    triangles: np.ndarray
    """Shape [m, 3], int."""
    title: str
    size: str
    """How large it is, for people."""


def target_surface(target: Target, title: str = "Target") -> Surface3d:
    """Return a target as it is drawn."""
    return _surface(*drawn_target(target), title)


def target_surface_of(path: Path) -> Surface3d:
    """Return the target that a plan keeps."""
    return target_surface(load_target(path))


def shape_surface(path: Path, title: str) -> Surface3d:
    """Return the hot shape that a prediction wrote."""
    mesh: Any = trimesh.load(path, process=False)
    return _surface(np.asarray(mesh.vertices), np.asarray(mesh.faces), title)


def _surface(vertices: np.ndarray, triangles: np.ndarray, title: str) -> Surface3d:
    extent = np.ptp(vertices[np.unique(triangles)], axis=0)
    size = f"{extent[0]:.1f} x {extent[1]:.1f} mm, {extent[2]:.1f} mm deep"
    return Surface3d(vertices_mm=vertices, triangles=triangles, title=title, size=size)


class SurfaceStage:
    """A plotter with one surface in each column and one camera for all; never rendered here."""

    def __init__(self, surfaces: Sequence[Surface3d], *, aspect: float = ASPECT_ALONE) -> None:
        # No window is opened on this machine, so what VTK says about missing displays concerns nobody.
        prefer_headless_window()
        vtkObject.GlobalWarningDisplayOff()
        self.ref = f"surfaces_{next(_numbers)}"
        self._plotter = pyvista.Plotter(off_screen=True, shape=(1, len(surfaces)), lighting="none", border=False)
        aspect /= len(surfaces)
        scale = ROOM_FOR_WORDS * max(half_height(surface.vertices_mm, aspect=aspect) for surface in surfaces)
        for column, surface in enumerate(surfaces):
            self._plotter.subplot(0, column)
            stage_relief(self._plotter, surface.vertices_mm, surface.triangles, scale)
        self._plotter.link_views()
        self._view: Any = None
        self.loaded = asyncio.Event()
        """Set when a page has drawn it: one that is taken away before breaks the next one."""

    def widget(self) -> None:
        """Put the view into the present place of the page."""
        self._view = vtk_widgets.VtkLocalView(
            self._plotter.render_window,
            ref=self.ref,
            key=f"'{self.ref}'",
            style="width: 100%; height: 100%",
            # The scene itself does not say that the projection is parallel.
            on_ready=self._push_camera,
            after_scene_loaded=self.loaded.set,
            interactor_settings=(MOUSE,),
        )

    def turn_home(self) -> None:
        """Look at the surfaces as in the beginning."""
        self._push_camera()

    def _push_camera(self) -> None:
        """Tell the browser the camera of the beginning."""
        self._view.push_camera()

    def close(self, state: Any) -> None:
        """Let go of the surfaces, and of the scene in the page's state."""
        state[f"scene_{self.ref}"] = None
        self._plotter.close()
