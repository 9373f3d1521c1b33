"""Measured strips -> a calibration: a monotone map with a band, what was left out, and where it comes from."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np

from planner.calibration.calibration import Calibration, monotone, tilt
from planner.calibration.map_form import MapForm
from planner.calibration.map_posterior import MapPosterior
from planner.calibration.outliers import Outlier, without_outliers
from planner.calibration.strip_width import curvature_at_width, width_factor
from planner.calibration.strips_file import MeasuredStrips
from planner.errors import InputError
from planner.program import (
    CalibrationLimits,
    CalibrationRecord,
    CalibrationStrip,
    CalibrationUncertainty,
    TableModel,
)

LAYER_THICKNESS_MM = (0.2, 0.2, 0.2, 0.2)
LEVEL = 0.99
"""Of the band, for the whole map at once."""
DRAWS = 2000
LOADS, SPEEDS = 13, 9
"""Nodes of the table, evenly in the logarithm: fine enough that straight lines between them err by 0.3 %."""
MODES_SHARE, MOST_MODES = 0.995, 8
"""Share of the variance of drawn maps that their modes keep."""
WRONG_TREND = 3.0
"""Standard errors from which a trend of the wrong sign is believed."""
SIDES_DIFFER = 3.0
IRREGULAR_MM_S = 2.0
"""Above this speed the paper found radii irregular (section 2.1)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CalibrationFit:
    """A calibration with all that led to it."""

    calibration: Calibration
    strips: MeasuredStrips
    strip_radius_mm: np.ndarray
    """Radius of each strip, converted to the calibration's strip where its width is another [mm], shape [n]."""
    kept: np.ndarray
    """Which strips the map was fitted to, shape [n], bool."""
    outliers: tuple[Outlier, ...]
    posterior: MapPosterior
    notes: tuple[str, ...]
    """Sentences that the user should see."""


def fit_calibration(
    strips: MeasuredStrips,
    *,
    name: str,
    provenance: dict[str, str] | None = None,
    layer_thickness_mm: Sequence[float] = LAYER_THICKNESS_MM,
    seed: int = 0,
) -> CalibrationFit:
    """Fit a calibration to strips.

    The map is a form of four numbers with a smooth deviation (`map_form`, `map_posterior`), tabulated. What the strips
    leave open is drawn; each drawn map is made monotone by sorting along load and along speed, which brings it nowhere
    farther from a monotone truth (Chernozhukov, Fernandez-Val and Galichon 2009). Their mean is the map, and the band
    is so wide that a share `LEVEL` of them lies in it as a whole, at all settings at once.

    Args:
        strips: what was measured.
        name: of the calibration.
        provenance: date, operator, method and what else is known; the rest is added.
        layer_thickness_mm: of the strips' layers, bottom first [mm]; the lower half was scratched, or the upper.
        seed: of the draws.

    Raises:
        InputError: if the radius rises with load or falls with speed.
    """
    thickness = tuple(layer_thickness_mm)
    strip = CalibrationStrip(
        layer_thickness_mm=thickness,
        aligned_layers=tuple(range(len(thickness) // 2)),
        width_mm=_common_width(strips.width_mm),
    )
    radius = _at_width(strips, strip)
    log_radius = np.log(radius)
    _check_trends(strips, log_radius)
    form = MapForm(
        layer_thickness_mm=thickness,
        aligned=strip.aligned_layers,
        width_mm=strip.width_mm or np.inf,
        speed_mm_s=float(np.exp(np.log(strips.speed_mm_s).mean())),
    )
    posterior, kept, outliers = without_outliers(form, strips.load_g, strips.speed_mm_s, log_radius, strips.row)
    record = _record(name, posterior, strip, np.random.default_rng(seed))
    notes = _notes(strips, kept, posterior, log_radius)
    stated = {
        **(provenance or {}),
        **_provenance(strips, strip, posterior, kept, outliers, record.uncertainty),
    }
    return CalibrationFit(
        calibration=Calibration(record.model_copy(update={"provenance": stated})),
        strips=strips,
        strip_radius_mm=radius,
        kept=kept,
        outliers=outliers,
        posterior=posterior,
        notes=notes,
    )


def _common_width(width_mm: np.ndarray) -> float:
    """Return the width that most strips have [mm], the widest of several."""
    values, counts = np.unique(width_mm, return_counts=True)
    return float(values[counts == counts.max()].max())


def _at_width(strips: MeasuredStrips, strip: CalibrationStrip) -> np.ndarray:
    """Return the radii to which strips of the common width bend with the same contraction [mm], shape [n]."""
    radius, height = strips.radius_mm.copy(), sum(strip.layer_thickness_mm)
    common = strip.width_mm or np.inf
    for width in np.unique(strips.width_mm[strips.width_mm != common]):
        mine = strips.width_mm == width
        wide = radius[mine] / width_factor(1.0 / radius[mine], height, width)
        radius[mine] = 1.0 / curvature_at_width(1.0 / wide, height, common)
    return radius


def _check_trends(strips: MeasuredStrips, log_radius: np.ndarray) -> None:
    """Refuse strips that bend less with more load, or more at a higher speed."""
    terms = np.column_stack([np.ones(len(strips)), np.log(strips.load_g), np.log(strips.speed_mm_s)])
    slope, square = np.linalg.lstsq(terms, log_radius, rcond=None)[:2]
    scatter = float(square[0]) / max(len(strips) - 3, 1) if len(square) else 0.0
    error = np.sqrt(np.maximum(scatter * np.diag(np.linalg.pinv(terms.T @ terms)), 1e-12))
    _, by_load, by_speed = slope / error
    wrong = []
    if by_load > WRONG_TREND:
        wrong.append(("load_g", "rises with load", "falls with it"))
    if by_speed < -WRONG_TREND:
        wrong.append(("speed_mm_s", "falls with speed", "rises with it"))
    hint = "are load_g and speed_mm_s swapped?" if len(wrong) == 2 else "check this column and its units."
    if wrong:
        raise InputError(
            [
                f"{strips.source}, all rows, {column}: the radius {found}, allowed is one that {allowed}; {hint}"
                for column, found, allowed in wrong
            ]
        )


def _record(name: str, posterior: MapPosterior, strip: CalibrationStrip, rng: np.random.Generator) -> CalibrationRecord:
    loads = _nodes(posterior.load_g, LOADS)
    speeds = _nodes(posterior.speed_mm_s, SPEEDS)
    load, speed = (axis.ravel() for axis in np.meshgrid(loads, speeds, indexing="ij"))
    drawn = monotone(posterior.draw(load, speed, DRAWS, rng).reshape(DRAWS, LOADS, SPEEDS))
    mean, spread = drawn.mean(axis=0), drawn.std(axis=0)
    reach = np.quantile((np.abs(drawn - mean) / spread).reshape(DRAWS, -1).max(axis=1), LEVEL)
    _, sizes, modes = np.linalg.svd((drawn - mean).reshape(DRAWS, -1) / np.sqrt(DRAWS), full_matrices=False)
    share = np.cumsum(sizes**2) / (sizes**2).sum()
    count = min(MOST_MODES, int(np.searchsorted(share, MODES_SHARE)) + 1)
    modes = (sizes[:count, None] * modes[:count]).reshape(count, LOADS, SPEEDS)
    radius = np.exp(mean + tilt(LOADS, SPEEDS))
    return CalibrationRecord(
        name=name,
        placeholder=False,
        provenance={},
        limits=CalibrationLimits(
            load_g_min=loads[0],
            load_g_max=loads[-1],
            speed_mm_s_min=speeds[0],
            speed_mm_s_max=speeds[-1],
            radius_mm_min=_rounded(radius[-1, 0], 7),
            radius_mm_max=_rounded(radius[0, -1], 7),
        ),
        strip=strip,
        model=TableModel(load_g=tuple(loads), speed_mm_s=tuple(speeds), radius_mm=_grid(radius, 7)),
        uncertainty=CalibrationUncertainty(
            level=LEVEL,
            band_log_radius=_grid(reach * spread, 4),
            modes_log_radius=tuple(_grid(mode, 4) for mode in modes),
            strip_log_radius=_rounded(posterior.noise, 4),
        ),
    )


def _nodes(values: np.ndarray, count: int) -> list[float]:
    """Return nodes evenly in the logarithm; the ends are the values themselves, to the last digit."""
    inner = np.geomspace(values.min(), values.max(), count)[1:-1]
    return [float(values.min()), *(_rounded(value, 6) for value in inner), float(values.max())]


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def _grid(values: np.ndarray, digits: int) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(_rounded(value, digits) for value in row) for row in values)


def _notes(
    strips: MeasuredStrips, kept: np.ndarray, posterior: MapPosterior, log_radius: np.ndarray
) -> tuple[str, ...]:
    notes = []
    if strips.unread_columns:
        notes.append(f"columns that mean nothing here were not read: {', '.join(strips.unread_columns)}.")
    top = strips.top[kept]
    if top.all() or not top.any():
        missing, there = ("bottom", "top") if top.all() else ("top", "bottom")
        notes.append(f"no strip was scratched on the {missing} layers: they are taken to bend as the {there} ones do.")
    else:
        off = log_radius[kept] - posterior.expected(posterior.load_g, posterior.speed_mm_s)[0]
        apart = float(off[top].mean() - off[~top].mean())
        error = posterior.noise * float(np.sqrt(1 / top.sum() + 1 / (~top).sum()))
        if abs(apart) > SIDES_DIFFER * error:
            notes.append(
                f"strips scratched on top have radii {np.expm1(apart):+.0%} beside those scratched at the bottom "
                f"(standard error {error:.0%}); the map is for both and lies between them: calibrate each by itself "
                "to see how far that matters."
            )
    fast = strips.speed_mm_s[kept] > IRREGULAR_MM_S
    if fast.any():
        notes.append(f"{fast.sum()} strips are faster than {IRREGULAR_MM_S:g} mm/s, where the paper's were irregular.")
    if len(np.unique(strips.width_mm)) > 1:
        notes.append("the strips have several widths: radii were converted to the most frequent one by plate theory.")
    return tuple(notes)


def _provenance(
    strips: MeasuredStrips,
    strip: CalibrationStrip,
    posterior: MapPosterior,
    kept: np.ndarray,
    outliers: tuple[Outlier, ...],
    uncertainty: CalibrationUncertainty | None,
) -> dict[str, str]:
    """Return what can be told of where the map comes from."""
    loads, speeds = len(np.unique(strips.load_g)), len(np.unique(strips.speed_mm_s))
    repeated = int((strips.repeat > 1).sum())
    widths = ", ".join(f"{width:g}" for width in np.unique(strips.width_mm))
    height, width = sum(strip.layer_thickness_mm), strip.width_mm or np.inf
    radii = np.exp(np.quantile(posterior.residual + posterior.form.log_radius(
        posterior.parameters, posterior.load_g, posterior.speed_mm_s), (0.0, 1.0)))  # fmt: skip
    factors = width_factor(1.0 / radii, height, width)
    half = np.array(uncertainty.band_log_radius if uncertainty else 0.0)
    return {
        "source": strips.source,
        "file_sha256": strips.digest,
        "samples": f"{len(strips)} strips at {loads} loads and {speeds} speeds, {repeated} of them repeats; "
        f"{int(strips.top.sum())} scratched on top; {len(outliers)} left out",
        "outliers": "; ".join(outlier.sentence for outlier in outliers) or "none",
        "strip_width": f"{widths} mm; radii are those of a strip {width:g} mm wide, as measured",
        "width_correction": f"contractions allow for it: a wide strip's radius is this one's over {factors[0]:.3f} "
        f"(at {radii[0]:.3g} mm) to {factors[1]:.3f} (at {radii[1]:.3g} mm), by plate theory of a strip free to curl",
        "fit": "saturating curve with a smooth deviation, monotone; sizes of deviation and scatter averaged over",
        "scatter": f"one strip about the map {posterior.noise:.1%}, the map about the curve {posterior.deviation:.1%}",
        "left_out_error": f"{np.sqrt((posterior.left_out() ** 2).mean()):.1%} of the radius, each strip predicted from "
        "all others",
        "band": f"{half.min():.1%} to {half.max():.1%} of the radius, for the whole map at once at {LEVEL:.0%}",
        "tool": f"lce-twin {version('lce-twin')}",
    }
