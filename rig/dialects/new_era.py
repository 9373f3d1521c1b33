"""New Era syringe pumps (NE-1000 family) on the wire: commands to bytes, bytes to replies.

Source: NE-1000 user manual, chapter 10 (RS-232). Two modes share one syntax inside. Basic: `0DIS` and a carriage
return is answered by STX, `00S` and data, ETX. Safe: both directions are packets of STX, length, data, CRC, ETX, the
CRC being CCITT with start 0.
"""

import re
from binascii import crc_hqx
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from planner.errors import InputError, RigError

STX: Final = 0x02
ETX: Final = 0x03
SAFE_FRAME: Final = 4
"""Bytes of a safe packet beside its data, without STX: length, two of CRC, ETX."""
LONGEST_REPLY: Final = 64
"""Bytes; the longest reply of the manual has 19 characters."""
SPEED_MM_MIN: Final = (0.0007, 51.005)
"""Slowest and fastest plunger of an NE-1000 [mm/min], by chapter 12.5 of its manual."""

_NUMBER = r"(?=[.\d]*\d)\d{0,4}\.?\d{0,3}"
_REPLY = re.compile(r"(\d\d)(?:([IWSPTUX])(?:\?(NA|OOR|COM|IGN|)|([^?]*))|A\?([RSTEO]))", re.ASCII)
_VOLUME = re.compile(rf"({_NUMBER})(UL|ML)", re.ASCII)
_DISPENSED = re.compile(rf"I({_NUMBER})W({_NUMBER})(UL|ML)", re.ASCII)
_ANSWERS: Final = {
    "": re.compile(""),
    "DIA": re.compile(_NUMBER, re.ASCII),
    "DIR": re.compile("INF|WDR"),
    "DIS": _DISPENSED,
    "FUN": re.compile(r"[A-Z]{3}[\d.]*", re.ASCII),
    "PHN": re.compile(r"\d{1,2}", re.ASCII),
    "RAT": re.compile(rf"{_NUMBER}[UM][MH]", re.ASCII),
    "SAF": re.compile(r"\d{1,3}", re.ASCII),
    "VER": re.compile(r"NE\d+(X\d?)?V\d+\.\d+", re.ASCII),
    "VOL": _VOLUME,
}
"""What a query is answered by; whatever sets or acts is answered by nothing."""
_ML_PER_UNIT: Final = {"UL": 1e-3, "ML": 1.0}


class Status(StrEnum):
    """What the pump is doing."""

    INFUSING = "I"
    WITHDRAWING = "W"
    STOPPED = "S"
    PAUSED = "P"
    TIMED_PAUSE = "T"
    WAITING = "U"
    PURGING = "X"


class Alarm(StrEnum):
    """Why the pump stopped by itself."""

    RESET = "R"
    STALL = "S"
    TIME_OUT = "T"
    PROGRAM_ERROR = "E"
    PHASE_OUT_OF_RANGE = "O"


class PumpError(StrEnum):
    """Why the pump did not do what a command asked for."""

    UNKNOWN = ""
    NOT_NOW = "NA"
    OUT_OF_RANGE = "OOR"
    BAD_PACKET = "COM"
    IGNORED = "IGN"


@dataclass(frozen=True, kw_only=True)
class Reply:
    """One packet from the pump. With an alarm it says nothing else, and the command was not executed."""

    address: int
    status: Status | None = None
    alarm: Alarm | None = None
    error: PumpError | None = None
    data: str = ""

    def answers(self, command: str) -> bool:
        """Return whether this is what a command is answered by, judged from its form."""
        return self.error is None and self.alarm is None and bool(_answer(command).fullmatch(self.data))


@dataclass(frozen=True, kw_only=True)
class Dispensed:
    """The pump's two volume counters, as it rounds them."""

    infused_ml: float
    withdrawn_ml: float
    resolution_ml: float
    """Step of the coarser of the two numbers."""

    @property
    def net_ml(self) -> float:
        """Volume pushed out of the syringe less the volume drawn back [mL]."""
        return self.infused_ml - self.withdrawn_ml


def number(value: float) -> str:
    """Write a number by the pump's rule: at most four digits, three of them after the point.

    Raises:
        InputError: if it cannot be written so.
    """
    for decimals in (3, 2, 1, 0):
        text = f"{value:.{decimals}f}"
        if 0 <= value < 1e4 and sum(map(str.isdigit, text)) <= 4:
            return text
    raise InputError(f"pump: the number {value:g} cannot be sent, allowed is 0 to 9999; choose another value")


def volume_argument(volume_ml: float, units: str) -> str:
    """Write a volume to be dispensed [mL] in the pump's units, `UL` or `ML`.

    Raises:
        InputError: if it cannot be written, or would be written as 0, by which the pump means without end.
    """
    text = number(volume_ml / _ML_PER_UNIT[units])
    if float(text) == 0:
        raise InputError(f"pump: a dose of {volume_ml:g} mL is below its resolution; leave the dose out")
    return text


def volume_ml(data: str) -> float:
    """Read the answer to `VOL`, as `1.500ML` [mL]."""
    return _matched(_VOLUME, data)[0]


def volume_units(data: str) -> str:
    """Read the units in the answer to `VOL`: `UL` up to a syringe of 14.00 mm, else `ML`, unless set otherwise."""
    return data[-2:]


def dispensed(data: str) -> Dispensed:
    """Read the answer to `DIS`, as `I0.340W0.000ML`."""
    infused, withdrawn, resolution = _matched(_DISPENSED, data)
    return Dispensed(infused_ml=infused, withdrawn_ml=withdrawn, resolution_ml=resolution)


def encode(command: str, *, address: int, safe: bool) -> bytes:
    """Return a command as it goes over the wire, in basic or in safe mode.

    Raises:
        InputError: if the address or a character cannot be sent.
    """
    if not 0 <= address <= 99:
        raise InputError(f"pump: address is {address}, allowed is 0 to 99; correct it")
    if not re.fullmatch(r"\*?[A-Z0-9.]{0,40}", command, re.ASCII):
        raise InputError(f"pump: the command {command!r} cannot be sent, allowed are A-Z, 0-9 and '.'; correct it")
    data = f"{address}{command}".encode("ascii")
    return packet(data) if safe else data + b"\r"


def packet(data: bytes) -> bytes:
    """Wrap data into a packet of the safe mode."""
    return bytes([STX, len(data) + SAFE_FRAME, *data, *crc_hqx(data, 0).to_bytes(2, "big"), ETX])


class ReplyParser:
    """Bytes from the pump to replies. Never raises; keeps at most one unfinished packet."""

    def __init__(self, *, safe: bool) -> None:
        self.safe = safe
        self.discarded = 0
        """Bytes so far that belonged to no reply."""
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[Reply]:
        """Take bytes and return the replies that they complete."""
        replies: list[Reply] = []
        take = self._take_safe if self.safe else self._take_basic
        # In pieces, so that the memory stays bounded however much arrives at once.
        for start in range(0, len(data), LONGEST_REPLY):
            self._buffer += data[start : start + LONGEST_REPLY]
            while (text := take()) is not None:
                if reply := _reply(text):
                    replies.append(reply)
                else:
                    self.discarded += len(text)
        return replies

    def forget(self) -> None:
        """Drop an unfinished packet, after the line was silent."""
        self._drop(len(self._buffer))

    def _take_basic(self) -> bytes | None:
        """Cut the next STX ... ETX out of the buffer; a new STX within starts over."""
        end = self._buffer.find(ETX)
        start = self._buffer.rfind(STX, 0, end if end >= 0 else None)
        if end < 0:
            self._drop(start if start >= 0 and len(self._buffer) - start <= LONGEST_REPLY else len(self._buffer))
            return None
        if start < 0 or end - start > LONGEST_REPLY:
            self._drop(end + 1)
            return b""
        self._drop(start)
        text = bytes(self._buffer[1 : end - start])
        del self._buffer[: end - start + 1]
        return text

    def _take_safe(self) -> bytes | None:
        """Cut the next packet with a right CRC out of the buffer; what only looks like a start is skipped."""
        while True:
            start = self._buffer.find(STX)
            self._drop(start if start >= 0 else len(self._buffer))
            if len(self._buffer) < 2:
                return None
            length = self._buffer[1]
            if not SAFE_FRAME <= length <= LONGEST_REPLY:
                self._drop(1)
                continue
            if len(self._buffer) <= length:
                return None
            data, check, end = self._buffer[2 : length - 2], self._buffer[length - 2 : length], self._buffer[length]
            if end == ETX and crc_hqx(data, 0) == int.from_bytes(check, "big"):
                del self._buffer[: length + 1]
                return bytes(data)
            self._drop(1)

    def _drop(self, count: int) -> None:
        self.discarded += count
        del self._buffer[:count]


def _reply(text: bytes) -> Reply | None:
    match = _REPLY.fullmatch(text.decode("latin-1"))
    if match is None:
        return None
    address, status, error, data, alarm = match.groups()
    return Reply(
        address=int(address),
        status=None if status is None else Status(status),
        alarm=None if alarm is None else Alarm(alarm),
        error=None if error is None else PumpError(error),
        data=data or "",
    )


def _answer(command: str) -> re.Pattern[str]:
    return _ANSWERS.get(command, _ANSWERS[""])


def _matched(pattern: re.Pattern[str], data: str) -> tuple[float, ...]:
    """Return the numbers of an answer [mL] and, last, the step of the coarsest [mL]."""
    match = pattern.fullmatch(data)
    if match is None:
        raise RigError(f"pump: {data!r} is not a volume, expected is one as 'I0.340W0.000ML'; check the pump's model")
    *numbers, units = match.groups()
    scale = _ML_PER_UNIT[units]
    decimals = min(len(text.partition(".")[2]) for text in numbers)
    return (*(float(text) * scale for text in numbers), scale * 10.0**-decimals)
