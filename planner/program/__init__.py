"""The contract between planner, twin and rig: the Program, its operations, and the checks on it.

A leaf: it knows the error types and nothing else of the project, and needs no numeric library.
"""

from planner.program.calibration_record import (
    CalibrationLimits,
    CalibrationRecord,
    CalibrationStrip,
    SaturatingModel,
    TableModel,
)
from planner.program.files import PROGRAM_FILE, load_program, program_schema, save_program
from planner.program.operations import Actuate, Cure, Cut, Deposit, Pass, Point, ResetAlignment, Scratch
from planner.program.problems import program_problems
from planner.program.program import CreatedBy, Film, Inputs, Layer, Program
from planner.program.sentences import validation_sentences

__all__ = [
    "PROGRAM_FILE",
    "Actuate",
    "CalibrationLimits",
    "CalibrationRecord",
    "CalibrationStrip",
    "CreatedBy",
    "Cure",
    "Cut",
    "Deposit",
    "Film",
    "Inputs",
    "Layer",
    "Pass",
    "Point",
    "Program",
    "ResetAlignment",
    "SaturatingModel",
    "Scratch",
    "TableModel",
    "load_program",
    "program_problems",
    "program_schema",
    "save_program",
    "validation_sentences",
]
