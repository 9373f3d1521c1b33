"""Heat a film from flat, and cool it again: equilibria along a ramp of activations."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.errors import SolverError
from twin.equilibrium.newton import Equilibrium, Newton
from twin.equilibrium.snap import departs, snapped_mm
from twin.equilibrium.tap import Tap

logger = logging.getLogger(__name__)

SMALLEST_STEP = 1.0 / 512
SNAP_STEP = 1.0 / 48
"""A film that jumps in a step longer than this is followed with steps half as long: it may only have been lost."""
TAPS = 4
"""Taps on the way: at the first accepted temperature past each quarter of the largest contraction, and at the last."""


@dataclass(frozen=True, kw_only=True)
class RampOptions:
    """How a film is heated. Steps are shares of the largest activation."""

    first_step: float = 1.0 / 6
    largest_step: float = 1.0 / 6
    tolerance: float = 1e-6
    """Relative residual at each accepted temperature."""
    final_tolerance: float = 1e-9
    """Relative residual at those that were asked for."""
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
    snapped_mm: float = 0.0
    """How far the film is from the state before when it goes back there: it has jumped, 0 if it comes back."""
    stop: bool = False
    """Whether the ramp was asked to pass here."""


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
    activation: float | Sequence[float],
    *,
    rng: np.random.Generator,
    options: RampOptions | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[HeatedState]:
    """Follow the equilibrium from the flat film to `activation`; returns the accepted states, flat film first.

    Several activations are passed through one after the other, up and down; the states there are its stops.

    Steps grow where Newton converges quickly and are halved where it does not. Each starts from the linear
    extrapolation of the last two states if that has the smaller energy. Where the equilibrium found is far from the
    extrapolation, the way back tells whether the film jumped, see `twin.equilibrium.snap`: then the step is halved,
    and what jumps in short steps too has snapped.

    A film on the plate can be held nearly flat by its weight although it would buckle as soon as it were lifted a
    little: buckling gains energy with the square of the height, weight costs it in proportion, so that no
    infinitesimal disturbance ever starts it. Real films are not that flat. Where the film without weight and plate
    would be unstable, it is therefore tapped: moved by `tap_mm` along its softest mode, both ways, the first by the
    seed, and followed from there if it finds less energy; four times on the way up.

    Raises:
        SolverError: if even the smallest step does not converge.
    """
    options = options or RampOptions()
    shell = newton.shell
    stops = np.atleast_1d(np.asarray(activation, dtype=float))
    largest = float(stops.max())
    flat = np.column_stack((shell.film.flat_mm, np.full(shell.vertex_count, shell.loads.rest_height_mm)))
    force_scale = _force_scale(newton, largest)
    shell.set_activation(0.0)
    cold = newton.solve(flat, force_scale=force_scale, tolerance=options.tolerance)
    start = cold.vertices_mm.copy()
    start[:, 2] += smooth_disturbance(shell.film.flat_mm, options.disturbance_mm, rng)
    start.flat[newton.system.pins] = cold.vertices_mm.flat[newton.system.pins]
    ramp = _Ramp(newton, cold, start, largest=largest, force_scale=force_scale, options=options)
    if shell.loads.heavy and options.tap_mm:
        ramp.tap = Tap(newton, options.tap_mm, force_scale, rng)
    lengths = np.abs(np.diff(stops, prepend=0.0))
    for number, stop in enumerate(stops):
        while not ramp.step_towards(float(stop)):
            if progress is not None:
                left = lengths[number + 1 :].sum() + abs(stop - ramp.states[-1].activation)
                progress(1.0 - float(left) / float(lengths.sum()))
    if progress is not None:
        progress(1.0)
    return ramp.states


def _force_scale(newton: Newton, activation: float) -> float:
    """Norm of all forces on the still-flat film at its full activation, before they cancel."""
    shell = newton.shell
    shell.set_activation(activation)
    return shell.driving_force(np.column_stack((shell.film.flat_mm, np.zeros(shell.vertex_count))))


class _Ramp:
    """The equilibria followed so far, and the step to the next one."""

    def __init__(
        self,
        newton: Newton,
        cold: Equilibrium,
        start_mm: np.ndarray,
        *,
        largest: float,
        force_scale: float,
        options: RampOptions,
    ) -> None:
        self.states = [HeatedState(activation=0.0, equilibrium=cold)]
        self.tap: Tap | None = None
        self._newton, self._options = newton, options
        self._largest, self._force_scale = largest, force_scale
        self._step = options.first_step * largest
        self._start_mm = start_mm
        self._earlier: HeatedState | None = None
        self._jump: float | None = None

    def step_towards(self, stop: float) -> bool:
        """Go one step towards an activation, or shorten the step if it fails; returns whether it is reached.

        Raises:
            SolverError: if even the smallest step does not converge.
        """
        newton, before = self._newton, self.states[-1]
        left = abs(stop - before.activation)
        length = min(self._step, left)
        arrives = length == left or left - length < 0.25 * length
        if arrives:
            length, activation = left, stop
        else:
            activation = before.activation + float(np.copysign(length, stop - before.activation))
        newton.shell.set_activation(activation)
        predicted = self._extrapolated(activation)
        start = self._start_mm
        if predicted is not None and newton.shell.energy(predicted) < newton.shell.energy(start):
            start = predicted
        tolerance = self._options.final_tolerance if arrives else self._options.tolerance
        try:
            found = newton.solve(start, force_scale=self._force_scale, tolerance=tolerance)
        except SolverError as error:
            logger.info("activation %.4f: %s", activation, error)
            self._step = 0.5 * length
            if self._step < SMALLEST_STEP * self._largest:
                raise SolverError(
                    f"heating: no equilibrium found beyond {before.activation:.1%} of the full contraction "
                    f"({error}); try a finer mesh, or a design with less contraction."
                ) from error
            return False
        snapped = self._snapped_mm(found, activation, predicted)
        if snapped and length > SNAP_STEP * self._largest:
            logger.info("activation %.4f: the way back misses by %.2f mm", activation, snapped)
            self._step, self._jump = 0.5 * length, activation
            return False
        logger.info("activation %.4f: %d Newton steps", activation, found.iterations)
        self._accept(HeatedState(activation=activation, equilibrium=found, snapped_mm=snapped, stop=arrives), tolerance)
        if found.iterations > 20:
            self._step *= 0.5
        elif found.iterations <= 8 and self._jump is None:
            self._step = min(1.5 * self._step, self._options.largest_step * self._largest)
        return arrives

    def _extrapolated(self, activation: float) -> np.ndarray | None:
        """Return the shape on the line through the last two states; None at the start, at a turn, after a jump."""
        last, earlier = self.states[-1], self._earlier
        if earlier is None or (activation - last.activation) * (last.activation - earlier.activation) <= 0.0:
            return None
        ratio = (activation - last.activation) / (last.activation - earlier.activation)
        return self._start_mm + ratio * (self._start_mm - earlier.equilibrium.vertices_mm)

    def _snapped_mm(self, found: Equilibrium, activation: float, predicted_mm: np.ndarray | None) -> float:
        """Return how far the film jumped since the last state [mm], 0 if it did not; asked only where it may have."""
        last = self.states[-1]
        # cold, the film has no other shape than flat
        if last.activation in (0.0, activation) or not departs(self._start_mm, predicted_mm, found.vertices_mm):
            return 0.0
        way_back = snapped_mm(
            self._newton,
            last.equilibrium,
            found,
            last.activation,
            force_scale=self._force_scale,
            tolerance=self._options.tolerance,
        )
        self._newton.prescribe(activation, found.vertices_mm)
        return way_back

    def _accept(self, state: HeatedState, tolerance: float) -> None:
        """Append a state, tapped where it is time."""
        last, first = self.states[-1], len(self.states) == 1
        if self.tap is not None and self._tap_is_due(last.activation, state.activation):
            tapped = self.tap(state.equilibrium, tolerance)
            state = replace(state, equilibrium=tapped.equilibrium, tapped_away_mm=tapped.moved_mm)
            self._newton.prescribe(state.activation, state.equilibrium.vertices_mm)
        # nothing can be extrapolated across a jump, nor from the start, which may be disturbed
        self._earlier = None if first or state.tapped_away_mm or state.snapped_mm else last
        if self._jump is not None and (state.activation - self._jump) * (state.activation - last.activation) >= 0.0:
            self._jump = None
        self.states.append(state)
        self._start_mm = state.equilibrium.vertices_mm

    def _tap_is_due(self, before: float, after: float) -> bool:
        return after > before and int(TAPS * after / self._largest) > int(TAPS * before / self._largest)
