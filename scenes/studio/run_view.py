"""A job in the words of the page: its card in the list, and its details."""

from typing import Any

from scenes.studio.job import DOWNLOADS, Job
from scenes.studio.request import STEPS
from scenes.studio.scores import verdict

LOG_LINES = 200


def run_card(job: Job, owner: str) -> dict[str, Any]:
    """Return what the list shows of a job to the browser that `owner` stands for."""
    result = job.result() if job.state == "done" else None
    stage, share = next(reversed(job.stages.items()), ("starting", 0.0))
    return {
        "id": job.id,
        "title": job.title,
        "options": job.request.options,
        "created": job.created,
        "state": job.state,
        "mine": job.owner == owner,
        "verdict": "" if result is None else verdict(result),
        "doing": f"{STEPS.get(job.step, '')}: {stage}",
        "percent": round(100 * share),
        "message": job.message.splitlines()[0] if job.message else "",
    }


def run_details(job: Job, owner: str) -> dict[str, Any]:
    """Return what the page shows of the selected job."""
    result = job.result()
    return {
        **run_card(job, owner),
        "problems": job.message.splitlines(),
        "steps": _steps(job),
        "stages": [{"name": name, "percent": round(100 * share)} for name, share in job.stages.items()],
        "note": job.note,
        "verdict": "" if result is None else verdict(result),
        "paper": "" if result is None else f"the paper's best face: {100 * result['paper_ssim']:.1f} %",
        "depth": _depth(result),
        "warnings": [] if result is None else result["warnings"],
        "files": [name for name in DOWNLOADS if job.download(name)],
        "log": job.log_tail(LOG_LINES),
    }


def _steps(job: Job) -> list[dict[str, str]]:
    """Return each step with where it stands."""
    names = list(STEPS)
    now = names.index(job.step) if job.step in names else -1
    steps = []
    for place, name in enumerate(names):
        if job.state == "done" or place < now:
            state = "done"
        elif place == now:
            state = job.state
        else:
            state = "queued" if job.waits_or_runs else "left out"
        steps.append({"name": STEPS[name], "state": state})
    return steps


def _depth(result: dict[str, Any] | None) -> str:
    if result is None or "depth_mm" not in result:
        return ""
    return f"{result['depth_mm']:.1f} of {result['target_depth_mm']:.1f} mm deep"
