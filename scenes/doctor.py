"""What is on this machine, as far as the project cares."""

import os
import platform
import sys
from importlib.metadata import version

PACKAGES = (
    "lce-twin",
    "warp-lang",
    "numpy",
    "scipy",
    "trimesh",
    "pyvista",
    "vtk",
    "scikit-image",
    "pyserial",
    "libigl",
    "ezdxf",
)


def findings() -> list[tuple[str, str]]:
    """Return (what, finding) pairs."""
    from rig.transport.ports import serial_ports
    from scenes.pictures.graphics import renderer
    from twin.equilibrium.linear import HAVE_PARDISO
    from twin.shell.device import describe_devices

    ports = serial_ports()
    pictures = {"opengl": "VTK, off-screen", "relief": "shaded reliefs (OpenGL does not work here)"}
    return [
        ("python", f"{platform.python_version()} on {platform.platform()}"),
        ("cores", str(os.cpu_count())),
        *((package, version(package)) for package in PACKAGES),
        *describe_devices(),
        ("sparse solver", "MKL PARDISO" if HAVE_PARDISO else "SuperLU of scipy (about ten times slower)"),
        ("display", os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or "none, and none is needed"),
        ("3-D pictures", pictures[renderer()]),
        ("serial ports", "none" if not ports else f"{len(ports)}"),
        *((name, description) for name, description in ports),
    ]


def print_findings() -> None:
    """Write the findings to stdout, one a line."""
    for what, finding in findings():
        sys.stdout.write(f"{what:<16} {finding}\n")
