"""Serve a virtual device on a pseudo-terminal in real time, so that hosts that open serial ports can talk to it.

    python -m rig.transport.pty_server grbl

prints the name of the terminal to open, and serves until it is interrupted.
"""

import argparse
import os
import select
import sys
import time
import tty
from contextlib import suppress

import numpy as np

from rig.dialects.grbl_settings import GrblSettings
from rig.dialects.marlin_settings import MarlinSettings
from rig.virtual.balance import VirtualBalance
from rig.virtual.device import VirtualDevice
from rig.virtual.grbl import VirtualGrbl
from rig.virtual.marlin import VirtualMarlin
from rig.virtual.namur import VirtualNamurPlate
from rig.virtual.new_era import VirtualPump

DEVICES = ("grbl", "marlin", "new-era", "namur", "sics")
LONGEST_WAIT_S = 0.5
PAN_G = 5.0
"""What lies on the pan of the balance [g]."""


def make_device(name: str) -> VirtualDevice:
    """Return a virtual device of a kind, one of `DEVICES`."""
    match name:
        case "marlin":
            return VirtualMarlin(
                MarlinSettings(
                    steps_per_mm=(80.0, 80.0, 400.0),
                    max_speed_mm_s=(20.0, 20.0, 5.0),
                    acceleration_mm_s2=(100.0, 100.0, 100.0),
                    travel_mm=(200.0, 200.0, 60.0),
                )
            )
        case "new-era":
            return VirtualPump()
        case "namur":
            return VirtualNamurPlate()
        case "sics":
            return VirtualBalance(lambda _: PAN_G, np.random.default_rng(0))
    settings = GrblSettings(
        steps_per_mm=(400.0, 400.0, 400.0),
        max_speed_mm_s=(20.0, 20.0, 5.0),
        acceleration_mm_s2=(100.0, 100.0, 100.0),
        travel_mm=(200.0, 200.0, 60.0),
    )
    return VirtualGrbl(settings)


def serve(device: VirtualDevice, master: int, *, speed: float = 1.0) -> None:
    """Pass bytes between a device and the master end of a terminal, its time `speed` times as fast as the wall's.

    Returns when the terminal is closed. What nobody reads is dropped when the terminal is full, as on a real line.
    """
    os.set_blocking(master, False)
    start_s = time.monotonic()

    def now_s() -> float:
        return (time.monotonic() - start_s) * speed

    while True:
        if said := device.send(now_s()):
            with suppress(BlockingIOError):
                os.write(master, said)
        wait_s = (device.next_event_s(now_s()) - now_s()) / speed
        readable, _, _ = select.select([master], [], [], min(LONGEST_WAIT_S, max(0.0, wait_s)))
        if readable:
            try:
                device.receive(os.read(master, 4096), now_s())
            except OSError:
                return


def main() -> None:
    """Serve the device named on the command line."""
    parser = argparse.ArgumentParser(description="Serve a virtual device on a pseudo-terminal.")
    parser.add_argument("device", choices=DEVICES)
    parser.add_argument("--speed", type=float, default=1.0, help="how many times as fast as the wall's its time passes")
    chosen = parser.parse_args()
    master, terminal = os.openpty()  # kept open here, so that hosts may come and go
    tty.setraw(terminal)
    sys.stdout.write(os.ttyname(terminal) + "\n")
    sys.stdout.flush()
    with suppress(KeyboardInterrupt):
        serve(make_device(chosen.device), master, speed=chosen.speed)


if __name__ == "__main__":
    main()
