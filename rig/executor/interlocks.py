"""What must hold before something dangerous or spoiling is begun."""

from planner.errors import RigError
from planner.program import Machine
from rig.executor.machine import Devices
from rig.machine_sections import Interlocks

CLOSE_MM = 0.01


class Guard:
    """Checks the interlocks of a rig on its devices.

    Args:
        devices: what is checked.
        interlocks: which of them are wanted.
        machine: whose clearance counts.
        tolerance_g: how far a load may be from the one wanted.
        watched: whether a switch tells if the enclosure is closed.
    """

    def __init__(
        self, devices: Devices, interlocks: Interlocks, machine: Machine, *, tolerance_g: float, watched: bool
    ) -> None:
        self._devices = devices
        self._interlocks = interlocks
        self._lift_mm = machine.stage.lift_mm
        self._tolerance_g = tolerance_g
        self._watched = watched

    def before_uv(self) -> None:
        """Refuse UV light in an open enclosure.

        Raises:
            RigError: if it is open.
        """
        if self._interlocks.uv_needs_closed_enclosure and not self._devices.enclosure.is_closed():
            raise RigError("The enclosure is open and UV light would get out: close it, then resume.")

    def during_uv(self) -> None:
        """Refuse to shine on after the enclosure was opened.

        A switch tells; a person who watches the enclosure was asked before and is not asked each second.

        Raises:
            RigError: if it was opened.
        """
        if self._watched:
            self.before_uv()

    def before_hot_air(self) -> None:
        """Refuse hot air on a lowered post.

        Raises:
            RigError: if the post is not lifted.
        """
        if self._interlocks.hot_air_needs_lifted_post:
            self._lifted("hot air would heat it and blow the ink about")

    def before_load_change(self) -> None:
        """Refuse to change the load of a post on the film.

        Raises:
            RigError: if the post is not lifted.
        """
        if self._interlocks.load_change_needs_lifted_post:
            self._lifted("a change of its load would press into the film")

    def before_pass(self, load_g: float) -> None:
        """Refuse to begin a pass before its load has settled.

        Raises:
            RigError: if the pump counted another load.
        """
        found_g = self._devices.load.load_g()
        if abs(found_g - load_g) > self._tolerance_g:
            raise RigError(
                f"The load is {found_g:.3f} g by the pump's counters and the pass needs {load_g:.3f} g (allowed is a "
                f"difference of {self._tolerance_g:g} g): find out what moved the pump, then resume."
            )

    def _lifted(self, why: str) -> None:
        height_mm = self._devices.stage.position_mm()[2]
        if height_mm < self._lift_mm - CLOSE_MM:
            raise RigError(
                f"The post is {height_mm:.3f} mm above the film, needed are {self._lift_mm:g} mm, since {why}: lift it."
            )
