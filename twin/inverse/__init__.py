"""Inverse design: from a target to the Program whose film becomes it, through the differentiable twin."""

from twin.inverse.design import InverseDesign, design_inverse
from twin.inverse.options import InverseOptions
from twin.inverse.search import Moment
from twin.inverse.stages import Field

__all__ = ["Field", "InverseDesign", "InverseOptions", "Moment", "design_inverse"]
