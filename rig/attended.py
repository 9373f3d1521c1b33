"""Devices that a person works: prompts in the place of wires."""

from collections.abc import Callable

from rig.devices import Operator
from rig.executor.interrupts import PausedError


class OperatorExtruder:
    """A layer of ink that is coated by hand or by a machine of its own."""

    def __init__(self, operator: Operator) -> None:
        self._operator = operator
        self._wanted_mm = 0.0

    @property
    def deposited_ml(self) -> float | None:
        """Nobody measured it."""
        return None

    def deposit(self, outline_mm: tuple[tuple[float, float], ...], thickness_mm: float) -> None:
        """Say what is to be covered [mm]."""
        xs, ys = zip(*outline_mm, strict=True)
        self._wanted_mm = thickness_mm
        self._operator.tell(
            f"Cover x {min(xs):.1f} to {max(xs):.1f} mm, y {min(ys):.1f} to {max(ys):.1f} mm with {thickness_mm:g} mm "
            "of ink."
        )

    def wait_deposited(self, deadline_s: float) -> None:
        """Wait for the operator's word.

        Raises:
            PausedError: if the layer does not lie.
        """
        _need(self._operator, f"Does the layer of {self._wanted_mm:g} mm lie?")

    def stop(self) -> None:
        """Say that no more ink must flow."""
        self._operator.tell("Stop the flow of ink.")


class OperatorLamp:
    """A lamp with a switch."""

    def __init__(self, operator: Operator) -> None:
        self._operator = operator

    def turn_on(self) -> None:
        """Let it be switched on.

        Raises:
            PausedError: if it was not.
        """
        _need(self._operator, "Switch the UV lamp on. Is it on?")

    def turn_off(self) -> None:
        """Say that it must be dark."""
        self._operator.tell("Switch the UV lamp off.")

    def wait_off(self) -> None:
        """Wait for the operator's word.

        Raises:
            PausedError: if it still shines.
        """
        _need(self._operator, "Is the UV lamp off?")


class OperatorHotAir:
    """A hot-air gun that is held or hung up by hand."""

    def __init__(self, operator: Operator) -> None:
        self._operator = operator
        self._wanted_c = 0.0

    def set_temperature(self, temperature_c: float) -> None:
        """Say how hot it has to be [C]."""
        self._wanted_c = temperature_c
        self._operator.tell(f"Switch the hot air on and set it to {temperature_c:g} C.")

    def wait_temperature(self, deadline_s: float, look: Callable[[float], None] | None = None) -> None:
        """Wait for the operator's word.

        Raises:
            PausedError: if it does not blow.
        """
        _need(self._operator, f"Does air of {self._wanted_c:g} C blow on the layer?")

    def temperature_c(self) -> float:
        """Return the temperature that the operator confirmed [C]."""
        return self._wanted_c

    def turn_off(self) -> None:
        """Say that it must be off."""
        self._operator.tell("Switch the hot air off.")

    def wait_off(self) -> None:
        """Wait for the operator's word.

        Raises:
            PausedError: if it still blows.
        """
        _need(self._operator, "Is the hot air off, and does it point away from the layer?")


class OperatorHotPlate:
    """A hot plate with knobs."""

    def __init__(self, operator: Operator) -> None:
        self._operator = operator
        self._wanted_c = 25.0

    def set_temperature(self, temperature_c: float) -> None:
        """Say how hot it has to be [C]."""
        self._wanted_c = temperature_c
        self._operator.tell(f"Lay the film on the hot plate and set it to {temperature_c:g} C.")

    def wait_temperature(self, deadline_s: float, look: Callable[[float], None] | None = None) -> None:
        """Wait for the operator's word.

        Raises:
            PausedError: if it is not hot.
        """
        _need(self._operator, f"Does the plate show {self._wanted_c:g} C?")

    def temperature_c(self) -> float:
        """Return the temperature that the operator confirmed [C]."""
        return self._wanted_c

    def turn_off(self) -> None:
        """Say that it must be off."""
        self._operator.tell("Switch the hot plate off.")

    def wait_off(self) -> None:
        """Wait for the operator's word.

        Raises:
            PausedError: if it still heats.
        """
        _need(self._operator, "Is the hot plate off?")


class OperatorEnclosure:
    """An enclosure without a switch."""

    def __init__(self, operator: Operator) -> None:
        self._operator = operator

    def is_closed(self) -> bool:
        """Return what the operator says."""
        return self._operator.confirm("Is the enclosure closed, and will it stay so until the lamp is off?")


def _need(operator: Operator, question: str) -> None:
    if not operator.confirm(question):
        raise PausedError(f"The operator did not say yes to: {question} Do so, then resume.")
