"""Program -> machine: the stage and the devices around it, simulated or over serial ports."""

from rig.devices import Balance, Enclosure, Extruder, HotAir, HotPlate, PostLoad, Stage, UvLamp, WarmsUp

__all__ = ["Balance", "Enclosure", "Extruder", "HotAir", "HotPlate", "PostLoad", "Stage", "UvLamp", "WarmsUp"]
