"""What is on this machine, as far as the project cares."""

import os
import platform
import sys
from importlib.metadata import version

PACKAGES = ("lce-twin", "warp-lang", "numpy", "scipy", "trimesh", "pyvista", "scikit-image", "pyserial", "libigl")


def findings() -> list[tuple[str, str]]:
    """Return (what, finding) pairs."""
    import warp as wp

    from scenes.pictures.rendering import can_render
    from twin.equilibrium.linear import HAVE_PARDISO
    from twin.shell.device import open_device

    device = open_device("auto")
    solver = "MKL PARDISO" if HAVE_PARDISO else "SuperLU of scipy (about ten times slower)"
    cuda = ", ".join(str(item.name) for item in wp.get_cuda_devices()) or "none"
    return [
        ("python", f"{platform.python_version()} on {platform.platform()}"),
        ("cores", str(os.cpu_count())),
        *((package, version(package)) for package in PACKAGES),
        ("CUDA devices", cuda),
        ("kernels run on", str(device)),
        ("kernel cache", str(wp.config.kernel_cache_dir)),
        ("sparse solver", solver),
        ("3-D pictures", "VTK off-screen" if can_render() else "relief shading (no OpenGL library found)"),
    ]


def print_findings() -> None:
    """Write the findings to stdout, one a line."""
    for what, finding in findings():
        sys.stdout.write(f"{what:<16} {finding}\n")
