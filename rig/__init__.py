"""Program -> machine: the stage and the devices around it, simulated or over serial ports."""

from rig.devices import Extruder, HotAir, HotPlate, PostLoad, Stage, UvLamp

__all__ = ["Extruder", "HotAir", "HotPlate", "PostLoad", "Stage", "UvLamp"]
