"""Score: the numbers that say how near a hot shape comes to its target."""

from twin.score.score import Score, Scored, score_surface
from twin.score.ssim import ssim_eq4, ssim_eq4_inside, ssim_eq4_map, ssim_eq4_own_scale, ssim_gauss

__all__ = [
    "Score",
    "Scored",
    "score_surface",
    "ssim_eq4",
    "ssim_eq4_inside",
    "ssim_eq4_map",
    "ssim_eq4_own_scale",
    "ssim_gauss",
]
