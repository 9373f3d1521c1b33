"""The contract between planner, twin and rig: the Program, its operations, and the checks on it.

A leaf: it knows the error types and nothing else of the project, and needs no numeric library.
"""

from planner.program.calibration_record import (
    CalibrationLimits,
    CalibrationRecord,
    CalibrationStrip,
    CalibrationUncertainty,
    SaturatingModel,
    TableModel,
)
from planner.program.check import Problem, check
from planner.program.files import PROGRAM_FILE, load_program, program_schema, save_program
from planner.program.machine import Machine, load_machine
from planner.program.operations import Actuate, Cure, Cut, Deposit, Pass, Point, ResetAlignment, Scratch
from planner.program.problems import program_problems
from planner.program.program import CreatedBy, Film, Inputs, Layer, Program
from planner.program.segments import Segment, describe_split, split_layer
from planner.program.sentences import validation_sentences
from planner.program.timing import LayerTime, layer_figures, layer_times, pass_s, scratch_time
from planner.program.toml_file import read_toml

__all__ = [
    "PROGRAM_FILE",
    "Actuate",
    "CalibrationLimits",
    "CalibrationRecord",
    "CalibrationStrip",
    "CalibrationUncertainty",
    "CreatedBy",
    "Cure",
    "Cut",
    "Deposit",
    "Film",
    "Inputs",
    "Layer",
    "LayerTime",
    "Machine",
    "Pass",
    "Point",
    "Problem",
    "Program",
    "ResetAlignment",
    "SaturatingModel",
    "Scratch",
    "Segment",
    "TableModel",
    "check",
    "describe_split",
    "layer_figures",
    "layer_times",
    "load_machine",
    "load_program",
    "pass_s",
    "program_problems",
    "program_schema",
    "read_toml",
    "save_program",
    "scratch_time",
    "split_layer",
    "validation_sentences",
]
