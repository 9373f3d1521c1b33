"""The fields of the page's form, and the request that they make."""

from typing import Any

from scenes.case import PlanSettings, list_cases, load_case
from scenes.studio.request import JobRequest, read_request

METHODS = (
    ("perpendicular", "Perpendicular", "Scratch across the local incline. Seconds."),
    ("maximum", "Maximum", "Scratch along the largest curvature. Seconds."),
    ("inverse", "Inverse", "Search all layers through the simulated film. Minutes."),
)
IMAGES = (".png", ".tif", ".tiff")
WITHOUT_UP = (*IMAGES, ".npz")
"""Formats whose z is up by definition."""

OPTIONS: dict[str, Any] = {
    "width_mm": "",
    "height_mm": "",
    "up": "+z",
    "depth_mm": "",
    "method": PlanSettings().method,
    "tracer": "",
    "flattening": "",
    "margin_mm": "",
    "layers_mm": "",
    "seed": "",
    "stack": "",
    "robust": False,
    "budget_s": "",
    "temperature_c": "",
    "support": "",
    "modulus_mpa": "",
    "mesh_mm": "",
}
"""Fields with what they begin with; empty leaves it to the commands."""
SOURCES: dict[str, Any] = {"scene": None, "upload": "", "upload_name": "", "calibration": "", "calibration_name": ""}
"""What is opened."""
TARGET_FIELDS = ("scene", "upload", "width_mm", "height_mm", "up", "depth_mm")
"""Fields that decide what the target looks like."""
REQUEST_FIELDS = tuple(name for name in JobRequest.model_fields if name != "size_mm")


def scene_items() -> list[dict[str, str]]:
    """Return the built-in scenes for a list to choose from."""
    return [{"name": case.name, "description": case.description} for case in list_cases()]


def scene_settings(scene: str) -> dict[str, Any]:
    """Return the options that belong to a built-in scene."""
    return {"method": load_case(scene).plan.method}


def form_request(values: dict[str, Any]) -> JobRequest:
    """Return the request of a form.

    Raises:
        InputError: naming each field that is wrong.
    """
    size = [str(values[name]).strip() for name in ("width_mm", "height_mm")]
    asked = {name: values[name] for name in REQUEST_FIELDS}
    # A box with one side of it open is for the command line's own sentence to refuse.
    return read_request({**asked, "size_mm": "x".join(size) if any(size) else None})
