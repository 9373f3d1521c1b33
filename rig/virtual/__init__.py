"""Virtual devices: controllers that speak the wire protocols of real ones, with their kinematics and their faults."""

from rig.virtual.device import VirtualDevice

__all__ = ["VirtualDevice"]
