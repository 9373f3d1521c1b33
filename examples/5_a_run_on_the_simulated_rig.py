"""
A run on the simulated rig
==========================

The Program of a plan is what the machine runs. Without a machine it runs on a simulated one,
whose virtual controllers speak the wire protocols of real ones: a Grbl stage, a New Era pump, and
what lies around them, on a clock that needs not be waited for. With the command line::

    lce run out/plan --out out/run
"""

import shutil
from collections import Counter
from pathlib import Path

from planner.plan import plan
from planner.program.as_run import AS_RUN_FILE, AsRunOperation
from planner.program.as_run_film import load_as_run, read_as_run
from rig.executor.operations import list_operations
from rig.executor.session import preflight, run_session
from rig.machine_file import load_rig
from scenes.case import load_case
from scenes.pictures import draw_plan

out = Path("out/run_on_the_simulated_rig")
shutil.rmtree(out, ignore_errors=True)  # a finished run is never run again in its folder
out.mkdir(parents=True)

# %%
# A small dome, planned as usual, and the rig. ``load_rig()`` without a path is the simulated one;
# your own is a file like ``rig/machines/simulated.toml`` with the ports in it.

program = plan(load_case("prolate_dome").make_target(), seed=0).program
rig = load_rig()

# %%
# Before anything is opened the Program is held against the machine, and turned into a list of
# operations. Each goes from a lifted post to a lifted post, and counts as done only when it was
# seen to be done.

for problem in preflight(program, rig):
    print(f"{problem.severity}: {problem.where}: {problem.message}")
operations = list_operations(program, rig.machine)
print(dict(Counter(operation.kind for operation in operations)))

# %%
# Run it. Journal, as-run log and every byte on the wires go into the folder; after a crash, a
# stop or a lost port the same call with ``resume=True`` goes on.

ran = run_session(program, rig, out / "run")
print(f"{ran.run_s / 60:.0f} minutes of the machine")
for path in sorted((out / "run").iterdir()):
    print(path.name)

# %%
# What was really done is in the as-run log, in the Program's own words: positions as seen, loads
# as the pump counted them, speeds as measured.

records = read_as_run(out / "run" / AS_RUN_FILE)
done = [record for record in records if isinstance(record, AsRunOperation)]
assert len(done) == len(operations)
first = next(record for record in done if record.kind == "pass")
print(first.model_dump_json(exclude={"stroke"}, exclude_none=True, indent=1))

# %%
# Drawn like a plan: the passes as they were scratched.

draw_plan(out / "as_run.png", load_as_run(out / "run" / AS_RUN_FILE).program)
