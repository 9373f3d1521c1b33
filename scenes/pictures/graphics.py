"""Which way 3-D pictures are drawn: by OpenGL where it works, else by a shaded relief in plain NumPy."""

import ctypes.util
import logging
import os
import subprocess
import sys
from functools import lru_cache
from typing import Literal

from planner.errors import InputError

logger = logging.getLogger(__name__)

Renderer = Literal["opengl", "relief"]
VARIABLE = "LCE_RENDERER"
"""Environment variable that forces a renderer: `opengl`, `relief`, or `auto` (the default)."""

_PROBE = (
    "import pyvista; p = pyvista.Plotter(off_screen=True, window_size=(32, 32)); "
    "p.add_mesh(pyvista.Plane()); p.screenshot(None, return_img=True)"
)


def renderer() -> Renderer:
    """Choose the renderer, once for each process and setting.

    Raises:
        InputError: The environment variable has another value than the three.
    """
    choice = os.environ.get(VARIABLE, "auto")
    if choice not in ("auto", "opengl", "relief"):
        raise InputError(f"{VARIABLE}: found {choice!r}, allowed are auto, opengl and relief; set one or unset it.")
    if choice == "relief":
        return "relief"
    prefer_headless_window()
    return "opengl" if choice == "opengl" or _opengl_works() else "relief"


def prefer_headless_window() -> None:
    """Let VTK open an EGL or OSMesa window where there is no display, before it tries X and complains."""
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        window = "vtkEGLRenderWindow" if ctypes.util.find_library("EGL") else "vtkOSOpenGLRenderWindow"
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", window)


@lru_cache(maxsize=1)
def _opengl_works() -> bool:
    """Try a tiny picture in a process of its own, since VTK ends its process where a driver is broken."""
    if sys.platform.startswith("linux"):
        needed = ("GL", "X11") if os.environ.get("DISPLAY") else ("EGL", "OSMesa")
        if not any(ctypes.util.find_library(name) for name in needed):
            logger.info("no OpenGL library: 3-D pictures are drawn as shaded reliefs")
            return False
    try:
        probe = subprocess.run([sys.executable, "-c", _PROBE], capture_output=True, timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    if probe.returncode:
        logger.info("OpenGL does not work here: 3-D pictures are drawn as shaded reliefs")
    return probe.returncode == 0
