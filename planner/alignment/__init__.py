"""Alignment fields: what each layer should be taught, before it is traced into passes."""

from planner.alignment.field import AlignmentField, bending_field

__all__ = ["AlignmentField", "bending_field"]
