"""The target room: surfaces from files and formulas, as height fields with a smooth outline."""

from planner.target.heights import target_from_heights
from planner.target.surface import Surface
from planner.target.target import Target

__all__ = ["Surface", "Target", "target_from_heights"]
