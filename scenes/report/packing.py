"""Arrays as text that a page can carry: whole numbers of two or four bytes in base64."""

import base64
from typing import Any

import numpy as np

STEPS = 65_000
"""How finely a range is divided: about a micrometre for a face."""


def pack_numbers(values: np.ndarray) -> dict[str, Any]:
    """Pack numbers in any shape, flattened: value = low + step * whole number."""
    low, high = float(values.min()), float(values.max())
    step = max(high - low, 1e-9) / STEPS
    return {"low": low, "step": step, "uint16": _text(np.round((values - low) / step), "<u2")}


def pack_indices(values: np.ndarray) -> dict[str, str]:
    """Pack whole numbers from 0, flattened."""
    return {"uint32": _text(values, "<u4")}


def _text(values: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values.ravel(), dtype=kind).tobytes()).decode("ascii")
