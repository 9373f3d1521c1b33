"""Strips that do not belong to the map that all others tell."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from planner.calibration.map_form import MapForm
from planner.calibration.map_posterior import MapPosterior, fitted_parameters, map_posterior

FALSE_ALARM = 0.001
"""Probability that any strip of a whole set without outliers is called one."""
MOST_SHARE, MOST = 0.25, 12
"""Outliers that are looked for: a share of the strips, and a number."""


@dataclass(frozen=True, kw_only=True)
class Outlier:
    """A strip that was left out, and how far off it is."""

    row: int
    """Line of the file."""
    load_g: float
    speed_mm_s: float
    radius_mm: float
    """As measured [mm]."""
    expected_mm: float
    """What the map fitted to the others says [mm]."""
    deviations: float
    """How far off, in standard deviations of such a strip; positive where its radius is too large."""

    @property
    def sentence(self) -> str:
        """Say it."""
        return (
            f"row {self.row} ({self.load_g:g} g, {self.speed_mm_s:g} mm/s): {self.radius_mm:.3g} mm where the others "
            f"say {self.expected_mm:.3g} mm, {self.radius_mm / self.expected_mm - 1:+.0%}, "
            f"{abs(self.deviations):.1f} standard deviations off; left out"
        )


def without_outliers(
    form: MapForm, load_g: np.ndarray, speed_mm_s: np.ndarray, log_radius: np.ndarray, row: np.ndarray
) -> tuple[MapPosterior, np.ndarray, tuple[Outlier, ...]]:
    """Fit the map to all strips but outliers.

    The strips farthest from a robust fit of the form are taken away one after the other, and each is tested against
    the map fitted to what is left then, with what that map does not know and the scatter of strips (Student's t). The
    last to fail its test and all before it are outliers: one far strip does not hide another, and near ones are not
    called far because they were suspected (Rosner 1983, generalized extreme studentized deviates).

    Returns:
        The map, which strips it was fitted to, shape [n], bool, and the outliers.

    """
    robust = fitted_parameters(form, load_g, speed_mm_s, log_radius, loss="soft_l1")
    off = np.abs(log_radius - form.log_radius(robust, load_g, speed_mm_s))
    suspects = np.argsort(-off, kind="stable")[: min(MOST, int(MOST_SHARE * len(off)))]
    count = 0
    for number in range(1, len(suspects) + 1):
        kept = np.delete(np.arange(len(off)), suspects[:number])
        found = map_posterior(form, load_g[kept], speed_mm_s[kept], log_radius[kept])
        last = suspects[number - 1 : number]
        mean, spread = found.expected(load_g[last], speed_mm_s[last])
        deviations = abs(float(log_radius[last][0] - mean[0])) / np.hypot(spread[0], found.noise)
        among = len(off) - number + 1
        freedom = max(len(kept) - len(found.parameters), 1)
        if deviations > student.ppf(1.0 - FALSE_ALARM / (2.0 * among), freedom):
            count = number
    kept = np.ones(len(off), dtype=bool)
    kept[suspects[:count]] = False
    found = map_posterior(form, load_g[kept], speed_mm_s[kept], log_radius[kept])
    out = np.flatnonzero(~kept)
    mean, spread = found.expected(load_g[out], speed_mm_s[out])
    deviations = (log_radius[out] - mean) / np.hypot(spread, found.noise)
    outliers = tuple(
        Outlier(
            row=int(row[int(i)]),
            load_g=float(load_g[i]),
            speed_mm_s=float(speed_mm_s[i]),
            radius_mm=float(np.exp(log_radius[i])),
            expected_mm=float(np.exp(mean[place])),
            deviations=float(deviations[place]),
        )
        for place, i in enumerate(out)
    )
    return found, kept, outliers
