"""The scores of runs beside each other."""

from collections.abc import Sequence
from typing import Any

from scenes.report.facts import SCORES
from scenes.studio.job import Job

MORE = (("triangle_count", "triangles of the mesh", "d"), ("wall_s", "time of the prediction [s]", ".0f"))
"""What else tells runs apart, beside the scores of the report."""


def score_table(jobs: Sequence[Job]) -> list[dict[str, Any]]:
    """Return one row for each number: its label, and its value in each run as text."""
    results = [job.result() or {} for job in jobs]
    rows = []
    for key, label, form in (*SCORES, *MORE):
        values = [result.get(key) for result in results]
        if any(value is not None for value in values):
            texts = ["" if value is None else format(value, form) for value in values]
            rows.append({"label": label, "values": texts})
    return rows


def verdict(result: dict[str, Any]) -> str:
    """Return a result in a few words."""
    if "ssim_eq4" not in result:
        return "not scored: the plan has no target"
    return f"SSIM {100 * result['ssim_eq4']:.1f} %, RMS {result['rms_mm']:.2f} mm"


def one_target(jobs: Sequence[Job]) -> bool:
    """Say whether all runs were scored against the same target, so that their scores compare."""
    return len({(job.result() or {}).get("target_digest") for job in jobs}) <= 1
