"""The layered shell: energy, gradient and Hessian of a film's vertices, in Warp kernels."""

from twin.shell.loads import Loads
from twin.shell.rest import RestState, rest_state
from twin.shell.shell import Shell

__all__ = ["Loads", "RestState", "Shell", "rest_state"]
