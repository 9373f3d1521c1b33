"""Parametric targets: pure functions of a few lengths, nothing read from files."""

from scenes.targets.dome import ellipsoid_dome, sphere_cap
from scenes.targets.face import face
from scenes.targets.ridge import ridge
from scenes.targets.saddle import saddle
from scenes.targets.strip import strip
from scenes.targets.two_bump import two_bump

__all__ = ["ellipsoid_dome", "face", "ridge", "saddle", "sphere_cap", "strip", "two_bump"]
