"""What one browser sees and does: its own trame server, with its own form, selection and view."""

import asyncio
import logging
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from trame.app import get_server
from trame_vtk.modules import common as vtk_common
from trame_vtk.modules import vtk as vtk_objects

from planner.errors import InputError, LceError
from planner.target import Target
from scenes.sources import open_source
from scenes.studio.form import (
    IMAGES,
    OPTIONS,
    SOURCES,
    TARGET_FIELDS,
    WITHOUT_UP,
    form_request,
    scene_items,
    scene_settings,
)
from scenes.studio.job import Job
from scenes.studio.page import build_page, surfaces_place
from scenes.studio.queue import JobQueue
from scenes.studio.request import HOT, PLAN, JobRequest
from scenes.studio.run_view import run_card, run_details
from scenes.studio.scores import one_target, score_table
from scenes.studio.surfaces import (
    ASPECT_ABOVE_TABLE,
    ASPECT_ALONE,
    Surface3d,
    SurfaceStage,
    shape_surface,
    target_surface,
    target_surface_of,
)

logger = logging.getLogger(__name__)

LOOK_EVERY_S = 0.25
"""How often the queue is looked at while a page is open."""
PATIENCE_WITH_PAGES_S = 3.0
"""How long a page may take to draw, unless it was closed meanwhile."""
PAGES_FOLLOW_S = 20.0
"""In this time every page that is open has heard of new surfaces."""
TYPING_PAUSE_S = 0.4
"""A target is opened when its fields have rested for so long."""
MOST_COMPARED = 4
SHAPE_FILE, TARGET_FILE = Path(HOT, "shape.ply"), Path(PLAN, "target.npz")


class BrowserSession:
    """One browser's page; trame shares a server's state among all that open it, so each browser has its own."""

    def __init__(self, owner: str, queue: JobQueue) -> None:
        """Build the page.

        Args:
            owner: digest that stands for the browser.
            queue: the jobs of the studio, shared by all.
        """
        self.owner, self._queue = owner, queue
        self.server: Any = get_server(f"studio_{owner}", client_type="vue3")
        self._stage: SurfaceStage | None = None
        self._wanted: tuple[Sequence[Surface3d], float] | None = None
        self._drawing = asyncio.Lock()
        self._seen_version = -1
        self._preview_number = 0
        self._target: Target | None = None
        self._asked: dict[str, Target] = {}
        """Targets of this browser's own runs, to show them before they are planned."""
        self._tasks: set[asyncio.Task[None]] = set()
        self._pages = 0
        self.server.state.update(
            {
                "trame__title": "lce studio",
                "scenes": scene_items(),
                "workspace": str(queue.workspace.folder),
                "most_compared": MOST_COMPARED,
                **OPTIONS,
                **SOURCES,
                "uploading": False,
                "opening": False,
                "asks_depth": False,
                "asks_up": False,
                "target": None,
                "problems": [],
                "view": "start",
                "captions": [],
                "runs": [],
                "selected": "",
                "run": None,
                "compared": [],
                "table": {"runs": [], "rows": [], "one_target": True},
            }
        )
        # Pages load what draws surfaces in the beginning, long before there is one to draw.
        self.server.enable_module(vtk_common)
        self.server.enable_module(vtk_objects)
        build_page(self)
        self.server.state.change(*TARGET_FIELDS)(self._target_changed)
        self.server.start(
            exec_mode="task", backend="generic", port=0, open_browser=False, show_connection_info=False, timeout=0
        )

    # what the gateway calls

    def page_opened(self) -> None:
        """Keep the page up to date from now on."""
        self._pages += 1
        if self._pages == 1:
            self._start(self._watch())

    def page_closed(self) -> None:
        """Stop looking at the queue when the last page of this browser is closed."""
        self._pages -= 1

    def uploaded(self, kind: str, path: Path) -> None:
        """Take an uploaded file into the form."""
        name = str(path.relative_to(self._queue.workspace.folder))
        with self.server.state as state:
            state.update({"uploading": False, "problems": []})
            if kind == "calibration":
                state.update({"calibration": name, "calibration_name": path.name})
                return
            state.update({**{field: OPTIONS[field] for field in TARGET_FIELDS if field in OPTIONS}, "scene": None})
            state.update({"upload": name, "upload_name": path.name})
            state.asks_depth = path.suffix in IMAGES
            state.asks_up = path.suffix not in WITHOUT_UP

    def refused(self, problems: Sequence[str]) -> None:
        """Show why an upload was refused."""
        with self.server.state as state:
            state.update({"uploading": False, "problems": list(problems)})

    # what the page calls

    def choose_scene(self, scene: str) -> None:
        """Take a built-in scene into the form."""
        state = self.server.state
        shape = {field: OPTIONS[field] for field in TARGET_FIELDS if field in OPTIONS}
        state.update({**shape, "upload": "", "upload_name": "", "scene": scene, **scene_settings(scene)})
        state.update({"asks_depth": False, "asks_up": False})

    def show_target(self) -> None:
        """Go back to the form's target."""
        state = self.server.state
        state.update({"selected": "", "run": None, "view": "target" if self._target is not None else "start"})
        self._show([] if self._target is None else [target_surface(self._target)])

    def start_run(self) -> None:
        """Put what the form asks for into the queue."""
        state = self.server.state
        try:
            job = self._queue.submit(self._request(), self.owner)
        except InputError as error:
            state.problems = list(error.problems)
            return
        state.problems = []
        if self._target is not None:
            self._asked[job.id] = self._target
        self._refresh()
        self.select(job.id)

    async def cancel(self, job_id: str) -> None:
        """End a run of this browser early."""
        try:
            await self._queue.cancel(job_id, self.owner)
        except InputError as error:
            with self.server.state as state:
                state.problems = list(error.problems)

    def select(self, job_id: str) -> None:
        """Show a run."""
        job = self._queue.jobs.get(job_id)
        if job is None or job_id == self.server.state.selected:
            return
        self.server.state.update({"selected": job_id, "view": "run", "run": run_details(job, self.owner)})
        self._show(self._run_surfaces(job))

    def toggle_compared(self, job_id: str) -> None:
        """Add a run to those compared, or take it away."""
        state = self.server.state
        there = list(state.compared)
        state.compared = [each for each in there if each != job_id] if job_id in there else [*there, job_id]

    def compare(self) -> None:
        """Show the runs that are compared side by side, under their target if they share it."""
        jobs = [self._queue.jobs[each] for each in self.server.state.compared if each in self._queue.jobs]
        jobs = [job for job in jobs if (job.folder / SHAPE_FILE).is_file()][:MOST_COMPARED]
        if len(jobs) < 2:
            return
        shapes = [shape_surface(job.folder / SHAPE_FILE, job.title) for job in jobs]
        shared, target = one_target(jobs), jobs[0].folder / TARGET_FILE
        titles = [
            {"id": job.id, "title": job.title, "options": job.request.options, "created": job.created} for job in jobs
        ]
        self.server.state.update(
            {
                "table": {"runs": titles, "rows": score_table(jobs), "one_target": shared},
                "view": "compare",
                "selected": "",
                "run": None,
            }
        )
        targets = [target_surface_of(target)] if shared and target.is_file() else []
        self._show([*targets, *shapes], aspect=ASPECT_ABOVE_TABLE)

    def turn_home(self) -> None:
        """Look at the surfaces as in the beginning."""
        if self._stage is not None:
            self._stage.turn_home()

    # the rest

    def _request(self) -> JobRequest:
        state = self.server.state
        return form_request({name: state[name] for name in (*OPTIONS, *SOURCES)})

    def _show(self, surfaces: Sequence[Surface3d], *, aspect: float = ASPECT_ALONE) -> None:
        """Put surfaces into the view."""
        self._wanted = surfaces, aspect
        self._start(self._draw())

    async def _draw(self) -> None:
        """Draw what is wanted last, after the pages have drawn what was wanted before."""
        async with self._drawing:
            if self._stage is not None and self._wanted is not None:
                with suppress(TimeoutError):
                    await asyncio.wait_for(self._stage.loaded.wait(), PATIENCE_WITH_PAGES_S)
            if self._wanted is None:
                return
            (surfaces, aspect), self._wanted = self._wanted, None
            with self.server.state as state:
                before, self._stage = self._stage, SurfaceStage(surfaces, aspect=aspect) if surfaces else None
                with surfaces_place(self.server):
                    if self._stage is not None:
                        self._stage.widget()
                state.captions = [{"title": each.title, "size": each.size} for each in surfaces]
            if before is not None:
                self._start(self._close_later(before))

    async def _close_later(self, stage: SurfaceStage) -> None:
        """Let go of surfaces when no page can be drawing them any more."""
        await asyncio.sleep(PAGES_FOLLOW_S)
        with self.server.state as state:
            stage.close(state)

    def _target_changed(self, **_: Any) -> None:
        """Open the target anew, once its fields rest."""
        self._preview_number += 1
        self._start(self._open_target(self._preview_number))

    async def _open_target(self, number: int) -> None:
        await asyncio.sleep(TYPING_PAUSE_S)
        state = self.server.state
        if number != self._preview_number or not (state.scene or state.upload):
            return
        with state:
            state.update({"opening": True, "problems": []})
        found, problems = None, []
        try:
            request = self._request()
            found = await asyncio.to_thread(self._load, request)
        except LceError as error:
            problems = self._queue.workspace.plain(str(error)).splitlines()
        except Exception:
            # Whatever a file does to a loader, the page must say that it is not open.
            logger.exception("target")
            problems = ["target: opening it failed; the studio's own output says why."]
        if number != self._preview_number:
            return
        with state:
            self._target = None if found is None else found[0]
            state.update({"opening": False, "problems": problems})
            state.target = None if self._target is None else _target_facts(self._target)
            state.update({"selected": "", "run": None, "view": "start" if found is None else "target"})
            self._show([] if found is None else [found[1]])

    def _load(self, request: JobRequest) -> tuple[Target, Surface3d]:
        target, _ = open_source(request.source(self._queue.workspace.folder), **request.shape_options)
        return target, target_surface(target)

    async def _watch(self) -> None:
        """Keep the runs up to date while a page is open."""
        while self._pages > 0:
            if self._seen_version != self._queue.version:
                with self.server.state:
                    self._refresh()
            await asyncio.sleep(LOOK_EVERY_S)

    def _refresh(self) -> None:
        """Take over where all jobs stand."""
        self._seen_version = self._queue.version
        state = self.server.state
        jobs = sorted(self._queue.jobs.values(), key=lambda job: job.number, reverse=True)
        state.runs = [run_card(job, self.owner) for job in jobs]
        job = self._queue.jobs.get(state.selected)
        if job is None:
            return
        before, state.run = state.run, run_details(job, self.owner)
        if before is not None and before["state"] != "done" and job.state == "done":
            self._show(self._run_surfaces(job))

    def _run_surfaces(self, job: Job) -> list[Surface3d]:
        """Return what there is of a run to see: the target, and the hot shape if it is predicted."""
        surfaces = []
        if (job.folder / TARGET_FILE).is_file():
            surfaces.append(target_surface_of(job.folder / TARGET_FILE))
        elif job.id in self._asked:
            surfaces.append(target_surface(self._asked[job.id]))
        result = job.result()
        if result is not None:
            surfaces.append(shape_surface(job.folder / SHAPE_FILE, f"Predicted at {result['temperature_c']:g} C"))
        return surfaces

    def _start(self, work: Any) -> None:
        """Start a task and hold it until it is done."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def _target_facts(target: Target) -> dict[str, Any]:
    width, height = target.size_mm
    return {
        "name": target.name,
        "size": f"{width:.1f} x {height:.1f} mm, {target.depth_mm:.1f} mm deep",
        "notes": list(target.notes),
    }
