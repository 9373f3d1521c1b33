"""Lines to devices, good and bad."""

import json
from pathlib import Path

import pytest

from planner.errors import RigError
from rig.transport import (
    Fault,
    FaultyTransport,
    LoggedTransport,
    SerialTransport,
    SimulatedTransport,
    VirtualClock,
    read_wire_log,
)


class Echo:
    """Answers every byte a second later."""

    def __init__(self) -> None:
        self.heard: list[tuple[float, bytes]] = []

    def receive(self, data: bytes, now_s: float) -> None:
        self.heard.append((now_s + 1.0, data))

    def send(self, now_s: float) -> bytes:
        ripe = [data for due, data in self.heard if due <= now_s]
        self.heard = [(due, data) for due, data in self.heard if due > now_s]
        return b"".join(ripe)

    def next_event_s(self, now_s: float) -> float:
        return min((due for due, _ in self.heard), default=float("inf"))


def test_waiting_moves_the_clock_to_the_next_event_and_no_further() -> None:
    clock = VirtualClock()
    line, other = SimulatedTransport(Echo(), clock), SimulatedTransport(Echo(), clock)
    line.write(b"a")
    assert line.read(0.4) == b""
    assert clock.now_s() == 0.4
    other.write(b"b")
    assert line.read(10.0) == b"a"
    assert clock.now_s() == 1.0
    assert other.read(10.0) == b"b"
    assert clock.now_s() == 1.4
    line.close()
    with pytest.raises(RigError, match="closed"):
        line.write(b"a")


def through(*faults: Fault, data: bytes = b"abc\ndef\n") -> bytes:
    """What a device hears, and answers as it is, of bytes sent in two pieces."""
    line, heard = FaultyTransport(SimulatedTransport(Echo(), VirtualClock()), faults), b""
    line.write(data[:5])
    line.write(data[5:])
    while part := line.read(5.0):
        heard += part
    return heard


@pytest.mark.parametrize("way", ["out", "in"])
def test_faults_happen_at_their_byte(way) -> None:
    assert through() == b"abc\ndef\n"
    assert through(Fault(kind="drop", way=way, at=1)) == b"ac\ndef\n"
    assert through(Fault(kind="flip", way=way, at=5, bit=0)) == b"abc\nddf\n"
    assert through(Fault(kind="duplicate", way=way, at=0)) == b"aabc\ndef\n"
    assert through(Fault(kind="insert", way=way, at=5, inserted=b"xy")) == b"abc\ndxyef\n"
    assert through(Fault(kind="merge", way=way, at=1)) == b"abcdef\n"
    assert through(Fault(kind="merge", way=way, at=4)) == b"abc\ndef"
    assert through(Fault(kind="delay", way=way, at=2, delay_s=3.0)) == b"abc\ndef\n"
    assert through(Fault(kind="drop", way=way, at=1), Fault(kind="drop", way=way, at=2)) == b"a\ndef\n"
    with pytest.raises(RigError, match="unplugged"):
        through(Fault(kind="unplug", way=way, at=2))


def test_the_wire_log_has_every_byte_and_forgives_a_torn_line(tmp_path: Path) -> None:
    path, every = tmp_path / "wire.jsonl", bytes(range(256))
    line = LoggedTransport(SimulatedTransport(Echo(), VirtualClock()), path)
    line.write(every)
    assert line.read(5.0) == every
    line.close()
    entries = [json.loads(text) for text in path.read_text().splitlines()]
    assert [(entry["t_s"], entry["way"]) for entry in entries] == [(0.0, "out"), (1.0, "in")]
    path.write_text(path.read_text() + '{"t_s": 2.0, "wa')
    assert read_wire_log(path, "out") == read_wire_log(path, "in") == every


def test_a_log_that_cannot_be_written_is_told_and_a_full_disk_only_once(tmp_path: Path) -> None:
    inner = SimulatedTransport(Echo(), VirtualClock())
    with pytest.raises(RigError, match="cannot be written"):
        LoggedTransport(inner, tmp_path / "none" / "wire.jsonl")
    if not Path("/dev/full").exists():
        return
    line = LoggedTransport(inner, "/dev/full")
    with pytest.raises(RigError, match="free the disk"):
        line.write(b"a")
    line.write(b"b")
    assert inner.read(5.0) == b"ab"


def test_a_port_that_is_not_there_is_an_error_of_the_rig() -> None:
    with pytest.raises(RigError, match="cannot be opened"):
        SerialTransport("/dev/none-such-port", 115200)
