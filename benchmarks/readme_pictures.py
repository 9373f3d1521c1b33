"""Make the README's pictures of the built-in face anew, in docs/pictures: its paper's plan and its inverse design.

python -m benchmarks.readme_pictures [--out out/readme]

Four minutes on two cores, nearly all of it the inverse design.
"""

import argparse
from pathlib import Path

from PIL import Image

from scenes.case import load_case
from scenes.filming import film_into
from scenes.inverse_planning import plan_inverse_into
from scenes.planning import plan_into
from scenes.prediction import predict_into
from twin.predict import PredictOptions

PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
LARGEST_PX = (1400, 1000)
SHOWN = {
    "face-plan.png": "paper/plan/plan.png",
    "face-hot.png": "paper/hot/hot_shape.png",
    "face-depth.png": "paper/hot/depth_images.png",
    "face-inverse-plan.png": "inverse/plan/plan.png",
    "face-inverse.png": "inverse/plan/design.png",
    "face-inverse-search.png": "inverse/plan/progress.png",
    "face-heating.png": "inverse/heating.png",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/readme"))
    out = parser.parse_args().out
    case = load_case("face")
    target = case.make_target()
    programs = {
        "paper": plan_into(out / "paper" / "plan", target, **case.plan.model_dump()).program,
        "inverse": plan_inverse_into(out / "inverse" / "plan", target).program,
    }
    for name, program in programs.items():
        made = predict_into(out / name / "hot", program, target, PredictOptions())
        print(f"{name}: SSIM {made.result['ssim_eq4']:.3f}, RMS {made.result['rms_mm']:.2f} mm")
        film_into(out / name / "heating.png", out / name / "hot")
    for picture, made_at in SHOWN.items():
        save_small(out / made_at, PICTURES / picture)


def save_small(picture: Path, to: Path) -> None:
    """Save a picture no larger than a page shows it: half of the bytes for every clone."""
    with Image.open(picture) as opened:
        image = opened.convert("RGB")
    image.thumbnail(LARGEST_PX, Image.Resampling.LANCZOS)
    image.save(to, optimize=True)


if __name__ == "__main__":
    main()
