"""Inverse design: from a target to the Program whose film becomes it, through the differentiable twin."""

from twin.inverse.design import InverseDesign, Moment, design_inverse
from twin.inverse.options import InverseOptions

__all__ = ["InverseDesign", "InverseOptions", "Moment", "design_inverse"]
