import ast
from pathlib import Path

from rig.devices import Extruder, HotAir, HotPlate, PostLoad, Stage, UvLamp

ROOT = Path(__file__).resolve().parents[2]
ALLOWED = ("planner.program", "planner.errors", "rig")


class Lamp:
    def turn_on(self) -> None: ...

    def turn_off(self) -> None: ...


def test_a_device_is_what_has_its_verbs() -> None:
    assert isinstance(Lamp(), UvLamp)
    assert not isinstance(Lamp(), HotAir)


def test_what_acts_can_be_stopped() -> None:
    for device in (Stage, PostLoad, Extruder):
        assert hasattr(device, "stop")
    for device in (UvLamp, HotAir, HotPlate):
        assert hasattr(device, "turn_off")


def test_the_rig_knows_programs_and_nothing_else_of_the_project() -> None:
    own = ("planner", "twin", "scenes", "rig")
    for path in (ROOT / "rig").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            elif isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            else:
                continue
            ours = [name for name in names if name.split(".")[0] in own]
            assert all(name.startswith(ALLOWED) for name in ours), f"{path.name} imports {ours}"
