"""Target surface -> curvature -> flattening -> alignment fields -> toolpaths -> Program.

Rooms: `target`, `curvature`, `flattening`, `calibration`, `toolpaths`, `program`; `plan` joins them.
Import from the room: `from planner.target import load_target`.
"""
