"""The balance beside the film: what the post presses with, weighed now and then and compared with what was pumped."""

from rig.devices import Balance, PostLoad, Stage, Watch
from rig.machine_sections import BalanceLine

NEVER_S = 86_400.0
"""For waits that end by a limit of their own [s]."""


class Scale:
    """Weighs the load of the lifted post by setting it down on a balance.

    Args:
        stage: carries the post there.
        load: knows what was pumped.
        balance: weighs.
        place: where it stands, and how far the two may differ.
    """

    def __init__(self, stage: Stage, load: PostLoad, balance: Balance, place: BalanceLine) -> None:
        self._stage = stage
        self._load = load
        self._balance = balance
        self._place = place

    def weigh(self, show: Watch) -> float:
        """Return the weight of the load [g], with the post lifted before and after; `show` where it goes.

        Raises:
            LoadUnknownError: if the pump counted another load.
            RigError: if stage, pump or balance fail.
        """
        self._stage.lift()
        self._stage.move_to(*self._place.at_mm)
        self._stage.wait_idle(NEVER_S, show)
        self._balance.zero()
        self._stage.lower(self._place.pan_mm)
        self._stage.wait_idle(NEVER_S, show)
        weighed_g, counted_g = self._balance.load_g(), self._load.load_g()
        self._stage.lift()
        self._stage.wait_idle(NEVER_S, show)
        if abs(weighed_g - counted_g) > self._place.tolerance_g:
            raise self._load.doubt(
                f"the balance shows {weighed_g:.2f} g where {counted_g:.2f} g were counted (allowed is a difference of "
                f"{self._place.tolerance_g:g} g), by air or a leak in the tubes or friction of the post's guide"
            )
        return weighed_g
