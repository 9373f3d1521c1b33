"""Layers aligned in a skin on their top instead of weakly all through."""

import numpy as np

from planner.calibration import contraction_for_radius, skin_depth_mm
from planner.errors import InputError
from planner.program import CalibrationRecord
from twin.film.film import Film


def with_skin(film: Film, calibration: CalibrationRecord, *, scratched: np.ndarray | None = None) -> Film:
    """Return the film with each aligned layer cut in two: polydomain below, a fully aligned skin on its top.

    The skin contracts as the calibration's strongest setting does, and is so deep at each triangle that the
    calibration strip would bend as measured; a layer that is thinner is aligned through. Where a triangle averages
    aligned with polydomain film, or different directors, its skin is thinner. Layers that are polydomain all over
    stay whole.

    Args:
        film: a film whose layers are uniformly aligned, shape [layers, m].
        calibration: the strip that contractions were calibrated with.
        scratched: contraction before the alignment faded, shape [layers, m]: it tells the depth, and `film` how much
            of the alignment is left there; None where nothing faded.

    Raises:
        InputError: if the calibration's strip does not tell how deep its skin is.
    """
    scratched = film.contraction if scratched is None else scratched
    strip = (calibration.strip.layer_thickness_mm, calibration.strip.aligned_layers)
    strongest = float(contraction_for_radius(calibration.limits.radius_mm_min, *strip, calibration.strip.width_mm))
    try:
        depth = skin_depth_mm(scratched, strongest, *strip)
    except ValueError as error:
        raise InputError(
            f"profile: the calibration '{calibration.name}' does not tell how deep a skin is ({error}); use the "
            "uniform profile."
        ) from error
    left = np.divide(film.contraction, scratched, out=np.ones_like(scratched), where=scratched > 0.0)
    whole = np.broadcast_to(film.layer_thickness_mm.reshape(len(left), -1), left.shape)
    source, thickness, contraction = [], [], []
    for layer in range(len(left)):
        if not scratched[layer].any():
            source.append(layer)
            thickness.append(whole[layer])
            contraction.append(film.contraction[layer])
            continue
        skin = np.minimum(depth[layer], whole[layer])
        source += [layer, layer]
        thickness += [whole[layer] - skin, skin]
        contraction += [np.zeros_like(skin), strongest * left[layer]]
    return Film(
        flat_mm=film.flat_mm,
        triangles=film.triangles,
        layer_thickness_mm=np.stack(thickness),
        director_rad=film.director_rad[source],
        contraction=np.stack(contraction),
        modulus_ratio=film.modulus_ratio[source],
    )
