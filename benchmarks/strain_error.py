"""What an error of the whole film's contraction costs a plan, and a film without frustration of the same hot shape.

python -m benchmarks strain_error PLAN ... [--mesh-mm MM]

Each PLAN is a folder of `lce plan`. Its film is heated on the plate as `lce predict` does it; then all contractions are
multiplied by 1 + s and the equilibrium near the hot shape is scored, without another ramp: films that snap are not what
this is about. Beside it stands a weightless film whose every point wants nothing but the metric G that it has in that
shape: its rest metric is I + (1 + s) (G - I), so that it is free of stress at s = 0 and answers to s by its shape
alone, as a film does in which no layer works against another. A design that answers no more than that film is as
stable against this error as its shape lets it be, unless frustration makes it stiffer.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import interp1d
from scipy.stats import norm

from benchmarks.machine import describe_machine
from planner.program import load_program
from planner.target import Target, load_target
from scenes.planning import TARGET_FILE
from scenes.robustness import MESH_MM
from twin.equilibrium import Newton
from twin.film import Film, FilmOptions, build_film
from twin.inverse.anchor import forms_on_target
from twin.predict import PredictOptions, heat_film, open_newton, ramp_end, top_face
from twin.score import score_surface
from twin.shell.rest import GAUSS_POINTS, RestState, rest_state

ERRORS = (-0.112, -0.072, -0.037, 0.0, 0.037, 0.072, 0.112)
DEVIATION = 0.056
"""Of the whole film's contraction, with 5 % for the film and 5 % for each of four layers."""
TOLERANCE = 1e-7


def stress_free(film: Film, own: RestState, vertices_mm: np.ndarray, error: float) -> RestState:
    """Return the rest state of a film that has no stress in a shape, but for an error of its strain.

    Args:
        film: the film, for its mesh and the weights of its layers.
        own: its own rest state, for the heights.
        vertices_mm: the shape [mm], shape [n, 3].
        error: s above.
    """
    forms = forms_on_target(vertices_mm, film.flat_mm, film.triangles)
    a, b = (forms[:, part][:, [0, 1, 1, 2]].reshape(-1, 1, 2, 2) for part in (slice(0, 3), slice(3, 6)))
    z = own.point_z_mm[..., None, None]
    strain = a - 2.0 * z * b + z**2 * (b @ np.linalg.inv(a) @ b) - np.eye(2)
    metric = np.eye(2) + (1.0 + error) * strain
    inverse = np.linalg.inv(metric)
    # half of a layer's thickness at each of its two points, as in `rest_state`
    of_layers = 0.25 * film.layer_thickness_mm * film.modulus_ratio
    weight = np.broadcast_to(np.tile(of_layers, len(GAUSS_POINTS)), own.point_z_mm.shape)
    rows = np.stack((inverse[..., 0, 0], 2.0 * inverse[..., 0, 1], inverse[..., 1, 1]), axis=-1)
    moments = [((weight * own.point_z_mm**power)[..., None] * rows).sum(axis=1) for power in range(3)]
    return replace(
        own,
        moments=np.stack(moments, axis=1),
        point_c=weight * np.linalg.det(metric),
        constant=3.0 * weight.sum(axis=1),
    )


def similarity(newton: Newton, start_mm: np.ndarray, target: Target) -> float:
    """Return the score of the equilibrium near a start [mm], shape [n, 3], under what the shell prescribes."""
    shell, film = newton.shell, newton.shell.film
    scale = shell.driving_force(np.column_stack((film.flat_mm, np.zeros(len(film.flat_mm)))))
    found = newton.solve(start_mm, force_scale=scale, tolerance=TOLERANCE)
    return score_surface(top_face(film, found.vertices_mm, shell.top_mm), film.triangles, target).score.ssim_eq4


def tenth_percentile(scores: list[float]) -> float:
    """Return that of the scores of films that err by this alone; scores at `ERRORS`, straight between and beyond."""
    drawn = norm.ppf((np.arange(2000) + 0.5) / 2000, scale=DEVIATION)
    straight = interp1d(ERRORS, scores, fill_value="extrapolate")
    return float(np.percentile(straight(drawn), 10))


def rows(folder: Path, mesh_mm: float) -> list[str]:
    """Return the lines of the table about one plan."""
    options = PredictOptions(film=FilmOptions(mesh_mm=mesh_mm))
    target, film = load_target(folder / TARGET_FILE), build_film(load_program(folder), options.film)
    hot_mm, activation = heat_film(film, options).hot_mm, ramp_end(options)
    planned, own = open_newton(film, options), rest_state(film, activation)
    free = open_newton(film, replace(options, support="free"))
    found: dict[str, list[float]] = {"planned": [], "without frustration": []}
    for error in ERRORS:
        planned.shell.teach(replace(film, contraction=(1.0 + error) * film.contraction), activation)
        found["planned"].append(similarity(planned, hot_mm, target))
        free.shell.prescribe(stress_free(film, own, hot_mm, error))
        found["without frustration"].append(similarity(free, hot_mm, target))
    planned.close()
    free.close()
    return [
        f"| {folder.name} | {kind} | {' | '.join(f'{x:.3f}' for x in (*own, tenth_percentile(own)))} |"
        for kind, own in found.items()
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plans", type=Path, nargs="+")
    parser.add_argument("--mesh-mm", type=float, default=MESH_MM)
    options = parser.parse_args()
    print(f"| plan | film | {' | '.join(f'{100 * error:+.1f} %' for error in ERRORS)} | 10 % of the films |")
    print("|---" * (3 + len(ERRORS)) + "|", flush=True)
    for folder in options.plans:
        print(*rows(folder, options.mesh_mm), sep="\n", flush=True)
    print("", *(f"- {sentence}" for sentence in describe_machine()), sep="\n")


if __name__ == "__main__":
    main()
