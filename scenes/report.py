"""The report of a prediction: one self-contained page that opens offline, the verdict first."""

import base64
from html import escape
from pathlib import Path
from typing import Any

PICTURES = (
    ("hot_shape.png", "The predicted hot shape"),
    ("temperatures.png", "The temperatures that the film was taken through, in their order, all in one scale"),
    ("shapes_by_seed.png", "The shapes that differently disturbed films take, the most frequent first, in one scale"),
    ("target.png", "The target"),
    ("depth_images.png", "Depth images, same scale, and where they agree"),
    ("error_map.png", "Distance from the target"),
    ("noise.png", "How the scores of films with errors of the process spread"),
    ("plan.png", "What is scratched into the layers"),
)

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #1c2430; }
h1 { font-size: 1.5rem; margin-bottom: .2rem } h2 { font-size: 1.1rem; margin-top: 2rem }
.verdict { font-size: 2.6rem; font-weight: 600; margin: .4rem 0 0 } .paper { color: #5a6675; margin: 0 0 1rem }
.warning { background: #fff3d6; border-left: 4px solid #d99a00; padding: .5rem .8rem; margin: .4rem 0 }
figure { margin: 1.2rem 0 } img { max-width: 100%; height: auto } figcaption { color: #5a6675; font-size: .9rem }
table { border-collapse: collapse } td { padding: .15rem 1rem .15rem 0; vertical-align: top }
td + td { font-family: ui-monospace, monospace }
@media print { figure { break-inside: avoid } }
"""

SCORES = (
    ("ssim_eq4", "structural similarity, Eq. 4 of the paper, same scale", ".3f"),
    ("ssim_eq4_own_scale", "the same, each image in its own scale (hides height errors)", ".3f"),
    ("ssim_eq4_inside", "the same, windows wholly inside both outlines", ".3f"),
    ("ssim_gauss", "structural similarity, Gaussian windows with constants", ".3f"),
    ("rms_mm", "root mean square distance [mm]", ".2f"),
    ("rms_percent_of_diagonal", "the same in percent of the diagonal", ".2f"),
    ("hausdorff_mm", "largest distance [mm]", ".2f"),
    ("depth_mm", "depth of the shape [mm]", ".1f"),
    ("target_depth_mm", "depth of the target [mm]", ".1f"),
)


def write_report(folder: Path, result: dict[str, Any]) -> None:
    """Write report.html into `folder` from the content of result.json and the pictures that lie there."""
    parts = [f"<h1>{escape(result['name'])}: predicted at {result['temperature_c']:g} C</h1>"]
    if "ssim_eq4" in result:
        parts.append(
            f"<p class=verdict>SSIM {100 * result['ssim_eq4']:.1f} % &middot; RMS {result['rms_mm']:.2f} mm</p>"
        )
        parts += _band(result)
        parts.append(
            f"<p class=paper>The paper's best printed face reached {100 * result['paper_ssim']:.1f} % by the same "
            "equation. This is a simulation; its score is comparable only as far as the calibration is.</p>"
        )
    else:
        parts.append("<p class=verdict>No target: the shape was not scored</p>")
    parts += [f"<p class=warning>{escape(text)}</p>" for text in result["warnings"]]
    parts += [_figure(folder / name, caption) for name, caption in PICTURES if (folder / name).is_file()]
    parts.append("<h2>Scores</h2>")
    parts.append(_table((label, format(result[key], form)) for key, label, form in SCORES if key in result))
    parts.append("<h2>How it was calculated</h2>")
    parts.append(_table(_facts(result)))
    page = f"<!doctype html><html lang=en><meta charset=utf-8><title>{escape(result['name'])}</title>"
    page += (
        f"<meta name=viewport content='width=device-width'><style>{STYLE}</style><body>{''.join(parts)}</body></html>"
    )
    (folder / "report.html").write_text(page, encoding="utf-8")


def _facts(result: dict[str, Any]) -> list[tuple[str, str]]:
    return [
        ("method", str(result["method"])),
        ("calibration", _calibration(result["calibration"], result["calibration_provenance"])),
        *_settings(result["settings"], result["temperature_field"]),
        ("largest contraction", f"{result['largest_contraction']:.1%}"),
        *_heating(result),
        *_noise(result),
        ("time, device, seed", f"{result['wall_s']:.0f} s on {result['device']}, seed {result['seed']}"),
        ("Program", result["program_digest"]),
        ("target", f"{result['target_name']}, {result['target_digest']}"),
        ("lce-twin", result["version"]),
    ]


def _band(result: dict[str, Any]) -> list[str]:
    """Say how far the score is open because the calibration is not known better."""
    if "score_band" not in result:
        return []
    band = result["score_band"]
    ssim, rms = band["ssim_eq4"], band["rms_mm"]
    low, _, high = band["percent"]
    return [
        f"<p class=paper>As well as calibration '{escape(band['calibration'])}' is known: SSIM "
        f"{100 * ssim['low']:.1f} to {100 * ssim['high']:.1f} %, RMS {rms['low']:.2f} to {rms['high']:.2f} mm "
        f"({low} to {high} % of {band['draws']} films with maps that its strips leave possible, on a mesh of "
        f"{band['mesh_mm']:g} mm, where the calibration itself gives {100 * ssim['expected']:.1f} % and "
        f"{rms['expected']:.2f} mm).</p>"
    ]


def _calibration(calibration: dict[str, Any], provenance: dict[str, str]) -> str:
    if calibration["placeholder"]:
        return f"{calibration['name']}, not measured"
    known = [provenance[key] for key in ("samples", "band", "date", "operator") if key in provenance]
    return "; ".join([f"{calibration['name']}, measured", *known])


def _settings(settings: dict[str, Any], field: str) -> list[tuple[str, str]]:
    """Every physical setting."""
    material, film = settings["material"], settings["film"]
    planned = "as planned"
    fading = f"tau {film['fading_tau_h']:g} h" if film["fading_tau_h"] else "none"
    width = f"{film['line_width_mm']:g} mm" if film["line_width_mm"] else planned
    return [
        ("support", "hot plate, own weight" if settings["support"] == "plate" else "weightless, free"),
        ("temperature field", field),
        ("tap", f"{settings['ramp']['tap_mm']:g} mm"),
        ("modulus, density", f"{material['modulus_mpa']:g} MPa, {material['density_kg_m3']:g} kg/m3"),
        ("nematic-isotropic temperature", f"{material['transition_c']:g} C"),
        ("layer thicknesses", f"{_numbers(film['layer_thickness_mm'])} mm" if film["layer_thickness_mm"] else planned),
        ("modulus of each layer", f"times {_numbers(film['modulus_ratio'] or (1.0,))}"),
        ("line width, edge blur, end length", f"{width}, {film['edge_blur_mm']:g} mm, {film['end_length_mm']:g} mm"),
        ("profile in a layer, fading", f"{film['profile']}, {fading}"),
        ("machine", film["machine"] or "the paper's"),
    ]


def _heating(result: dict[str, Any]) -> list[tuple[str, str]]:
    """How the shape was found, and each temperature that was asked for if there are several."""
    equilibrium, stops = result["equilibrium"], result["stops"]
    rows = [
        ("mesh", f"{result['settings']['film']['mesh_mm']:g} mm, {result['triangle_count']} triangles"),
        (
            "heating",
            f"{len(result['accepted_temperatures_c'])} temperatures, {result['newton_iterations']} Newton steps",
        ),
        ("relative residual", f"{equilibrium['relative_residual']:.1e}, {_stable(equilibrium)}"),
    ]
    rows += [
        (f"snapped at {snap['temperature_c']:.0f} C", f"by {snap['distance_mm']:.1f} mm")
        for snap in equilibrium["snaps"]
    ]
    rows += [
        (
            f"taken by {family['share']:.0%} of the seeds",
            f"{_numbers(family['seeds'])}: {family['depth_mm']:.1f} mm deep",
        )
        for family in result.get("shapes_by_seed", ())
    ]
    if len(stops) > 1:
        rows += [(f"{stop['temperature_c']:g} C", f"{stop['depth_mm']:.1f} mm deep, {_stable(stop)}") for stop in stops]
    if result["cooled_back_to_flat_mm"] is not None:
        rows.append(("cooled, from flat", f"{result['cooled_back_to_flat_mm']:.4f} mm"))
    return rows


def _noise(result: dict[str, Any]) -> list[tuple[str, str]]:
    """How the scores of noisy films spread, where they were asked for."""
    if "noise" not in result:
        return []
    noise = result["noise"]
    ssim, rms = (noise["percentiles"][name] for name in ("ssim_eq4", "rms_mm"))
    planned = noise["without_noise"]
    return [
        (
            f"{noise['count']} noisy films, 10, 50, 90 %",
            f"SSIM {', '.join(f'{value:.3f}' for value in ssim.values())}; "
            f"RMS {', '.join(f'{value:.2f}' for value in rms.values())} mm",
        ),
        (
            f"without noise on their mesh of {noise['mesh_mm']:g} mm",
            f"SSIM {planned['ssim_eq4']:.3f}; RMS {planned['rms_mm']:.2f} mm",
        ),
    ]


def _stable(found: dict[str, Any]) -> str:
    return "stable" if found["stable"] else "not stable"


def _numbers(values: Any) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _table(rows: Any) -> str:
    cells = "".join(f"<tr><td>{escape(left)}</td><td>{escape(right)}</td></tr>" for left, right in rows)
    return f"<table>{cells}</table>"


def _figure(path: Path, caption: str) -> str:
    image = base64.b64encode(path.read_bytes()).decode("ascii")
    return (
        f"<figure><img alt='{escape(caption)}' src='data:image/png;base64,{image}'>"
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )
