"""What strips tell about a map: the form's four numbers, a smooth deviation from it, and the scatter of strips.

    log R_i = form(parameters; F_i, v_i) + g(F_i, v_i) + noise_i

g is a Gaussian process over log load and log speed: nothing where the form fits, and as much as the strips ask for
where it does not, so that the band does not rest on the form being right. The sizes of g and of the noise are not
chosen but averaged over, by their probability given the strips; the form is linearised about its best numbers
(O'Hagan 1978, Curve fitting and optimal design for prediction; Rasmussen and Williams 2006, section 2.7).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import least_squares

from planner.calibration.map_form import PRIOR_DEVIATION, PRIOR_MEAN, MapForm

REACH = 0.45
"""Distance over which the deviation changes, as a share of the range of log load and of log speed."""
NOISES = np.geomspace(0.004, 0.5, 22)
"""Hypotheses of the scatter of strips, in log radius."""
DEVIATIONS = np.geomspace(0.03, 1.0, 12)
"""Hypotheses of the size of the deviation, in log radius: no form is taken to be right within 3 %."""
DEVIATION_SCALE = 0.1
"""Of the half-Cauchy prior of the deviation's size."""
ROUNDING = 1e-10
LEAST_PROBABILITY, LEAST_DRAWN = 1e-6, 1e-3
"""Of hypotheses that means and draws take in."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MapPosterior:
    """The map given some strips."""

    form: MapForm
    parameters: np.ndarray
    """Best numbers of the form, shape [4], see `map_form`."""
    load_g: np.ndarray
    speed_mm_s: np.ndarray
    residual: np.ndarray
    """Log radius of the strips less the form at its best numbers, shape [n]."""
    sizes: np.ndarray
    """Deviation and noise of each hypothesis in log radius, shape [h, 2]."""
    probability: np.ndarray
    """Of each hypothesis, shape [h]."""
    log_load: tuple[float, float]
    log_speed: tuple[float, float]
    """Ranges that distances are measured in."""

    @property
    def noise(self) -> float:
        """Standard deviation of one strip about the map, in log radius."""
        return float(self.probability @ self.sizes[:, 1])

    @property
    def deviation(self) -> float:
        """Standard deviation of the map about the form, in log radius."""
        return float(self.probability @ self.sizes[:, 0])

    def draw(self, load_g: np.ndarray, speed_mm_s: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
        """Return maps drawn from what the strips leave open, in log radius, at settings [m], shape [count, m]."""
        base = self.form.log_radius(self.parameters, load_g, speed_mm_s)
        likely = np.where(self.probability > LEAST_DRAWN, self.probability, 0.0)
        chosen = rng.choice(len(self.sizes), size=count, p=likely / likely.sum())
        drawn = np.empty((count, len(load_g)))
        given = self._given(load_g, speed_mm_s)
        for hypothesis in np.unique(chosen):
            mine = np.flatnonzero(chosen == hypothesis)
            mean, covariance = given(int(hypothesis))
            values, vectors = np.linalg.eigh(covariance)
            root = vectors * np.sqrt(np.maximum(values, 0.0))
            drawn[mine] = base + mean + rng.standard_normal((len(mine), len(load_g))) @ root.T
        return drawn

    def expected(self, load_g: np.ndarray, speed_mm_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and standard deviation of the map in log radius at settings [m], shape [m] each."""
        mean, square = np.zeros(len(load_g)), np.zeros(len(load_g))
        given = self._given(load_g, speed_mm_s)
        for hypothesis in np.flatnonzero(self.probability > LEAST_PROBABILITY):
            own, covariance = given(int(hypothesis))
            mean += self.probability[hypothesis] * own
            square += self.probability[hypothesis] * (own**2 + np.diag(covariance))
        spread = np.sqrt(np.maximum(square - mean**2, 0.0))
        return self.form.log_radius(self.parameters, load_g, speed_mm_s) + mean, spread

    def left_out(self) -> np.ndarray:
        """Return each strip's log radius less what the map fitted to all the others says, shape [n].

        At the most probable sizes: row i of C^-1 r over its diagonal (Rasmussen and Williams 2006, Eq. 5.12).
        """
        deviation, noise = self.sizes[int(np.argmax(self.probability))]
        own = (self.load_g, self.speed_mm_s)
        of_form, of_deviation = self._prior(own, own)
        inverse = np.linalg.inv(of_form + deviation**2 * of_deviation + noise**2 * np.eye(len(self.residual)))
        return inverse @ (self.residual - self._offset(*own)) / np.diag(inverse)

    def log_evidence(self) -> np.ndarray:
        """Return the log probability of the strips under each hypothesis, times its prior, shape [h]."""
        own = (self.load_g, self.speed_mm_s)
        of_form, of_deviation = self._prior(own, own)
        known = self.residual - self._offset(*own)
        found = np.empty(len(self.sizes))
        for deviation in np.unique(self.sizes[:, 0]):
            mine = self.sizes[:, 0] == deviation
            values, vectors = np.linalg.eigh(of_form + deviation**2 * of_deviation)
            # The noise adds the same to each eigenvalue: one decomposition serves all hypotheses of it.
            spread = np.maximum(values, 0.0) + self.sizes[mine, 1][:, None] ** 2 + ROUNDING
            fit = ((vectors.T @ known) ** 2 / spread).sum(axis=1)
            prior = -np.log1p((deviation / DEVIATION_SCALE) ** 2)
            found[mine] = -fit / 2.0 - np.log(spread).sum(axis=1) / 2.0 + prior
        return found

    def _given(self, load_g: np.ndarray, speed_mm_s: np.ndarray) -> Callable[[int], tuple[np.ndarray, np.ndarray]]:
        """Return hypothesis -> mean and covariance of the map less the form at its best numbers, at settings [m]."""
        here, there = (self.load_g, self.speed_mm_s), (load_g, speed_mm_s)
        own, across, far = self._prior(here, here), self._prior(there, here), self._prior(there, there)
        known, offset = self.residual - self._offset(*here), self._offset(*there)

        def given(hypothesis: int) -> tuple[np.ndarray, np.ndarray]:
            deviation, noise = self.sizes[hypothesis]
            covariance = own[0] + deviation**2 * own[1] + (noise**2 + ROUNDING) * np.eye(len(known))
            factor = cho_factor(covariance, lower=True)
            weight = across[0] + deviation**2 * across[1]
            mean = offset + weight @ cho_solve(factor, known)
            return mean, far[0] + deviation**2 * far[1] - weight @ cho_solve(factor, weight.T)

        return given

    def _offset(self, load_g: np.ndarray, speed_mm_s: np.ndarray) -> np.ndarray:
        """Return what the form says before any strip, less what it says at its best numbers, linearised, shape [m]."""
        return self.form.slope(self.parameters, load_g, speed_mm_s) @ (PRIOR_MEAN - self.parameters)

    def _prior(
        self, a: tuple[np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return covariances before any strip between settings (loads, speeds), of the form and of a deviation of 1."""
        first, second = (self.form.slope(self.parameters, *settings) * PRIOR_DEVIATION for settings in (a, b))
        square = np.zeros((len(first), len(second)))
        for (start, end), one, other in zip((self.log_load, self.log_speed), a, b, strict=True):
            square += ((np.log(one)[:, None] - np.log(other)) / (REACH * (end - start))) ** 2
        return first @ second.T, np.exp(-square / 2.0)


def map_posterior(form: MapForm, load_g: np.ndarray, speed_mm_s: np.ndarray, log_radius: np.ndarray) -> MapPosterior:
    """Fit the map to strips: settings and log radii of shape [n]."""
    parameters = fitted_parameters(form, load_g, speed_mm_s, log_radius, loss="linear")
    pairs = np.array([(deviation, noise) for deviation in DEVIATIONS for noise in NOISES])
    made = MapPosterior(
        form=form,
        parameters=parameters,
        load_g=load_g,
        speed_mm_s=speed_mm_s,
        residual=log_radius - form.log_radius(parameters, load_g, speed_mm_s),
        sizes=pairs,
        probability=np.full(len(pairs), 1.0 / len(pairs)),
        log_load=_range(load_g),
        log_speed=_range(speed_mm_s),
    )
    evidence = made.log_evidence()
    probability = np.exp(evidence - evidence.max())
    return replace(made, probability=probability / probability.sum())


def fitted_parameters(
    form: MapForm, load_g: np.ndarray, speed_mm_s: np.ndarray, log_radius: np.ndarray, *, loss: str, scale: float = 0.05
) -> np.ndarray:
    """Return the form's best numbers, shape [4]; the prior counts as four strips of its own deviations.

    Args:
        form: the form.
        load_g: settings, shape [n].
        speed_mm_s: likewise.
        log_radius: log(radius / mm) of the strips, shape [n].
        loss: `linear` for least squares, `soft_l1` to count far strips less.
        scale: scatter of the strips in log radius.

    """

    def residuals(parameters: np.ndarray) -> np.ndarray:
        off = (form.log_radius(parameters, load_g, speed_mm_s) - log_radius) / scale
        return np.concatenate([off, (parameters - PRIOR_MEAN) / PRIOR_DEVIATION])

    return least_squares(residuals, PRIOR_MEAN, loss=loss, x_scale=0.3).x


def _range(values: np.ndarray) -> tuple[float, float]:
    return float(np.log(values.min())), float(np.log(values.max()))
