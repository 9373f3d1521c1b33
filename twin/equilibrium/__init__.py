"""Equilibria: sparse direct solves, Newton's method, and the ramp of temperatures from the flat film."""

from twin.equilibrium.linear import sparse_solver
from twin.equilibrium.newton import Equilibrium, Newton, NewtonOptions
from twin.equilibrium.pins import rigid_pins
from twin.equilibrium.ramp import HeatedState, RampOptions, heat
from twin.equilibrium.rigid import moved_onto, rigid_distance_mm

__all__ = [
    "Equilibrium",
    "HeatedState",
    "Newton",
    "NewtonOptions",
    "RampOptions",
    "heat",
    "moved_onto",
    "rigid_distance_mm",
    "rigid_pins",
    "sparse_solver",
]
