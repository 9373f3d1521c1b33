"""What is seen of a run on a terminal."""

from rich.console import Console

from benchmarks.reliability.small_run import small_program, small_rig
from rig.executor.operations import list_operations
from rig.executor.view import Moment
from scenes.live_view import drawn


def test_the_view_says_where_the_run_is() -> None:
    operations = list_operations(small_program(), small_rig().machine)
    moment = Moment(
        operation=operations[3],
        count=len(operations),
        at_s=120.0,
        position_mm=(1.0, -2.0, 0.0),
        load_g=2.001,
        temperature_c=None,
        left_s=300.0,
        pausing=True,
    )
    console = Console(width=100, color_system=None)
    with console.capture() as seen:
        console.print(drawn(moment))
    text = seen.get()
    for part in (
        "4 of 16: layer 1: pass 0",
        "x 1.00  y -2.00  z 0.00 mm",
        "2.001 g",
        "about 5 min left",
        "Pausing after this operation",
    ):
        assert part in text
