"""Plans and predictions in the formats of other programs: drawings in true mm, meshes, images, tables."""

from scenes.exports.export import export_into

__all__ = ["export_into"]
