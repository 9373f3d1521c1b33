"""Inject every fault at every stage and write the page: python -m benchmarks.reliability [--docs docs] [--every N]."""

import argparse
import logging
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.reliability.faults import FAULTS
from benchmarks.reliability.page import Row, reliability_page
from benchmarks.reliability.scene import Ended, Scene
from benchmarks.reliability.small_run import small_program, small_rig
from rig.executor.operations import list_operations


def run_one(name: str, stage: int) -> Ended:
    """Run with one fault at one operation."""
    with tempfile.TemporaryDirectory() as folder:
        return Scene(Path(folder) / "run", FAULTS[name], stage).run()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the page")
    parser.add_argument("--every", type=int, default=1, help="inject at every so-many-th operation only")
    options = parser.parse_args()
    logging.disable(logging.WARNING)
    operations = list_operations(small_program(), small_rig().machine)
    rows, started = [], time.perf_counter()
    for place, name in enumerate(FAULTS):
        stages = range(place % options.every, len(operations), options.every)
        rows.append(Row(name=name, ends=tuple(run_one(name, stage) for stage in stages)))
        bad = [end for end in rows[-1].ends if end.wrong or end.twice or end.missing or end.hung or not end.finished]
        for end in bad:
            print(f"{name}: {end}", file=sys.stderr)
    options.docs.mkdir(parents=True, exist_ok=True)
    page = reliability_page(rows, operations)
    (options.docs / "reliability.md").write_text(page, encoding="utf-8")
    runs = sum(len(row.ends) for row in rows)
    print(f"{runs} runs in {time.perf_counter() - started:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
