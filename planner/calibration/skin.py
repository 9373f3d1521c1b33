"""How far a wide strip bends when its layers are aligned in a skin only, and how deep the skin must be.

The post aligns what it shears. If that is the top of a layer, down to a depth d that load and speed decide, and all of
it as far as it can be, then a weak setting is a thin skin, and not a weak alignment of the whole layer::

    uniform                skin
    |-----------------|    |=================|  d   contraction e_skin, always the same
    |- - - - e - - - -|    |                 |
    |- - - - - - - - -|    |   polydomain    |  h - d
    +-----------------+    +-----------------+

Both can bend the calibration strip alike; they differ in every other stack.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from planner.calibration.wide_strip import radius_for_contraction, wide_stack

NODES = 201


def skin_radius_mm(
    depth_mm: ArrayLike, skin_contraction: float, layer_thickness_mm: Sequence[float], aligned: Sequence[int]
) -> np.ndarray:
    """Return the bending radius of a wide strip with skins [mm], signed as in `wide_strip`, shape of `depth_mm`.

    Args:
        depth_mm: depth of the skin [mm]; a layer that is thinner than this is aligned through.
        skin_contraction: e of the skin.
        layer_thickness_mm: flat thickness of each layer [mm], bottom first.
        aligned: indices of the layers with a skin on their top.
    """
    depth = np.asarray(depth_mm, dtype=float)
    layers = np.asarray(layer_thickness_mm, dtype=float)
    deep = np.zeros((depth.size, len(layers)))
    deep[:, list(aligned)] = np.minimum(depth.reshape(-1, 1), layers[list(aligned)])
    thickness = np.stack((layers - deep, deep), axis=2).reshape(depth.size, -1)
    contraction = np.tile([0.0, skin_contraction], (depth.size, len(layers)))
    return wide_stack(contraction, thickness)[0].reshape(depth.shape)


def skin_depth_mm(
    contraction: ArrayLike, skin_contraction: float, layer_thickness_mm: Sequence[float], aligned: Sequence[int]
) -> np.ndarray:
    """Return the depth of the skin that bends a wide strip as far as layers of a uniform contraction do [mm].

    Contractions above `skin_contraction` are taken for it: the skin is then as deep as the thickest aligned layer.

    Args:
        contraction: uniform contraction e of the aligned layers, >= 0, any shape.
        skin_contraction: e of the skin.
        layer_thickness_mm: flat thickness of each layer of the strip [mm], bottom first.
        aligned: indices of its aligned layers.

    Raises:
        ValueError: if the strip bends less with a deeper skin somewhere, so that its radius tells no depth.
    """
    table = _depths(skin_contraction, tuple(layer_thickness_mm), tuple(aligned))
    e = np.clip(np.asarray(contraction, dtype=float), 0.0, skin_contraction)
    return np.asarray(table(1.0 / radius_for_contraction(e, layer_thickness_mm, aligned)))


@lru_cache(maxsize=16)
def _depths(
    skin_contraction: float, layer_thickness_mm: tuple[float, ...], aligned: tuple[int, ...]
) -> PchipInterpolator:
    """|Curvature| [1/mm] -> depth [mm]."""
    depth = max(layer_thickness_mm[k] for k in aligned) * np.linspace(0.0, 1.0, NODES)
    curvature = np.abs(1.0 / skin_radius_mm(depth, skin_contraction, layer_thickness_mm, aligned))
    if np.any(np.diff(curvature) <= 0.0):
        raise ValueError(
            f"a strip of {list(layer_thickness_mm)} mm with layers {list(aligned)} aligned does not bend more and more "
            "with the depth of its skin"
        )
    return PchipInterpolator(curvature, depth)
