"""How fast `lce --help` and every subcommand's help answer: `python -m benchmarks.startup`."""

import statistics
import subprocess
import sys
import time

COMMANDS = ("", "demo", "scenes", "plan", "predict", "run", "score", "doctor", "schema")
ALLOWED_S = 0.5


def help_times_s(command: str, *, repeats: int = 7) -> list[float]:
    """Return the wall times of `lce COMMAND --help`, each in a fresh process [s], ascending."""
    arguments = [sys.executable, "-m", "scenes.cli", *command.split(), "--help"]
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        subprocess.run(arguments, check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - started)
    return sorted(times)


def main() -> None:
    """Print a table of medians, fastest and slowest, beside the time allowed."""
    print(f"{'command':<20} {'median s':>9} {'min s':>7} {'max s':>7}   allowed {ALLOWED_S:g} s")
    for command in COMMANDS:
        times = help_times_s(command)
        shown = " ".join(("lce", command, "--help")).replace("  ", " ")
        print(f"{shown:<20} {statistics.median(times):>9.3f} {times[0]:>7.3f} {times[-1]:>7.3f}")


if __name__ == "__main__":
    main()
