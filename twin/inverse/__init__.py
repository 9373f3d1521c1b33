"""Inverse design: from a target to the Program whose film becomes it, through the differentiable twin."""

from twin.inverse.design import FINER, InverseDesign, design_inverse
from twin.inverse.limits import STRONGER
from twin.inverse.noise_costs import TOGETHER, noise_costs
from twin.inverse.options import InverseOptions
from twin.inverse.search import Moment
from twin.inverse.stages import Field

__all__ = [
    "FINER",
    "STRONGER",
    "TOGETHER",
    "Field",
    "InverseDesign",
    "InverseOptions",
    "Moment",
    "design_inverse",
    "noise_costs",
]
