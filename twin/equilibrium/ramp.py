"""Heat a film from flat: a ramp of equilibria that ends at full temperature."""

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planner.errors import SolverError
from twin.equilibrium.newton import Equilibrium, Newton

logger = logging.getLogger(__name__)

SMALLEST_STEP = 1.0 / 512


@dataclass(frozen=True, kw_only=True)
class RampOptions:
    """How a film is heated."""

    first_step: float = 1.0 / 8
    """First step, as a share of the final activation."""
    largest_step: float = 1.0 / 6
    tolerance: float = 1e-6
    """Relative residual at each accepted temperature."""
    final_tolerance: float = 1e-9
    """Relative residual at the last one."""
    disturbance_mm: float = 1e-3
    """Amplitude of the seeded smooth disturbance of the flat film."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HeatedState:
    """One accepted temperature of the ramp."""

    activation: float
    """Fraction of the full contraction."""
    equilibrium: Equilibrium


def smooth_disturbance(flat_mm: np.ndarray, amplitude_mm: float, rng: np.random.Generator) -> np.ndarray:
    """Return heights [mm], shape [n]: a few random long waves, between 0 and `amplitude_mm`."""
    size = np.ptp(flat_mm, axis=0).max()
    height = np.zeros(len(flat_mm))
    for _ in range(6):
        wave = rng.normal(size=2) * 2.0 * np.pi / size
        height += rng.normal() * np.cos(flat_mm @ wave + rng.uniform(0.0, 2.0 * np.pi))
    height -= height.min()
    return amplitude_mm * height / max(float(height.max()), 1e-300)


def heat(
    newton: Newton,
    activation: float,
    *,
    rng: np.random.Generator,
    options: RampOptions | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[HeatedState]:
    """Follow the equilibrium from the flat film to `activation`; returns the accepted states, flat film first.

    Steps grow where Newton converges quickly and are halved where it does not. Each starts from the linear
    extrapolation of the last two states if that has the smaller residual.

    Raises:
        SolverError: if even the smallest step does not converge.
    """
    options = options or RampOptions()
    shell = newton.shell
    flat = np.column_stack((shell.film.flat_mm, np.zeros(shell.vertex_count)))
    shell.set_activation(activation)
    force_scale = shell.driving_force(flat)
    shell.set_activation(0.0)
    cold = newton.solve(flat, force_scale=force_scale, tolerance=options.tolerance)
    states = [HeatedState(activation=0.0, equilibrium=cold)]
    x = cold.vertices_mm.copy()
    x[:, 2] += smooth_disturbance(shell.film.flat_mm, options.disturbance_mm, rng)
    x.flat[newton.pins] = cold.vertices_mm.flat[newton.pins]
    done, step, earlier = 0.0, options.first_step, None
    while done < 1.0:
        step = min(step, 1.0 - done)
        if 1.0 - done - step < 0.25 * step:
            step = 1.0 - done
        share = 1.0 if step == 1.0 - done else done + step
        shell.set_activation(share * activation)
        start = x
        if earlier is not None:
            predicted = x + (share - done) / (done - earlier[0]) * (x - earlier[1])
            if shell.energy(predicted) < shell.energy(x):
                start = predicted
        tolerance = options.final_tolerance if share == 1.0 else options.tolerance
        try:
            found = newton.solve(start, force_scale=force_scale, tolerance=tolerance)
        except SolverError as error:
            logger.info("activation %.4f: %s", share * activation, error)
            step *= 0.5
            if step < SMALLEST_STEP:
                raise SolverError(
                    f"heating: no equilibrium found beyond {done:.1%} of the contraction ({error}); "
                    "try a finer mesh, or more weight or damping of the design."
                ) from error
            continue
        logger.info("activation %.4f: %d Newton steps", share * activation, found.iterations)
        states.append(HeatedState(activation=share * activation, equilibrium=found))
        earlier = (done, x) if len(states) > 2 else None
        done, x = share, found.vertices_mm
        if progress is not None:
            progress(done)
        if found.iterations <= 8:
            step = min(1.5 * step, options.largest_step)
        elif found.iterations > 20:
            step *= 0.5
    return states
