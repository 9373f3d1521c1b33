"""List the benchmarks, or run one by name: `python -m benchmarks [NAME [its options]]`."""

import ast
import runpy
import sys
from pathlib import Path


def benchmarks() -> dict[str, str]:
    """Return the first line of the docstring of each module with a `main`, by name, without importing them."""
    found = {}
    for path in sorted(Path(__file__).parent.glob("[!_]*.py")):
        module = ast.parse(path.read_text(encoding="utf-8"))
        if any(isinstance(part, ast.FunctionDef) and part.name == "main" for part in module.body):
            found[path.stem] = (ast.get_docstring(module) or "").partition("\n")[0]
    return found


def main() -> None:
    known = benchmarks()
    if len(sys.argv) < 2:
        for name, line in known.items():
            print(f"{name:<10} {line}")
        print("\nRun one by `python -m benchmarks NAME`; `python -m benchmarks NAME --help` lists its options.")
        return
    name = sys.argv[1]
    if name not in known:
        sys.exit(f"benchmarks: there is no {name}; allowed are {', '.join(known)}.")
    sys.argv[:2] = [f"benchmarks.{name}"]
    runpy.run_module(f"benchmarks.{name}", run_name="__main__")


if __name__ == "__main__":
    main()
