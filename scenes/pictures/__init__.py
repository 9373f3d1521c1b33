"""Pictures: one file a picture, drawn without a display; everything into PNG files, units on every axis."""

from scenes.pictures.calibration import draw_calibration
from scenes.pictures.depth_images import draw_depth_images
from scenes.pictures.design import CurrentPicture, draw_design
from scenes.pictures.error_map import draw_error_map
from scenes.pictures.heating_film import heating_frames
from scenes.pictures.heating_strip import draw_heating_strip
from scenes.pictures.hot_shape import draw_hot_shape
from scenes.pictures.noise import draw_noise
from scenes.pictures.plan import draw_plan
from scenes.pictures.search import draw_search
from scenes.pictures.side_by_side import draw_side_by_side
from scenes.pictures.target import draw_target

__all__ = [
    "CurrentPicture",
    "draw_calibration",
    "draw_depth_images",
    "draw_design",
    "draw_error_map",
    "draw_heating_strip",
    "draw_hot_shape",
    "draw_noise",
    "draw_plan",
    "draw_search",
    "draw_side_by_side",
    "draw_target",
    "heating_frames",
]
