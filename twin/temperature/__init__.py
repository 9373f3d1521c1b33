"""How warm each part of the film is: all as the plate, less where lifted off it, or as measured."""

from twin.temperature.field import ROOM_C, TemperatureField, TemperatureUniform, field_activation
from twin.temperature.field_shell import FieldNewton, FieldShell, plate_share, plate_temperature_c
from twin.temperature.file import TemperatureFile, load_temperature_file
from twin.temperature.gap_model import TemperatureGapModel, gap_temperature_c
from twin.temperature.settle import settle_activation

__all__ = [
    "ROOM_C",
    "FieldNewton",
    "FieldShell",
    "TemperatureField",
    "TemperatureFile",
    "TemperatureGapModel",
    "TemperatureUniform",
    "field_activation",
    "gap_temperature_c",
    "load_temperature_file",
    "plate_share",
    "plate_temperature_c",
    "settle_activation",
]
