"""Whether the driver keeps a 128-byte controller fed in real time over a terminal: `python -m benchmarks.streaming`."""

import argparse
import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import tty
from contextlib import suppress
from itertools import pairwise
from math import cos, sin
from pathlib import Path
from typing import Any

from benchmarks.machine import describe_machine
from planner.program import Pass, load_machine
from rig.grbl_stage import GrblStage
from rig.transport import LoggedTransport, SerialTransport
from rig.transport.pty_server import make_device, serve
from rig.virtual.grbl import VirtualGrbl

RADIUS_MM = 30.0
OPERATIONS = 3
"""Lifting, moving over the first point, scratching: after each the planner is empty, and should be nowhere else."""


def circle(length_mm: float, segment_mm: float, speed_mm_s: float) -> Pass:
    """Return a stroke along a circle in short segments."""
    count = round(length_mm / segment_mm)
    angles = [k * segment_mm / RADIUS_MM for k in range(count + 1)]
    points = tuple((RADIUS_MM * cos(angle), RADIUS_MM * sin(angle)) for angle in angles)
    return Pass(points_mm=points, speed_mm_s=(speed_mm_s,) * count, load_g=(1,), side="convex")


def spin() -> None:
    """Keep a core busy."""
    while True:
        sum(range(10_000))


def serve_and_tell() -> None:
    """Serve a controller on a terminal until told to end, then print its planner's log."""

    def end(*_: object) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, end)
    device = make_device("grbl")
    assert isinstance(device, VirtualGrbl)
    master, terminal = os.openpty()
    tty.setraw(terminal)
    print(os.ttyname(terminal), flush=True)
    with suppress(KeyboardInterrupt):
        serve(device, master)
    print(
        json.dumps({"dry_s": device.motion.dry_s, "lost_bytes": device.lost_bytes, "moves": len(device.motion.trace)})
    )


def measure(stroke: Pass, folder: Path) -> dict[str, float]:
    """Scratch a stroke in real time, and return what the controller's planner and the wire log say."""
    command = [sys.executable, "-m", "benchmarks.streaming", "--serve"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        port = server.stdout.readline().strip()
        model = make_device("grbl")
        assert isinstance(model, VirtualGrbl)
        log = folder / "wire.jsonl"
        stage = GrblStage(
            LoggedTransport(SerialTransport(port, 115200), log),
            limits=load_machine().stage,
            controller=model.settings,
            origin_mm=(-100.0, -100.0, -25.0),
        )
        stage.home()
        for move in (stage.lift, lambda: stage.move_to(*stroke.points_mm[0])):
            move()
            stage.wait_idle(60)
        started = time.perf_counter()
        stage.scratch(stroke)
        stage.wait_idle(3600)
        took_s = time.perf_counter() - started
        stage.close()
        server.terminate()
        planner = json.loads(server.stdout.read())
    return {
        "planned_s": stroke.scratch_s,
        "took_s": took_s,
        "starved": len(planner["dry_s"]) - OPERATIONS,
        "lost_bytes": planner["lost_bytes"],
        "most_in_flight_bytes": stage.most_in_flight_bytes,
        "fewest_queued": fewest_queued(log),
        "longest_gap_s": longest_gap_s(log),
    }


def stroke_entries(log: Path) -> list[dict[str, Any]]:
    """Return what was said from the lowering of the post on."""
    entries = [json.loads(line) for line in log.read_text().splitlines()]
    lowered = next(i for i, entry in enumerate(entries) if entry["way"] == "out" and entry["bytes"].startswith("G1Z0"))
    return entries[lowered:]


def fewest_queued(log: Path) -> int:
    """Return the smallest number of queued moves in a report between the filling and the emptying of the queue."""
    heard = "".join(entry["bytes"] for entry in stroke_entries(log) if entry["way"] == "in")
    queued = [15 - int(free) for free in re.findall(r"<Run\|[^>]*\|Bf:(\d+),", heard)]
    return min(queued[5:-5])


def longest_gap_s(log: Path) -> float:
    """Return the longest time between two words of the host while it streamed [s]."""
    said_s = [entry["t_s"] for entry in stroke_entries(log) if entry["way"] == "out"]
    return max(b - a for a, b in pairwise(said_s))


def main() -> None:
    """Print a table: alone, and beside processes that keep the cores busy."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--serve", action="store_true", help="be the controller (used by the benchmark itself)")
    parser.add_argument("--seconds", type=float, default=60.0, help="how long to scratch")
    parser.add_argument("--speed-mm-s", type=float, default=2.0)
    parser.add_argument("--segment-mm", type=float, default=0.1)
    parser.add_argument("--busy", type=int, nargs="*", default=[0, 2, 4], help="processes beside it, a row each")
    chosen = parser.parse_args()
    if chosen.serve:
        serve_and_tell()
        return
    print("\n".join(f"- {line}" for line in describe_machine()), flush=True)
    columns = ("busy processes", "planned s", "took s", "starved", "fewest moves queued of 15", "most bytes in flight")
    print(f"\n| {' | '.join(columns)} | longest silence s |")
    print("|---:|---:|---:|---:|---:|---:|---:|", flush=True)
    stroke = circle(chosen.seconds * chosen.speed_mm_s, chosen.segment_mm, chosen.speed_mm_s)
    for count in chosen.busy:
        spinners = [multiprocessing.Process(target=spin, daemon=True) for _ in range(count)]
        for spinner in spinners:
            spinner.start()
        with tempfile.TemporaryDirectory() as folder:
            found = measure(stroke, Path(folder))
        for spinner in spinners:
            spinner.terminate()
            spinner.join()
        print(
            f"| {count} | {found['planned_s']:.1f} | {found['took_s']:.2f} | {found['starved']:.0f} |"
            f" {found['fewest_queued']:.0f} | {found['most_in_flight_bytes']:.0f} | {found['longest_gap_s']:.3f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
