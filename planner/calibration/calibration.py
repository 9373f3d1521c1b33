"""(load, speed) <-> bending radius <-> contraction."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import RegularGridInterpolator

from planner.calibration.wide_strip import CONTRACTION_MAX, contraction_for_radius, radius_for_contraction
from planner.program import CalibrationRecord, TableModel

BISECTIONS = 40
TILT = 1e-5


@dataclass(frozen=True, kw_only=True, eq=False)
class Settings:
    """Post settings for wanted bending radii, with what they really give."""

    load_g: np.ndarray
    """Post load [g], shape [n], float."""
    speed_mm_s: np.ndarray
    """Post speed [mm/s], shape [n], float."""
    radius_mm: np.ndarray
    """Bending radius that these settings give [mm], shape [n], float."""
    clamped: np.ndarray
    """-1 where the wanted radius is tighter than can be given, +1 where it is wider, else 0, shape [n]."""


class Calibration:
    """The map between post settings and what they do, inside the record's limits.

    Radii are those of the calibration strip of the record; contractions are what the strip's aligned layers
    do to bend so (see `wide_strip`). Loads and speeds beyond the limits are taken at the limit.
    """

    def __init__(self, record: CalibrationRecord) -> None:
        self.record = record
        self._strip = (record.strip.layer_thickness_mm, record.strip.aligned_layers, record.strip.width_mm)
        self._strongest = float(contraction_for_radius(record.limits.radius_mm_min, *self._strip))
        if isinstance(record.model, TableModel):
            axes = (np.log(record.model.load_g), np.log(record.model.speed_mm_s))
            self._log_radius = RegularGridInterpolator(axes, np.log(record.model.radius_mm))
        else:
            self._log_radius = None

    def contraction(self, load_g: ArrayLike, speed_mm_s: ArrayLike) -> np.ndarray:
        """Return the contraction e when fully hot, shape as the arguments broadcast."""
        load, speed = self._inside_limits(load_g, speed_mm_s)
        model = self.record.model
        if isinstance(model, TableModel):
            return contraction_for_radius(self.radius_mm(load, speed), *self._strip)
        limits = self.record.limits
        saturation = np.expm1(-load / model.load_scale_g) / np.expm1(-limits.load_g_max / model.load_scale_g)
        return self._strongest * saturation * (speed / limits.speed_mm_s_min) ** -model.speed_exponent

    def radius_mm(self, load_g: ArrayLike, speed_mm_s: ArrayLike) -> np.ndarray:
        """Return the bending radius of the calibration strip [mm], shape as the arguments broadcast."""
        load, speed = self._inside_limits(load_g, speed_mm_s)
        if self._log_radius is not None:
            return np.exp(self._log_radius((np.log(load), np.log(speed))))
        return radius_for_contraction(self.contraction(load, speed), *self._strip)

    def settings_for(self, radius_mm: ArrayLike, load_g: ArrayLike | None = None) -> Settings:
        """Choose post settings that bend the calibration strip to the wanted radii.

        With `load_g` only the speed is chosen. Without it, the load is chosen too: such that the speed lies
        in the middle of its range (geometric mean) where the load's range allows it, so that both can still
        be changed.
        """
        radius = np.atleast_1d(np.abs(np.asarray(radius_mm, dtype=float)))
        limits = self.record.limits
        slow, fast = limits.speed_mm_s_min, limits.speed_mm_s_max
        if load_g is None:
            middle = np.full_like(radius, np.sqrt(slow * fast))
            # The radius falls with load: search on -load, so that both searches rise.
            load = -_first_reaching(
                radius, lambda minus: self.radius_mm(-minus, middle), -limits.load_g_max, -limits.load_g_min
            )
        else:
            load = np.broadcast_to(np.asarray(load_g, dtype=float), radius.shape)
        speed = _first_reaching(radius, lambda v: self.radius_mm(load, v), slow, fast)
        given = self.radius_mm(load, speed)
        off = given / radius - 1
        clamped = np.where(off > 1e-6, -1, np.where(off < -1e-6, 1, 0))
        return Settings(load_g=np.array(load), speed_mm_s=speed, radius_mm=given, clamped=clamped)

    def strip_radius_mm(
        self, radius_mm: ArrayLike, layer_thickness_mm: Sequence[float], aligned: Sequence[int]
    ) -> np.ndarray:
        """Return the radius to which settings bend the calibration strip when they bend another stack to `radius_mm`.

        The other stack is wide. Both have the same contraction in their aligned layers. Radii tighter than any
        contraction gives are taken as the tightest.
        """
        stack = (tuple(layer_thickness_mm), tuple(aligned))
        if (*stack, None) == self._strip:
            return np.abs(np.asarray(radius_mm, dtype=float))
        tightest = radius_for_contraction(CONTRACTION_MAX, *stack)
        reachable = np.maximum(np.abs(np.asarray(radius_mm, dtype=float)), tightest * (1 + 1e-9))
        return radius_for_contraction(contraction_for_radius(reachable, *stack), *self._strip)

    def drawn(self, rng: np.random.Generator) -> "Calibration":
        """Return a calibration that the strips behind this one leave possible, itself without uncertainty.

        Raises:
            ValueError: if it is not known how uncertain this one is.
        """
        record = self.record
        if record.uncertainty is None or not isinstance(record.model, TableModel):
            raise ValueError(f"calibration '{record.name}' does not say how uncertain it is")
        modes = np.array(record.uncertainty.modes_log_radius)
        log_radius = np.log(record.model.radius_mm) + np.tensordot(rng.standard_normal(len(modes)), modes, axes=1)
        tightest = float(radius_for_contraction(CONTRACTION_MAX, *self._strip)) * (1 + 1e-6)
        radius = np.maximum(np.exp(monotone(log_radius) + tilt(*log_radius.shape)), tightest)
        model = record.model.model_copy(update={"radius_mm": tuple(map(tuple, radius.tolist()))})
        return Calibration(record.model_copy(update={"model": model, "uncertainty": None}))

    def radius_range_mm(self, load_g: float) -> tuple[float, float]:
        """Return the tightest and the widest radius [mm] that speed alone reaches at one load."""
        limits = self.record.limits
        speeds = np.array([limits.speed_mm_s_min, limits.speed_mm_s_max])
        tight, wide = self.radius_mm(load_g, speeds)
        return float(tight), float(wide)

    def _inside_limits(self, load_g: ArrayLike, speed_mm_s: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        limits = self.record.limits
        load = np.clip(np.asarray(load_g, dtype=float), limits.load_g_min, limits.load_g_max)
        speed = np.clip(np.asarray(speed_mm_s, dtype=float), limits.speed_mm_s_min, limits.speed_mm_s_max)
        load, speed = np.broadcast_arrays(load, speed)
        return load, speed


def monotone(log_radius: np.ndarray) -> np.ndarray:
    """Rearrange maps, shape [..., loads, speeds], so that each falls with load and rises with speed."""
    return np.sort(np.sort(log_radius, axis=-1), axis=-2)[..., ::-1, :]


def tilt(loads: int, speeds: int) -> np.ndarray:
    """Return the least by which neighbouring nodes differ in log radius, shape [loads, speeds].

    A saturated map can so still be inverted.
    """
    return TILT * (np.arange(speeds)[None, :] - np.arange(loads)[:, None])


def _first_reaching(
    wanted: np.ndarray, rising: Callable[[np.ndarray], np.ndarray], low: float, high: float
) -> np.ndarray:
    """Bisect for where a rising function reaches the wanted values, clamped to low..high, shape [n]."""
    lower, upper = np.full_like(wanted, low), np.full_like(wanted, high)
    lower = np.where(rising(upper) <= wanted, upper, lower)
    upper = np.where(rising(lower) >= wanted, lower, upper)
    for _ in range(BISECTIONS):
        middle = (lower + upper) / 2
        reached = rising(middle) >= wanted
        lower, upper = np.where(reached, lower, middle), np.where(reached, middle, upper)
    return (lower + upper) / 2
