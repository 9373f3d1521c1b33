"""The serial ports of this machine."""

from serial.tools.list_ports import comports


def serial_ports() -> tuple[tuple[str, str], ...]:
    """Return (name, description) of each serial port that the system knows, by name."""
    return tuple(sorted((port.device, port.description or "no description") for port in comports()))
