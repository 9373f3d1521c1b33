"""The stages of an inverse design, each starting from the last one's film."""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.interpolate import CubicSpline

from planner.calibration import Calibration
from planner.plan import program_points
from planner.program import Machine, Pass
from planner.target import Target, mesh_outline
from twin.film import Film, carry, film_from_alignment, outline_of
from twin.inverse.anchor import STIFFENING, Anchor, carry_forms, forms_on_target
from twin.inverse.at_target import FirstDesign, design_at_target
from twin.inverse.basin import WEIGHTS_PER_MM3, descend, descend_in_basin, harden_in_basin, ramped
from twin.inverse.field_control import FieldControl
from twin.inverse.harden import Hardening
from twin.inverse.mismatch import Mismatch
from twin.inverse.noise import ProcessErrors, searched
from twin.inverse.on_the_way import OnTheWay
from twin.inverse.options import InverseOptions
from twin.inverse.painted import painted_layer
from twin.inverse.pass_control import PassControl
from twin.inverse.refine import Control, Design, Refinement
from twin.inverse.search import EVALUATIONS, ROUNDS, STEPS, Search
from twin.inverse.traced import (
    TracedLayer,
    contraction_range,
    pass_bounds,
    pass_contraction,
    trace_layer,
    with_contraction,
)
from twin.inverse.world import World
from twin.predict import ramp_end

SATURATION = 0.95
"""Largest contraction of the smooth fields, as a share of the calibration's: room for the passes to correct."""
FIELD_SMOOTHNESS = 1e-4
FIELD_DAMPING = 1e-3
PASS_SMOOTHNESS = 1e-4
PASS_DAMPING = 1e-4
FIELD_WEIGHTS_PER_MM3 = (1e-3, 1e-2, 5e-2)
"""Weights of the anchor for the smooth fields, each tried where the passes of the one before snap elsewhere."""
ROBUST_WEIGHTS_PER_MM3 = WEIGHTS_PER_MM3[:2]
"""Weights for the plain steps of a robust design: under less, its noisy films snap."""
PASS_WEIGHT_SHARE = 0.1
"""Weight of the anchor for the passes, over that for their fields: small, since they start from fields that it has
shaped, and the gaps between lines are no fault that speeds could mend.

A robust design keeps all of it: the anchor also holds down what noise does, and hardening lets it go by itself."""
OUTLINE_STEP_MM = 0.5


@dataclass(frozen=True, kw_only=True, eq=False)
class Field:
    """A smooth design on its mesh: what one stage hands to the next, enough to go on from."""

    stage: str
    """Stage that made it, `coarse` or `middle`."""
    outline_mm: np.ndarray
    """Cut line of the flat film [mm], shape [k, 2]."""
    flat_mm: np.ndarray
    """Vertices of the flat film [mm], shape [n, 2]."""
    triangles: np.ndarray
    """Vertex indices, shape [m, 3]."""
    u: np.ndarray
    """Variables of a `FieldControl`, shape [fields, n, 2]."""
    vertices_mm: np.ndarray
    """Its equilibrium [mm], shape [n, 3]."""
    forms: np.ndarray
    """Fundamental forms a*, b* that the film would have on the target, for the anchor, shape [m, 6]."""
    weight_per_mm3: float
    """Weight of the anchor that the design was found with."""
    hold: np.ndarray
    """Factor on it in each triangle, shape [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DesignedPasses:
    """The passes of each layer, and the shape that they were designed to have."""

    layers: tuple[tuple[Pass, ...], ...]
    flat_mm: np.ndarray
    """Vertices of the flat film [mm], shape [n, 2]."""
    triangles: np.ndarray
    """Vertex indices, shape [m, 3]."""
    vertices_mm: np.ndarray
    """Mid-surface [mm], shape [n, 3]."""


class Stages:
    """The stages for one target, calibration and set of options."""

    def __init__(self, target: Target, calibration: Calibration, options: InverseOptions, search: Search) -> None:
        """Prepare; `search` is told of every step."""
        self._target, self._calibration, self._options, self._search = target, calibration, options, search
        self._thickness = np.array(options.layer_thickness_mm)
        self._activation = ramp_end(options.heated)
        self._line_width_mm = options.heated.film.line_width_mm or options.line_width_mm
        self.largest = contraction_range(calibration)[1]

    def at_target(self, target: Target, *, thickness: float = 1.0, contraction: float = 1.0) -> FirstDesign:
        """Return the first design for a target, with factors on the layers' thickness and the largest contraction."""
        return design_at_target(
            target,
            edge_mm=_edge_mm(target.outline_mm, self._options.coarse_triangles),
            layer_thickness_mm=thickness * self._thickness,
            largest=contraction * SATURATION * self.largest,
            stack=self._options.stack,
            activation=self._activation,
            seed=self._options.seed,
        )

    def coarse(self) -> Field:
        """Design at the target, then through the equilibrium, in the basin that the ramp from flat finds."""
        first = self.at_target(self._target)
        flat, triangles = first.flat_mm, first.triangles
        control = self._control(triangles, len(flat))
        world = self._world(flat, triangles, control.q(first.u))
        forms = forms_on_target(first.vertices_mm, flat, triangles)
        refinement = self._refinement(world, control, forms, np.ones(len(triangles)), WEIGHTS_PER_MM3[0])
        go_on = self._search.watcher("coarse", triangles)
        weights = ROBUST_WEIGHTS_PER_MM3 if self._options.robust else WEIGHTS_PER_MM3
        try:
            design = refinement.design(first.u, world.ramp(control.q(first.u)))
            go_on(design)
            design = descend_in_basin(
                refinement, world, design, weights_per_mm3=weights, steps=STEPS["coarse"], go_on=go_on
            )
            if self._options.robust:
                design = refinement.weighed(design, ROBUST_WEIGHTS_PER_MM3[-1])
                design = self._descended(refinement, world, control, design, "coarse", go_on)
        finally:
            world.newton.close()
        return Field(
            stage="coarse",
            outline_mm=_smooth_loop(outline_of(self._film(flat, triangles, design.q))),
            flat_mm=flat,
            triangles=triangles,
            u=design.p,
            vertices_mm=design.shape.vertices_mm,
            forms=forms,
            weight_per_mm3=refinement.weight_per_mm3,
            hold=refinement.anchor.hold,
        )

    def middle(self, coarse: Field, weight_per_mm3: float = FIELD_WEIGHTS_PER_MM3[0]) -> Field:
        """Refine a coarse design, or an earlier one of this stage, on a finer mesh under a weight of the anchor."""
        flat, triangles = self._mesh(coarse.outline_mm, self._options.middle_triangles)
        carried = carry(coarse.flat_mm, np.hstack((coarse.vertices_mm, *coarse.u)), flat)
        start_mm, u = carried[:, :3], np.stack(np.split(carried[:, 3:], len(coarse.u), axis=1))
        forms, hold = _carried_anchor(coarse, flat, triangles)
        control = self._control(triangles, len(flat))
        world = self._world(flat, triangles, control.q(u))
        refinement = self._refinement(world, control, forms, hold, weight_per_mm3)
        go_on = self._search.watcher("middle", triangles)
        try:
            design = self._descended(refinement, world, control, refinement.design(u, start_mm), "middle", go_on)
        finally:
            world.newton.close()
        return Field(
            stage="middle",
            outline_mm=coarse.outline_mm,
            flat_mm=flat,
            triangles=triangles,
            u=design.p,
            vertices_mm=design.shape.vertices_mm,
            forms=forms,
            weight_per_mm3=refinement.weight_per_mm3,
            hold=refinement.anchor.hold,
        )

    def weights_after(self, field: Field) -> list[float]:
        """Return the weights of the anchor that are left for the middle stage to try after a field.

        A robust design goes on under the weight that its coarse one ended with, see `PASS_WEIGHT_SHARE`.
        """
        if field.stage == "middle":
            return [weight for weight in FIELD_WEIGHTS_PER_MM3 if weight > field.weight_per_mm3]
        first = max(FIELD_WEIGHTS_PER_MM3[0], field.weight_per_mm3 if self._options.robust else 0.0)
        return [first, *(weight for weight in FIELD_WEIGHTS_PER_MM3 if weight > 2.0 * first)]

    def lines(self, field: Field, machine: Machine) -> tuple[TracedLayer, ...]:
        """Trace each layer's field with passes that a machine can scratch in its time."""
        fields = self._control(field.triangles, len(field.flat_mm)).vertex_q(field.u)

        def trace(index: int) -> TracedLayer:
            return trace_layer(
                field.flat_mm,
                field.triangles,
                fields[index],
                self._calibration,
                machine=machine,
                index=index,
                layers=len(fields),
                line_width_mm=self._line_width_mm,
                seed=self._options.seed,
            )

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return tuple(pool.map(trace, range(len(fields))))

    def passes(self, field: Field, traced: tuple[TracedLayer, ...]) -> tuple[DesignedPasses, bool]:
        """Optimise the speeds along traced passes, through the film that they really make.

        Returns:
            The passes, and whether the ramp from flat ends in the shape that was designed; where it does not, the shape
            is the ramp's.
        """
        flat, triangles = self._mesh(field.outline_mm, self._options.pass_triangles)
        start = DesignedPasses(
            layers=tuple(layer.passes for layer in traced),
            flat_mm=flat,
            triangles=triangles,
            vertices_mm=carry(field.flat_mm, field.vertices_mm, flat),
        )
        go_on = self._search.watcher("passes", triangles)
        with self._opened(field, start) as (refinement, world, control, design):
            design = self._descended(refinement, world, control, design, "passes", go_on)
            design, landed = ramped(refinement, world, design)
            return self._with_speeds(start, control, design), landed

    def finish(self, field: Field, designed: DesignedPasses, *, recover: bool) -> tuple[DesignedPasses, bool]:
        """Go on on the mesh of the check: a coarser one's ramp may end in another shape of the film.

        Args:
            field: that the passes trace.
            designed: the passes.
            recover: whether to make the best of another shape if the ramp ends in one.

        Returns:
            The passes, and whether the ramp from flat ends in the shape that was designed, or was made the best of.
        """
        flat, triangles = mesh_outline(np.asarray(program_points(field.outline_mm)), self._options.heated.film.mesh_mm)
        start = DesignedPasses(
            layers=designed.layers,
            flat_mm=flat,
            triangles=triangles,
            vertices_mm=carry(designed.flat_mm, designed.vertices_mm, flat),
        )
        go_on = self._search.watcher("finish", triangles)
        with self._opened(field, start) as (refinement, world, control, design):
            landed = True
            if self._options.robust:
                design = self._descended(refinement, world, control, design, "finish", go_on)
            elif recover:
                weights = (refinement.weight_per_mm3,)
                design = descend_in_basin(
                    refinement, world, design, weights_per_mm3=weights, steps=STEPS["finish"], go_on=go_on
                )
            else:
                design = descend(refinement, design, steps=STEPS["finish"], go_on=go_on)
                design, landed = ramped(refinement, world, design)
            return self._with_speeds(start, control, design), landed

    def _with_speeds(self, start: DesignedPasses, control: PassControl, design: Design) -> DesignedPasses:
        counts = np.cumsum([sum(len(stroke.speed_mm_s) for stroke in passes) for passes in start.layers])[:-1]
        return replace(
            start,
            layers=tuple(
                with_contraction(passes, own, self._calibration)
                for passes, own in zip(start.layers, np.split(control.contraction(design.p), counts), strict=True)
            ),
            vertices_mm=design.shape.vertices_mm,
        )

    @contextmanager
    def _opened(self, field: Field, start: DesignedPasses) -> Iterator[tuple[Refinement, World, PassControl, Design]]:
        """Make ready to refine the speeds along passes, with their equilibrium near the start."""
        bounds = field.outline_mm.min(axis=0) - 1.0, field.outline_mm.max(axis=0) + 1.0
        post, corners = self._options.heated.film, start.flat_mm[start.triangles]

        def paint(passes: tuple[Pass, ...]) -> tuple[sp.csr_matrix, sp.csr_matrix]:
            return painted_layer(passes, self._calibration, corners, bounds, post, self._line_width_mm)

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            painted = list(pool.map(paint, start.layers))
        ranges = [pass_bounds(passes, self._calibration) for passes in start.layers]
        control = PassControl(
            painted,
            [[len(stroke.speed_mm_s) for stroke in passes] for passes in start.layers],
            np.concatenate([low for low, _ in ranges]),
            np.concatenate([high for _, high in ranges]),
            smoothness=PASS_SMOOTHNESS,
            damping=PASS_DAMPING,
        )
        p = control.start(np.concatenate([pass_contraction(passes, self._calibration) for passes in start.layers]))
        world = self._world(start.flat_mm, start.triangles, control.q(p))
        forms, hold = _carried_anchor(field, start.flat_mm, start.triangles)
        share = 1.0 if self._options.robust else PASS_WEIGHT_SHARE
        refinement = self._refinement(world, control, forms, hold, share * field.weight_per_mm3)
        try:
            yield refinement, world, control, refinement.design(p, start.vertices_mm)
        finally:
            world.newton.close()

    def ideal_film(self, field: Field) -> Film:
        """Return the film that would have learned a smooth field exactly, without passes."""
        control = self._control(field.triangles, len(field.flat_mm))
        return self._film(field.flat_mm, field.triangles, control.q(field.u))

    def _film(self, flat_mm: np.ndarray, triangles: np.ndarray, q: np.ndarray) -> Film:
        return film_from_alignment(flat_mm, triangles, q, layer_thickness_mm=self._thickness)

    def _mesh(self, outline_mm: np.ndarray, triangles: int) -> tuple[np.ndarray, np.ndarray]:
        return mesh_outline(outline_mm, _edge_mm(outline_mm, triangles))

    def _control(self, triangles: np.ndarray, count: int) -> FieldControl:
        return FieldControl(
            triangles,
            count,
            layers=len(self._thickness),
            stack=self._options.stack,
            largest=SATURATION * self.largest,
            smoothness=FIELD_SMOOTHNESS,
            damping=FIELD_DAMPING,
        )

    def _world(self, flat_mm: np.ndarray, triangles: np.ndarray, q: np.ndarray) -> World:
        return World(self._film(flat_mm, triangles, q), Mismatch(self._target, triangles), self._options.heated)

    def _refinement(
        self, world: World, control: Control, forms: np.ndarray, hold: np.ndarray, weight_per_mm3: float
    ) -> Refinement:
        area = world.newton.shell.film.area_mm2
        metric = STIFFENING if self._options.robust else 1.0
        anchor = Anchor(forms, area, self._thickness, self._activation, hold=hold, metric=metric)
        return Refinement(world, control, anchor, weight_per_mm3=weight_per_mm3)

    def _descended(
        self,
        refinement: Refinement,
        world: World,
        control: Control,
        design: Design,
        stage: str,
        go_on: Callable[[Design], bool],
    ) -> Design:
        """Take a stage's plain steps; harden a robust design, which takes them where no hardened one lands."""
        if self._options.robust:
            with self._hardening(refinement, world, control) as hardening:
                hardened = harden_in_basin(
                    refinement,
                    hardening,
                    world,
                    design,
                    rounds=ROUNDS[stage],
                    evaluations=EVALUATIONS[stage],
                    go_on=go_on,
                    progress=lambda share: self._search.report(stage, share),
                )
            if hardened is not design:
                return hardened
        return descend(refinement, design, steps=STEPS[stage], go_on=go_on)

    @contextmanager
    def _hardening(self, refinement: Refinement, world: World, control: Control) -> Iterator[Hardening]:
        """Make ready to harden the designs of a film."""
        film = world.newton.shell.film
        errors = ProcessErrors(film, searched(self._options.noise), seed=self._options.seed)
        on_the_way = OnTheWay(self._world(film.flat_mm, film.triangles, film.alignment), errors)
        try:
            yield Hardening(refinement, world, control, errors, on_the_way)
        finally:
            on_the_way.close()


def _carried_anchor(field: Field, flat_mm: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a field's forms, [m, 6], and hold, [m], on another mesh of its film."""
    own = np.column_stack((field.forms, field.hold))
    carried = carry_forms(field.flat_mm[field.triangles].mean(axis=1), own, flat_mm[triangles].mean(axis=1))
    return carried[:, :6], carried[:, 6]


def _smooth_loop(loop_mm: np.ndarray) -> np.ndarray:
    """Return a closed line through the points of another, smooth, its points OUTLINE_STEP_MM apart."""
    closed = np.vstack((loop_mm, loop_mm[:1]))
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))))
    spline = CubicSpline(along, closed, bc_type="periodic")
    return spline(np.linspace(0.0, along[-1], int(along[-1] / OUTLINE_STEP_MM) + 1)[:-1])


def _edge_mm(outline_mm: np.ndarray, triangles: int) -> float:
    """Return the edge length that fills an outline with about so many triangles."""
    x, y = outline_mm.T
    area = 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    return float(np.sqrt(4.0 / np.sqrt(3.0) * area / triangles))
