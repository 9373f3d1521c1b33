"""The faults: what each does to a run at the moment when it strikes."""

from collections.abc import Callable
from math import inf

from benchmarks.reliability.scene import Scene
from rig.transport import Fault

Arm = Callable[[Scene], None]


def _wire(line: str, **what) -> Arm:
    def arm(scene: Scene) -> None:
        scene.lines[line].arm(Fault(**what))  # pyright: ignore[reportArgumentType]

    return arm


def _answers(line: str, old: bytes, new: bytes) -> Arm:
    def arm(scene: Scene) -> None:
        scene.lines[line].change_in = lambda data: data.replace(old, new, 1)  # pyright: ignore[reportArgumentType]

    return arm


def _mishap(name: str) -> Arm:
    return lambda scene: scene.machine.grbl.schedule(name, scene.now_s + 1.5)  # pyright: ignore[reportArgumentType]


def _moving(*bytes_: bytes) -> Arm:
    """Somebody else says real-time commands to the controller while it moves, one at each sighting."""

    def arm(scene: Scene) -> None:
        scene.on_move += [lambda data=data: scene.machine.grbl.receive(data, scene.now_s) for data in bytes_]

    return arm


def _stop_and(repair: Arm, then: Arm | None = None) -> Arm:
    """Stop the run in the operation, change something, and put it right after one more failure."""

    def arm(scene: Scene) -> None:
        scene.interrupts.wanted = "stop"
        scene.repairs.append(lambda: repair(scene))
        if then is not None:
            scene.repairs.append(lambda: then(scene))

    return arm


def _set(path: str, value) -> Arm:
    def arm(scene: Scene) -> None:
        *parents, name = path.split(".")
        holder = scene
        for parent in parents:
            holder = getattr(holder, parent)
        setattr(holder, name, value)

    return arm


def _until_resumed(arm: Arm, repair: Arm) -> Arm:
    def both(scene: Scene) -> None:
        arm(scene)
        scene.repairs.append(lambda: repair(scene))

    return both


def _dose(name: str) -> Arm:
    def arm(scene: Scene) -> None:
        pump = scene.machine.pump
        setattr(pump, name, pump.plunger.travelled_ml + 0.1)

    return arm


def _interrupt(times: int) -> Arm:
    def arm(scene: Scene) -> None:
        if times == 1:
            scene.operator.refusals = 1
            scene.interrupts.pause()
        else:
            scene.on_move += [scene.interrupts.pause, scene.interrupts.pause]

    return arm


def _alarm_2(scene: Scene) -> None:
    """Raise the alarm of a soft limit at the next sighting: the position is kept, and the controller wants a reset."""
    scene.on_move.append(lambda: scene.machine.grbl.schedule("soft limit", scene.now_s))


def _truncated(line: str) -> Arm:
    def cut(data: bytes) -> bytes:
        return data[: len(data) // 2]

    def arm(scene: Scene) -> None:
        scene.lines[line].change_in = cut  # pyright: ignore[reportArgumentType]

    return arm


def _out_of_range(scene: Scene) -> None:
    """Let the pump run out of its program: it tells so by an alarm, and stops."""
    pump, at_ml = scene.machine.pump, scene.machine.pump.plunger.travelled_ml + 0.1
    pump.out_of_range_at_ml = at_ml


def _suspend(scene: Scene) -> None:
    scene.on_move.append(lambda: scene.machine.clock.sleep(4000.0))


def _killed_in_dose(scene: Scene) -> None:
    def look(data: bytes) -> bytes:
        if scene.machine.pump.plunger.running:
            scene.kill()
        return data

    scene.lines["pump"].change_in = look


def _date(by_s: float) -> Arm:
    def arm(scene: Scene) -> None:
        scene.later_s += by_s

    return arm


def _changed_setting(value: float) -> Arm:
    def arm(scene: Scene) -> None:
        scene.machine.grbl.numbers[100] = value

    return arm


BYTES = (0, 4, 9, 17, 30)
"""Which byte is hit, counted from the moment when the fault strikes."""
WIRE: dict[str, dict] = {
    "dropped byte": {"kind": "drop"},
    "flipped bit": {"kind": "flip", "bit": 2},
    "duplicated byte": {"kind": "duplicate"},
    "late by 1 s": {"kind": "delay", "delay_s": 1.0},
    "unplugged": {"kind": "unplug"},
}

FAULTS: dict[str, Arm] = {
    **{
        f"{line}: {name}, {'sent' if way == 'out' else 'received'}, byte {at}": _wire(line, way=way, at=at, **what)
        for line in ("stage", "pump")
        for name, what in WIRE.items()
        for way in ("out", "in")
        for at in BYTES
    },
    "stage: dropped digit further on": _wire("stage", kind="drop", way="out", at=14),
    "stage: line end dropped, two lines merged": _wire("stage", kind="merge", way="out", at=1),
    "stage: ok lost": _answers("stage", b"ok\r\n", b""),
    "stage: ok twice": _answers("stage", b"ok\r\n", b"ok\r\nok\r\n"),
    "stage: stray ok": _wire("stage", kind="insert", way="in", at=0, inserted=b"ok\r\n"),
    "stage: hard limit (alarm 1, with the swallowed reset)": _mishap("hard limit"),
    "stage: soft limit in motion (alarm 2)": _alarm_2,
    "stage: reply cut short": _truncated("stage"),
    "stage: reset in motion (alarm 3)": _moving(b"\x18"),
    "stage: brown-out": _mishap("brown-out"),
    "stage: feed hold, resumed": _moving(b"!", b"", b"", b"~"),
    "stage: feed hold in a stroke, resumed": _moving(*[b""] * 12, b"!", b"", b"", b"~"),
    "stage: feed hold in a stroke after a long way, resumed": _moving(*[b""] * 45, b"!", b"", b"", b"~"),
    "stage: feed hold, never resumed": _moving(b"!"),
    "stage: door opened": _moving(b"\x84"),
    "stage: homing fails on resume": _stop_and(
        _set("machine.grbl.homing_alarm", 9), _set("machine.grbl.homing_alarm", None)
    ),
    "stage: $$ settings changed": _stop_and(_changed_setting(80.0), _changed_setting(400.0)),
    "pump: stall in a dose": _dose("stall_at_ml"),
    "pump: power lost in a dose": _dose("brown_out_at_ml"),
    "pump: power lost": lambda scene: scene.machine.pump.brown_out(scene.now_s),
    "pump: phase out of range in a dose (alarm O)": _out_of_range,
    "pump: refuses as out of range (?OOR)": _set("machine.pump.refuses_next", "?OOR"),
    "pump: reply cut short": _truncated("pump"),
    "pump: reply to RUN lost": _set("machine.pump.lose_reply_to", "RUN"),
    "pump: reply to DIS lost": _set("machine.pump.lose_reply_to", "DIS"),
    "pump: address changed": _until_resumed(_set("machine.pump.address", 7), _set("machine.pump.address", 0)),
    "pump: uL for mL": _set("machine.pump.plunger.units", "UL"),
    "pump: silent for 40 s (watchdog)": _wire("pump", kind="delay", way="out", at=20, delay_s=40.0),
    "host: Ctrl-C once, operator says no": _interrupt(1),
    "host: Ctrl-C twice": _interrupt(2),
    "host: stop at once": _set("interrupts.wanted", "stop"),
    "host: killed as an operation begins": Scene.kill,
    "host: killed in motion": lambda scene: scene.on_move.append(scene.kill),
    "host: killed in motion, later": lambda scene: scene.on_move.extend([lambda: None] * 12 + [scene.kill]),
    "host: killed in a dose": _killed_in_dose,
    "host: suspended for 4000 s": _suspend,
    "host: disk full": _set("disk_full", True),
    "host: date set forward by a day, then stopped": lambda scene: _stop_and(_date(86_400.0))(scene),
    "host: date set back by a day, then stopped": lambda scene: _stop_and(_date(-86_400.0))(scene),
    "operator: says no": _set("operator.refusals", 1),
    "operator: says no three times": _set("operator.refusals", 3),
    "hot air: dead element": _until_resumed(
        _set("machine.hot_air.broken_at_s", 0.0), _set("machine.hot_air.broken_at_s", inf)
    ),
    "hot plate: dead element": _until_resumed(
        _set("machine.hot_plate.broken_at_s", 0.0), _set("machine.hot_plate.broken_at_s", inf)
    ),
    "hot plate: loose sensor": _until_resumed(
        _set("machine.hot_plate.sensor_loose_at_s", 0.0), _set("machine.hot_plate.sensor_loose_at_s", inf)
    ),
    "enclosure: opened": _until_resumed(
        _set("machine.enclosure.door_is_closed", False), _set("machine.enclosure.door_is_closed", True)
    ),
}
