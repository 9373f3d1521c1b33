"""The errors that a user of the project can meet; a leaf that every room may import."""

from collections.abc import Sequence


class LceError(Exception):
    """Base of all errors raised on purpose; `exit_code` is what the command line returns."""

    exit_code = 1


class InputError(LceError):
    """The user's input is wrong.

    Each problem is one clear sentence: what is wrong, where (file, field, line), the value found,
    what is allowed, and the next step. All problems of an input are collected and raised at once.
    """

    exit_code = 2

    def __init__(self, problems: str | Sequence[str]) -> None:
        self.problems: tuple[str, ...] = (problems,) if isinstance(problems, str) else tuple(problems)
        super().__init__("\n".join(self.problems))


class RigError(LceError):
    """A device of the rig failed or answered something that it must not."""

    exit_code = 3


class SolverError(LceError):
    """The equilibrium solver could not reach its tolerance; the message says where it stopped."""
