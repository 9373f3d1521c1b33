"""Run all checks and write the page with its pictures: python -m benchmarks.validation [--docs docs] [--only NAME]."""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.validation import (
    balance,
    bilayers,
    cantilever,
    cones,
    director_curvature,
    face,
    paper,
    plate,
    small_strain,
    strips,
)
from benchmarks.validation.page import write_page
from benchmarks.validation.section import Section

RUNS: dict[str, Callable[[Path], Section]] = {
    module.__name__.rpartition(".")[2]: module.run
    for module in (
        strips,
        small_strain,
        cones,
        director_curvature,
        cantilever,
        balance,
        plate,
        face,
        bilayers,
        paper,
    )
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the page and its pictures")
    parser.add_argument("--only", choices=RUNS, help="run one part and print it; the page is not written")
    options = parser.parse_args()
    sections = []
    for name in [options.only] if options.only else RUNS:
        started = time.perf_counter()
        print(f"validation: {name} ...", file=sys.stderr, end=" ", flush=True)
        section = RUNS[name](options.docs)
        failed = sum(check.passed is False for check in section.checks)
        print(f"{time.perf_counter() - started:.0f} s, {failed} of {len(section.checks)} fail", file=sys.stderr)
        sections.append(section)
    page = write_page(sections)
    if options.only:
        print(page)
    else:
        options.docs.mkdir(parents=True, exist_ok=True)
        (options.docs / "validation.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
