"""Program -> film -> heating -> hot shape -> scan -> score.

Rooms: `film` (mesh and layers), `shell` (energy and its derivatives in Warp), `equilibrium` (Newton and
the temperature ramp), `scan` (depth images, registration), `score`; `predict` joins them.
"""
