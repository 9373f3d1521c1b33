"""What a Grbl controller says, as events: bytes in, events out, for any bytes whatever."""

import re
from dataclasses import dataclass

from rig.dialects.grbl_settings import Axes

LINE_BYTES = 256
"""Longest line that is understood; Grbl's own are shorter."""


@dataclass(frozen=True, kw_only=True)
class Ok:
    """A line was parsed and queued; it is not executed yet."""


@dataclass(frozen=True, kw_only=True)
class Error:
    """A line was refused."""

    number: int


@dataclass(frozen=True, kw_only=True)
class Alarm:
    """The controller stopped by itself and wants a reset or homing."""

    number: int


@dataclass(frozen=True, kw_only=True)
class Status:
    """Answer to `?`."""

    state: str
    """`Idle`, `Run`, `Hold`, `Jog`, `Home`, `Alarm`, `Door`, `Check` or `Sleep`."""
    substate: int | None = None
    """Of `Hold` and `Door`: 0 when standing."""
    machine_mm: Axes | None = None
    work_mm: Axes | None = None
    free_moves: int | None = None
    free_bytes: int | None = None
    feed_mm_min: float | None = None


@dataclass(frozen=True, kw_only=True)
class Message:
    """Something in brackets: `[MSG:Reset to continue]` has name `MSG` and that text."""

    name: str
    text: str


@dataclass(frozen=True, kw_only=True)
class Setting:
    """One line of `$$`."""

    number: int
    value: float


@dataclass(frozen=True, kw_only=True)
class Banner:
    """The controller has started anew; what it was told before is void."""

    text: str


@dataclass(frozen=True, kw_only=True)
class Unknown:
    """Anything else, cut at `LINE_BYTES`."""

    text: str


Event = Ok | Error | Alarm | Status | Message | Setting | Banner | Unknown

# a bound on the digits keeps numbers finite and cheap whatever arrives
_NUMBER = r"-?\d{1,9}(?:\.\d{0,9})?"
_AXES = re.compile(rf"({_NUMBER}),({_NUMBER}),({_NUMBER})(?:,{_NUMBER})*")
_CODE = re.compile(r"(error|ALARM):(\d{1,3})")
_SETTING = re.compile(rf"\$(\d{{1,4}})=({_NUMBER})(?: \(.*\))?")
_MESSAGE = re.compile(r"\[([A-Za-z0-9]+):(.*)\]")
_STATE = re.compile(r"(Idle|Run|Hold|Jog|Home|Alarm|Door|Check|Sleep)(?::(\d{1,3}))?")
_BANNER = re.compile(r"(?:Grbl|GrblHAL) \d\.\d.*")
_BUFFERS = re.compile(r"(\d{1,6}),(\d{1,6})")


class GrblParser:
    """Turns bytes into events, in bounded memory; lines that are not understood are `Unknown`, nothing raises."""

    def __init__(self) -> None:
        self._line = bytearray()

    def feed(self, data: bytes) -> list[Event]:
        """Take bytes and return the events that they complete."""
        *ended, rest = data.replace(b"\r", b"\n").split(b"\n")
        events: list[Event] = []
        for part in ended:
            self._keep(part)
            if self._line:
                events.append(parse_line(self._line.decode("latin-1")))
                self._line.clear()
        self._keep(rest)
        return events

    def clear(self) -> None:
        """Forget the line that has begun."""
        self._line.clear()

    def _keep(self, part: bytes) -> None:
        self._line += part[: LINE_BYTES + 1 - len(self._line)]


def parse_line(text: str) -> Event:
    """Understand one line without its end."""
    if len(text) > LINE_BYTES or not text.isascii():
        return Unknown(text=text[:LINE_BYTES])
    if text == "ok":
        return Ok()
    if text[0] == "<":
        return _status(text) or Unknown(text=text)
    if match := _CODE.fullmatch(text):
        number = int(match[2])
        return Error(number=number) if match[1] == "error" else Alarm(number=number)
    if match := _MESSAGE.fullmatch(text):
        return Message(name=match[1], text=match[2])
    if match := _SETTING.fullmatch(text):
        return Setting(number=int(match[1]), value=float(match[2]))
    if _BANNER.fullmatch(text):
        return Banner(text=text)
    return Unknown(text=text)


def parse_axes(text: str) -> Axes | None:
    """Return the first three of numbers with commas between them, if that is what the text is."""
    match = _AXES.fullmatch(text)
    return (float(match[1]), float(match[2]), float(match[3])) if match else None


def _status(text: str) -> Status | None:
    """Understand a report, all or nothing: a field that is spoiled must not pass for one that is missing."""
    if text[-1] != ">":
        return None
    first, *fields = text[1:-1].split("|")
    state = _STATE.fullmatch(first)
    values = {name: value for name, _, value in (field.partition(":") for field in fields)}
    machine, work = (parse_axes(values[name]) if name in values else None for name in ("MPos", "WPos"))
    buffers = _BUFFERS.fullmatch(values.get("Bf", "0,0"))
    feed = re.fullmatch(rf"({_NUMBER})(?:,.*)?", values.get("FS", values.get("F", "0")))
    if state is None or (machine is None) == (work is None) or buffers is None or feed is None:
        return None
    return Status(
        state=state[1],
        substate=int(state[2]) if state[2] else None,
        machine_mm=machine,
        work_mm=work,
        free_moves=int(buffers[1]) if "Bf" in values else None,
        free_bytes=int(buffers[2]) if "Bf" in values else None,
        feed_mm_min=float(feed[1]) if {"F", "FS"} & set(values) else None,
    )
