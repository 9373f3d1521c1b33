"""Heat a film from flat: a ramp of equilibria that ends at full temperature."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from planner.errors import SolverError
from twin.equilibrium.held import HeldSystem
from twin.equilibrium.newton import Equilibrium, Newton
from twin.equilibrium.pins import rigid_pins

logger = logging.getLogger(__name__)

SMALLEST_STEP = 1.0 / 512
TAPS = 4
"""Taps on the way: at the first accepted temperature past each quarter of the final contraction, and at the last."""
LEAST_GAIN = 1e-6
"""Relative energy that another state must gain to count as another one."""


@dataclass(frozen=True, kw_only=True)
class RampOptions:
    """How a film is heated."""

    first_step: float = 1.0 / 6
    """First step, as a share of the final activation."""
    largest_step: float = 1.0 / 6
    tolerance: float = 1e-6
    """Relative residual at each accepted temperature."""
    final_tolerance: float = 1e-9
    """Relative residual at the last one."""
    disturbance_mm: float = 1e-3
    """Amplitude of the seeded smooth disturbance of the flat film."""
    tap_mm: float = 0.4
    """Amplitude of the tap that a film held down only by its weight gets, 0 for none; see `heat`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HeatedState:
    """One accepted temperature of the ramp."""

    activation: float
    """Fraction of the full contraction."""
    equilibrium: Equilibrium
    tapped_away_mm: float = 0.0
    """How far a tap moved the film out of the state that it was held in by its weight, 0 if it came back."""


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
    extrapolation of the last two states if that has the smaller energy.

    A film on the plate can be held nearly flat by its weight although it would buckle as soon as it were lifted a
    little: buckling gains energy with the square of the height, weight costs it in proportion, so that no
    infinitesimal disturbance ever starts it. Real films are not that flat. Where the film without weight and plate
    would be unstable, it is therefore tapped: moved by `tap_mm` along its softest mode, both ways, the first by the
    seed, and followed from there if it finds less energy; four times on the way.

    Raises:
        SolverError: if even the smallest step does not converge.
    """
    options = options or RampOptions()
    shell = newton.shell
    flat = np.column_stack((shell.film.flat_mm, np.full(shell.vertex_count, shell.loads.rest_height_mm)))
    force_scale = _force_scale(newton, activation)
    shell.set_activation(0.0)
    cold = newton.solve(flat, force_scale=force_scale, tolerance=options.tolerance)
    states = [HeatedState(activation=0.0, equilibrium=cold)]
    x = cold.vertices_mm.copy()
    x[:, 2] += smooth_disturbance(shell.film.flat_mm, options.disturbance_mm, rng)
    x.flat[newton.system.pins] = cold.vertices_mm.flat[newton.system.pins]
    tap = _Tap(newton, options, force_scale, rng) if shell.loads.weight and options.tap_mm else None
    return [
        *states,
        *_follow(newton, x, (0.0, activation), force_scale=force_scale, options=options, tap=tap, progress=progress),
    ]


def cool(
    newton: Newton,
    heated: Sequence[HeatedState],
    *,
    options: RampOptions | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[HeatedState]:
    """Follow the equilibrium back from the last of `heated` through the same activations to the cold film.

    Returns one state for each of `heated`, in their order (cold first); the last is that of `heated` itself. Where a
    state differs from its heated twin, the film has snapped in between: heating and cooling took different paths.

    Raises:
        SolverError: if even the smallest step does not converge.
    """
    options = options or RampOptions()
    force_scale = _force_scale(newton, heated[-1].activation)
    cooled = [heated[-1]]
    for number, (hot, cold) in enumerate(pairwise(reversed(heated)), start=1):
        ends = hot.activation, cold.activation
        start = cooled[-1].equilibrium.vertices_mm
        single = replace(options, first_step=1.0, largest_step=1.0, final_tolerance=options.tolerance)
        if cold.activation == 0.0:
            single = replace(single, final_tolerance=options.final_tolerance)
        cooled.append(_follow(newton, start, ends, force_scale=force_scale, options=single)[-1])
        if progress is not None:
            progress(number / (len(heated) - 1))
    return cooled[::-1]


def _force_scale(newton: Newton, activation: float) -> float:
    """Norm of all forces on the still-flat film at its full activation, before they cancel."""
    shell = newton.shell
    shell.set_activation(activation)
    return shell.driving_force(np.column_stack((shell.film.flat_mm, np.zeros(shell.vertex_count))))


def _follow(
    newton: Newton,
    start_mm: np.ndarray,
    ends: tuple[float, float],
    *,
    force_scale: float,
    options: RampOptions,
    tap: "_Tap | None" = None,
    progress: Callable[[float], None] | None = None,
) -> list[HeatedState]:
    """Follow the equilibrium from one activation to another; the state at the first is not returned."""
    shell, (begin, end) = newton.shell, ends
    states: list[HeatedState] = []
    x, done, step, earlier = start_mm, 0.0, options.first_step, None
    while done < 1.0:
        step = min(step, 1.0 - done)
        if 1.0 - done - step < 0.25 * step:
            step = 1.0 - done
        share = 1.0 if step == 1.0 - done else done + step
        activation = begin + share * (end - begin)
        shell.set_activation(activation)
        start = x
        if earlier is not None:
            predicted = x + (share - done) / (done - earlier[0]) * (x - earlier[1])
            if shell.energy(predicted) < shell.energy(x):
                start = predicted
        tolerance = options.final_tolerance if share == 1.0 else options.tolerance
        try:
            found = newton.solve(start, force_scale=force_scale, tolerance=tolerance)
        except SolverError as error:
            logger.info("activation %.4f: %s", activation, error)
            step *= 0.5
            if step < SMALLEST_STEP:
                raise SolverError(
                    f"heating: no equilibrium found beyond {begin + done * (end - begin):.1%} of the full contraction "
                    f"({error}); try a finer mesh, or a design with less contraction."
                ) from error
            continue
        state = HeatedState(activation=activation, equilibrium=found)
        if tap is not None and int(share * TAPS) > int(done * TAPS):
            state = tap(state, tolerance)
        logger.info("activation %.4f: %d Newton steps", activation, state.equilibrium.iterations)
        # nothing can be extrapolated across a jump, nor from the start, which may be disturbed
        earlier = (done, x) if states and not state.tapped_away_mm else None
        states.append(state)
        done, x = share, state.equilibrium.vertices_mm
        if progress is not None:
            progress(done)
        if found.iterations <= 8:
            step = min(1.5 * step, options.largest_step)
        elif found.iterations > 20:
            step *= 0.5
    return states


class _Tap:
    """Tap a film that only its weight holds down, and see whether it comes back."""

    def __init__(self, newton: Newton, options: RampOptions, force_scale: float, rng: np.random.Generator) -> None:
        self._newton, self._force_scale, self._amplitude_mm = newton, force_scale, options.tap_mm
        self._first_sign = rng.choice((-1.0, 1.0))
        shell = newton.shell
        pins = rigid_pins(shell.film.flat_mm, on_plate=False)
        self._weightless = HeldSystem(shell.pattern, pins, newton.system.solver)

    def __call__(self, state: HeatedState, tolerance: float) -> HeatedState:
        """Return the state itself, or the one with less energy that a tap leads to."""
        held = state.equilibrium
        values = self._newton.shell.elastic_hessian(held.vertices_mm)
        if self._weightless.factorize(values):
            return state
        mode = self._weightless.softest_mode(values)
        for sign in (self._first_sign, -self._first_sign):
            tapped = held.vertices_mm + sign * self._amplitude_mm * mode
            tapped[:, 2] -= min(0.0, float(tapped[:, 2].min()))
            try:
                found = self._newton.solve(tapped, force_scale=self._force_scale, tolerance=tolerance)
            except SolverError as error:
                logger.info("tap: %s", error)
                continue
            if found.energy < held.energy - LEAST_GAIN * abs(held.energy):
                moved = float(np.linalg.norm(found.vertices_mm - held.vertices_mm, axis=1).max())
                logger.info("activation %.4f: a tap moved the film by %.2f mm", state.activation, moved)
                return HeatedState(activation=state.activation, equilibrium=found, tapped_away_mm=moved)
        return state
