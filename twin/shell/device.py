"""The device that kernels run on."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes.util import find_library
from pathlib import Path

import warp as wp

from planner.errors import InputError
from twin.shell import kernels


def open_device(name: str) -> wp.Device:
    """Start Warp and return the device: `auto` takes the first CUDA device if there is one.

    Kernels are compiled here (some seconds the first time, then cached on disk), so that later launches from
    several threads never compile at once.

    Raises:
        InputError: if the name is unknown or no CUDA device is present.
    """
    if name not in ("auto", "cpu", "cuda"):
        raise InputError(f"device: found {name!r}, allowed are auto, cpu and cuda; choose one of them.")
    wp.config.log_level = wp.LOG_WARNING
    with _no_driver_warning():
        wp.init()
    if name == "cuda" and not wp.is_cuda_available():
        raise InputError("device: found 'cuda', but no CUDA device is present; use --device cpu or auto.")
    device = wp.get_device("cuda:0" if name == "cuda" or (name == "auto" and wp.is_cuda_available()) else "cpu")
    wp.load_module(kernels, device=device)
    return device


def describe_devices() -> list[tuple[str, str]]:
    """Return (what, finding) pairs about the devices that kernels could run on and where they are cached."""
    chosen = open_device("auto")
    cuda = ", ".join(str(device.name) for device in wp.get_cuda_devices()) or "none"
    return [
        ("CUDA devices", cuda),
        ("kernels run on", str(chosen)),
        ("kernel cache", _cache_state(Path(str(wp.config.kernel_cache_dir)))),
    ]


def _cache_state(folder: Path) -> str:
    """Say where kernels are cached and how much lies there."""
    sizes = [path.stat().st_size for path in folder.rglob("*") if path.is_file()]
    return f"{folder}, {len(sizes)} files, {sum(sizes) / 1e6:.1f} MB"


@contextmanager
def _no_driver_warning() -> Iterator[None]:
    """Silence the line that Warp's native code writes to stderr on every machine without an NVIDIA driver."""
    if find_library("cuda") is not None or sys.platform == "win32":
        yield
        return
    sys.stderr.flush()
    saved = os.dup(2)
    silence = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(silence, 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(silence)
