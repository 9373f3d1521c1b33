"""The tables: every score, how the shape was calculated, of what, and where it comes from."""

from collections.abc import Sequence
from typing import Any

from scenes.costs_in_words import costs_in_words

Rows = list[tuple[str, str]]

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


def score_rows(result: dict[str, Any]) -> Rows:
    """Every number of the score, and how it spreads where that was asked for."""
    rows = [(label, format(result[key], form)) for key, label, form in SCORES if key in result]
    if "noise" in result:
        noise = result["noise"]
        ssim, rms = (noise["percentiles"][name].values() for name in ("ssim_eq4", "rms_mm"))
        planned = noise["without_noise"]
        rows += [
            (
                f"{noise['count']} noisy films, 10, 50, 90 %",
                f"SSIM {', '.join(f'{value:.3f}' for value in ssim)}; "
                f"RMS {', '.join(f'{value:.2f}' for value in rms)} mm",
            ),
            (
                f"without noise on their mesh of {noise['mesh_mm']:g} mm",
                f"SSIM {planned['ssim_eq4']:.3f}; RMS {planned['rms_mm']:.2f} mm",
            ),
        ]
        if noise["expected_cost"] is not None:
            rows.append(("errors of the process", costs_in_words(noise["expected_cost"])))
    return rows


def material_rows(result: dict[str, Any]) -> Rows:
    """What the film is taken to be made of, and what a pass leaves behind."""
    settings = result["settings"]
    material, film, planned = settings["material"], settings["film"], "as planned"
    fading = f"tau {film['fading_tau_h']:g} h" if film["fading_tau_h"] else "none"
    width = f"{film['line_width_mm']:g} mm" if film["line_width_mm"] else planned
    return [
        ("modulus, density", f"{material['modulus_mpa']:g} MPa, {material['density_kg_m3']:g} kg/m3"),
        ("nematic-isotropic temperature", f"{material['transition_c']:g} °C"),
        ("layer thicknesses", f"{_numbers(film['layer_thickness_mm'])} mm" if film["layer_thickness_mm"] else planned),
        ("modulus of each layer", f"times {_numbers(film['modulus_ratio'] or (1.0,))}"),
        ("line width, edge blur, end length", f"{width}, {film['edge_blur_mm']:g} mm, {film['end_length_mm']:g} mm"),
        ("profile in a layer, fading", f"{film['profile']}, {fading}"),
        ("machine", result["machine"]["name"]),
        ("largest contraction", f"{100 * result['largest_contraction']:.1f} %"),
        ("calibration", _calibration(result["calibration"], result["calibration_provenance"])),
    ]


def solver_rows(result: dict[str, Any]) -> Rows:
    """How the shape was found."""
    settings, equilibrium = result["settings"], result["equilibrium"]
    rows = [
        ("support", "hot plate, own weight" if settings["support"] == "plate" else "weightless, free"),
        ("temperature field", result["temperature_field"]),
        ("tap", f"{settings['ramp']['tap_mm']:g} mm"),
        ("mesh", f"{settings['film']['mesh_mm']:g} mm, {result['triangle_count']} triangles"),
        (
            "heating",
            f"{len(result['accepted_temperatures_c'])} temperatures, {result['newton_iterations']} Newton steps",
        ),
        ("relative residual", f"{equilibrium['relative_residual']:.1e}, {_stable(equilibrium)}"),
        ("seen by", "a phone's depth camera, simulated" if result["scanner_noise"] else "a perfect scanner"),
        ("time, device, seed", f"{result['wall_s']:.0f} s on {result['device']}, seed {result['seed']}"),
    ]
    return rows + _state_rows(result)


def origin_rows(result: dict[str, Any]) -> Rows:
    """What was predicted, by which program: the hashes tell whether two reports speak of the same."""
    target = "none" if result["target_digest"] is None else f"{result['target_name']}, {result['target_digest']}"
    return [
        ("method", result["method"]),
        ("Program", result["program_digest"]),
        ("target", target),
        ("lce-twin", result["version"]),
    ]


def clamped_rows(result: dict[str, Any]) -> Rows:
    """How much of the target bends in a way that the calibration does not reach."""
    clamped = result["clamped"]
    if clamped is None:
        return []
    tight, wide = 100 * clamped["tight_share"], 100 * clamped["wide_share"]
    return [
        ("tighter than the calibration reaches", f"{tight:.1f} % of the points (paper's face: 3 %)"),
        ("wider than it reaches", f"{wide:.1f} % of the points (paper's face: 41 %)"),
    ]


def _state_rows(result: dict[str, Any]) -> Rows:
    """Jumps, other shapes, and each temperature that was asked for if there are several."""
    equilibrium, stops = result["equilibrium"], result["stops"]
    rows = [
        (f"snapped at {snap['temperature_c']:.0f} °C", f"by {snap['distance_mm']:.1f} mm")
        for snap in equilibrium["snaps"]
    ]
    rows += [
        (
            f"taken by {100 * family['share']:.0f} % of the seeds",
            f"{_numbers(family['seeds'])}: {family['depth_mm']:.1f} mm deep",
        )
        for family in result.get("shapes_by_seed", ())
    ]
    if len(stops) > 1:
        rows += [
            (f"{stop['temperature_c']:g} °C", f"{stop['depth_mm']:.1f} mm deep, {_stable(stop)}") for stop in stops
        ]
    if result["cooled_back_to_flat_mm"] is not None:
        rows.append(("cooled, from flat", f"{result['cooled_back_to_flat_mm']:.4f} mm"))
    return rows


def _calibration(calibration: dict[str, Any], provenance: dict[str, str]) -> str:
    if calibration["placeholder"]:
        return f"{calibration['name']}, not measured"
    known = [provenance[key] for key in ("samples", "band", "date", "operator") if key in provenance]
    return "; ".join([f"{calibration['name']}, measured", *known])


def _stable(found: dict[str, Any]) -> str:
    return "stable" if found["stable"] else "not stable"


def _numbers(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
