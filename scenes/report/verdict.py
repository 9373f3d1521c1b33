"""The verdict: the few numbers and sentences that a reader must see first."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A number with what it is."""

    label: str
    value: str
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class Meter:
    """The similarity on a scale from 0 to 100 % beside the paper's."""

    value_percent: float
    paper_percent: float
    spread_percent: tuple[float, float] | None
    """Lower and upper end of what the calibration, or else the noise of the process, leaves possible."""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What is said first."""

    sentence: str
    figures: tuple[Figure, ...]
    meter: Meter | None
    """None where nothing was scored."""
    spreads: tuple[str, ...]
    """How far the score is open, and why."""
    warnings: tuple[str, ...]


def make_verdict(result: dict[str, Any]) -> Verdict:
    """Draw the verdict from the content of result.json."""
    scored = "ssim_eq4" in result
    return Verdict(
        sentence=_sentence(result),
        figures=(*(_score_figures(result) if scored else _shape_figures(result)), _machine_time(result)),
        meter=_meter(result) if scored else None,
        spreads=tuple(_spreads(result)),
        warnings=(*result["warnings"], *(_problem(problem) for problem in result["machine"]["problems"])),
    )


def duration(seconds: float) -> str:
    """Write a time as one says it: 40 s, 39 min, 1 h 50 min."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    hours = f"{minutes // 60} h" if minutes >= 60 else ""
    rest = f"{minutes % 60} min" if minutes % 60 else ""
    return f"{hours} {rest}".strip()


def _sentence(result: dict[str, Any]) -> str:
    if "ssim_eq4" in result:
        return (
            f"SSIM {100 * result['ssim_eq4']:.1f} %, where the paper's best printed face reached "
            f"{100 * result['paper_ssim']:.1f} % by the same equation. This is a simulation: its score is comparable "
            "only as far as the calibration is."
        )
    if "bending_radius_mm" in result:
        return (
            f"The strip bends to a radius of {result['bending_radius_mm']:.3g} mm in its middle, where the calibration "
            f"promises {result['promised_radius_mm']:.3g} mm."
        )
    return "There was no target: the shape was not scored."


def _score_figures(result: dict[str, Any]) -> tuple[Figure, ...]:
    return (
        Figure(
            label="similarity (SSIM)",
            value=f"{100 * result['ssim_eq4']:.1f} %",
            note=f"paper: {100 * result['paper_ssim']:.1f} %",
        ),
        Figure(
            label="distance (RMS)",
            value=f"{result['rms_mm']:.2f} mm",
            note=f"{result['rms_percent_of_diagonal']:.1f} % of the diagonal; largest {result['hausdorff_mm']:.1f} mm",
        ),
        Figure(
            label="depth",
            value=f"{result['depth_mm']:.1f} mm",
            note=f"target: {result['target_depth_mm']:.1f} mm",
        ),
    )


def _shape_figures(result: dict[str, Any]) -> tuple[Figure, ...]:
    """Say of a shape without a target how deep it is, and of a strip how far it bends."""
    hottest = max(result["stops"], key=lambda stop: stop["temperature_c"])
    depth = Figure(label="depth", value=f"{hottest['depth_mm']:.1f} mm", note="no target")
    if "bending_radius_mm" not in result:
        return (depth,)
    promised = f"calibration: {result['promised_radius_mm']:.3g} mm"
    return Figure(label="bending radius", value=f"{result['bending_radius_mm']:.3g} mm", note=promised), depth


def _machine_time(result: dict[str, Any]) -> Figure:
    scratch_s = sum(layer["total_s"] for layer in result["layers"])
    other = f"scratching; and {duration(result['machine']['reset_and_cure_s'])} of reset and cure"
    return Figure(label="machine time", value=duration(scratch_s), note=other)


def _meter(result: dict[str, Any]) -> Meter:
    spread = None
    if "score_band" in result:
        spread = result["score_band"]["ssim_eq4"]["low"], result["score_band"]["ssim_eq4"]["high"]
    elif "noise" in result:
        ends = list(result["noise"]["percentiles"]["ssim_eq4"].values())
        spread = ends[0], ends[-1]
    return Meter(
        value_percent=100 * result["ssim_eq4"],
        paper_percent=100 * result["paper_ssim"],
        spread_percent=None if spread is None else (100 * spread[0], 100 * spread[1]),
    )


def _spreads(result: dict[str, Any]) -> list[str]:
    told = []
    if "score_band" in result:
        band = result["score_band"]
        ssim, rms = band["ssim_eq4"], band["rms_mm"]
        low, _, high = band["percent"]
        told.append(
            f"As well as calibration '{band['calibration']}' is known: SSIM {100 * ssim['low']:.1f} to "
            f"{100 * ssim['high']:.1f} %, RMS {rms['low']:.2f} to {rms['high']:.2f} mm ({low} to {high} % of "
            f"{band['draws']} films with maps that its strips leave possible, on a mesh of {band['mesh_mm']:g} mm, "
            f"where the calibration itself gives {100 * ssim['expected']:.1f} % and {rms['expected']:.2f} mm)."
        )
    if "noise" in result:
        noise = result["noise"]
        ssim, rms = (list(noise["percentiles"][name].values()) for name in ("ssim_eq4", "rms_mm"))
        planned = noise["without_noise"]
        told.append(
            f"With errors of the process: SSIM {100 * ssim[0]:.1f} to {100 * ssim[-1]:.1f} %, RMS {rms[0]:.2f} to "
            f"{rms[-1]:.2f} mm (10 to 90 % of {noise['count']} noisy films on a mesh of {noise['mesh_mm']:g} mm, where "
            f"the one without noise gives {100 * planned['ssim_eq4']:.1f} % and {planned['rms_mm']:.2f} mm)."
        )
    return told


def _problem(problem: dict[str, str]) -> str:
    return f"{problem['where']}: {problem['message']}."
