"""What is on this machine, as far as the project cares."""

import os
import platform
import sys
from importlib.metadata import version

PACKAGES = ("lce-twin", "warp-lang", "numpy", "scipy", "trimesh", "pyvista", "scikit-image", "pyserial", "libigl")


def findings() -> list[tuple[str, str]]:
    """Return (what, finding) pairs."""
    from scenes.pictures.graphics import renderer
    from twin.equilibrium.linear import HAVE_PARDISO
    from twin.shell.device import describe_devices

    pictures = {"opengl": "VTK, off-screen", "relief": "shaded reliefs (OpenGL does not work here)"}
    return [
        ("python", f"{platform.python_version()} on {platform.platform()}"),
        ("cores", str(os.cpu_count())),
        *((package, version(package)) for package in PACKAGES),
        *describe_devices(),
        ("sparse solver", "MKL PARDISO" if HAVE_PARDISO else "SuperLU of scipy (about ten times slower)"),
        ("3-D pictures", pictures[renderer()]),
    ]


def print_findings() -> None:
    """Write the findings to stdout, one a line."""
    for what, finding in findings():
        sys.stdout.write(f"{what:<16} {finding}\n")
