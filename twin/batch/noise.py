"""Films as the process really makes them: strain, directions and registration a little off."""

from dataclasses import asdict, dataclass, fields, replace
from math import degrees, radians

import numpy as np
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator
from scipy.spatial import Delaunay

from planner.errors import InputError
from twin.film import Film

WAVES = 64
"""Random waves that a smooth field of directions is made of."""
STRAIN_ALLOWED = 0.3
"""Largest standard deviation of a relative strain: beyond it strains of the wrong sign would no longer be rare."""


@dataclass(frozen=True, kw_only=True)
class ProcessNoise:
    """Standard deviations of independent Gaussian errors; 0 switches one off without changing the draws of the others.

    The defaults are assumptions, not measurements of a machine.
    """

    strain: float = 0.05
    """Relative error of the contraction, the same in the whole film: ink, temperature, calibration."""
    layer_strain: float = 0.05
    """Relative error of the contraction of each layer: its load, its cure."""
    direction_rad: float = radians(5.0)
    """Error of the director, a smooth random field in each layer [rad]."""
    direction_length_mm: float = 0.8
    """Distance over which the error of the director changes [mm]: its correlation is exp(-(r / length)^2 / 2).

    By default a post's width: passes side by side err each by itself, as they must where places are kept to 0.2 mm,
    which a pass 5 degrees off has left after 2.3 mm. `inf` turns each layer as a whole."""
    registration_mm: float = 0.2
    """Shift of each layer along x, and along y, against the film [mm]."""

    def scaled(self, factor: float) -> "ProcessNoise":
        """Return noise with all standard deviations times a factor; the length stays."""
        return replace(
            self,
            strain=factor * self.strain,
            layer_strain=factor * self.layer_strain,
            direction_rad=factor * self.direction_rad,
            registration_mm=factor * self.registration_mm,
        )

    def plain(self) -> dict[str, float | str]:
        """Return the numbers as one writes them: the direction in degrees, and "inf", for which JSON has no number."""
        numbers = asdict(self)
        # there and back again changes the last digit of 5 degrees
        direction_deg = round(degrees(numbers.pop("direction_rad")), 12)
        found = {**numbers, "direction_deg": direction_deg}
        return {name: value if np.isfinite(value) else str(value) for name, value in found.items()}

    def check(self) -> None:
        """Refuse what is no standard deviation or length.

        Raises:
            InputError: with every problem found.
        """
        problems = []
        for part in fields(self):
            value, name = getattr(self, part.name), part.name
            if name == "direction_length_mm":
                fine, allowed = value > 0.0, "lengths above 0, or inf to turn each layer as a whole"
            elif name in ("strain", "layer_strain"):
                fine, allowed = 0.0 <= value <= STRAIN_ALLOWED, f"0 to {STRAIN_ALLOWED:g}"
            else:
                fine, allowed = 0.0 <= value < np.inf, "finite values from 0"
            if not fine:
                problems.append(
                    f"process noise, {name}: found {value:g}, allowed are {allowed}; the default is {part.default:g}."
                )
        if problems:
            raise InputError(problems)


def noisy_films(film: Film, noise: ProcessNoise, count: int, seed: int) -> list[Film]:
    """Return films on the same mesh, each with errors of its own; number k does not depend on `count`.

    Layers are shifted first, then their directors turned, then their contractions scaled. A shift is resampled from
    the triangles' centres, so it blurs what is narrower than a triangle; beyond the edge the nearest triangle counts.

    Args:
        film: the film as planned.
        noise: standard deviations.
        count: number of films.
        seed: seed of all errors, from 0.

    Raises:
        InputError: if a number is out of range, or layers of varying thickness, as of the profile `skin`, would have
            to be shifted.
    """
    noise.check()
    if count < 1 or seed < 0:
        raise InputError(
            f"noisy films: found count {count} and seed {seed}, allowed are whole numbers, the count from 1, the seed "
            "from 0; choose others."
        )
    if noise.registration_mm > 0.0 and film.layer_thickness_mm.ndim == 2:
        raise InputError(
            f"process noise, registration_mm: found {noise.registration_mm:g} for a film whose layers vary in "
            "thickness, allowed is 0: they cannot be shifted; set it to 0 or use the profile uniform."
        )
    centre = film.flat_mm[film.triangles].mean(axis=1)
    shifted = _Shifted(film, centre) if noise.registration_mm > 0.0 else None
    return [_noisy(film, noise, centre, shifted, np.random.default_rng((seed, number))) for number in range(count)]


class _Shifted:
    """The alignment of each layer as a function of a shift.

    Interpolates q = e (cos 2 theta, sin 2 theta) for the director, and e by itself: the vector's length would fall
    wherever directors differ, by 1 to 2 % of all contraction, each time that a film is shifted.
    """

    def __init__(self, film: Film, centre: np.ndarray) -> None:
        alignment = np.concatenate((film.alignment, film.contraction[..., None]), axis=-1)
        mesh = Delaunay(centre)
        self._centre = centre
        self._inside = [LinearNDInterpolator(mesh, layer) for layer in alignment]
        self._beyond = [NearestNDInterpolator(centre, layer) for layer in alignment]

    def __call__(self, shift_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return directors [rad] and contractions, shape [layers, m], of layers shifted by [layers, 2] mm."""
        found = []
        for shift, inside, beyond in zip(shift_mm, self._inside, self._beyond, strict=True):
            values, place = inside(self._centre - shift), self._centre - shift
            outside = np.isnan(values[:, 0])
            values[outside] = beyond(place[outside])
            found.append(values)
        cos, sin, contraction = np.moveaxis(np.stack(found), -1, 0)
        return 0.5 * np.arctan2(sin, cos), contraction


def _noisy(
    film: Film, noise: ProcessNoise, centre: np.ndarray, shifted: _Shifted | None, rng: np.random.Generator
) -> Film:
    """Return one film with errors drawn from `rng`, the same number of draws whatever the noise."""
    layers = len(film.contraction)
    strain = 1.0 + noise.strain * rng.normal() + noise.layer_strain * rng.normal(size=(layers, 1))
    shift = noise.registration_mm * rng.normal(size=(layers, 2))
    turn = np.stack([smooth_field(centre, noise.direction_length_mm, rng) for _ in range(layers)])
    director, contraction = film.director_rad, film.contraction
    if shifted is not None:
        director, contraction = shifted(shift)
    return replace(
        film,
        director_rad=director + noise.direction_rad * turn,
        contraction=contraction * np.maximum(strain, 0.0),
    )


def smooth_field(points_mm: np.ndarray, length_mm: float, rng: np.random.Generator) -> np.ndarray:
    """Return a Gaussian random field of variance 1 at points [mm], shape [m, 2] -> [m].

    Random Fourier features of the Gaussian correlation (Rahimi and Recht 2007).
    """
    wave = rng.normal(size=(WAVES, 2)) / length_mm
    weight = rng.normal(size=(2, WAVES)) / np.sqrt(WAVES)
    phase = points_mm @ wave.T
    return np.cos(phase) @ weight[0] + np.sin(phase) @ weight[1]
