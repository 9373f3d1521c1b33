"""Transports: how bytes reach a device, real or simulated.

`rig.transport.pty_server` is a program of its own: it serves a virtual device on a pseudo-terminal.
"""

from rig.transport.clock import PacedClock, VirtualClock, WallClock
from rig.transport.faulty import Fault, FaultyTransport
from rig.transport.serial_port import Framing, SerialTransport
from rig.transport.simulated import SimulatedTransport
from rig.transport.transport import Clock, Transport
from rig.transport.wire_log import LoggedTransport, read_wire_log

__all__ = [
    "Clock",
    "Fault",
    "FaultyTransport",
    "Framing",
    "LoggedTransport",
    "PacedClock",
    "SerialTransport",
    "SimulatedTransport",
    "Transport",
    "VirtualClock",
    "WallClock",
    "read_wire_log",
]
