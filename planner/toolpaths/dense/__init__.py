"""Dense toolpaths: lines of one width that tile what is to be scratched, along a smooth director field.

Lines of equal width cannot follow a field that diverges without ending, and each end costs a little gap or overlap. So
the lines are the ridges of a pattern that weighs spacing against direction and places the ends itself: stripes of a
Swift-Hohenberg energy with an alignment term (`stripes`), grown from noise by Fourier steps, 1.5 s for a layer of
60 x 45 mm. Directors modulo pi, half-integer singularities and borders need no special care.

Coverage, overlap (shares of the wanted area), median and 95th percentile of the deviation on a film of 60 x 45 mm:

    field                                    dense                      evenly spaced streamlines
    smooth random, 9 mm, with islands        98 %, 1.4 %, 2 and 12 deg  83 to 89 %, 2 to 9 %, 0 and 1 deg
    radial                                   98 %, 2.1 %, 2 and 13 deg  87 to 91 %, 3 to 14 %, 0 and 0 deg
    constant, azimuthal, +1/2, -1/2          98 to 99 %, below 1.1 %, below 2 and 9 deg

Streamlines (Jobard, Lefer 1997) keep the direction exactly and pay with the spacing; dense lines give a few degrees.
Radial lines one width apart cannot all reach the centre: one ends for every 0.13 mm of radius, closer than their ends
tile, and within about 3 mm of the centre gaps stay. Where directors jump, as those of maximum curvature do, 96 % of a
face is covered. The least turning radius is about 0.4 mm, in the core of a spiral; 0.8 mm and more elsewhere.
"""

from planner.toolpaths.dense.cloud_field import CLOUD_LEAST, CloudField, cloud_field
from planner.toolpaths.dense.director_field import DirectorField, Reading
from planner.toolpaths.dense.lines import LEAST, dense_lines
from planner.toolpaths.dense.mesh_field import MeshField
from planner.toolpaths.dense.tiling import Tiling, tiling
from planner.toolpaths.dense.trace_dense import trace_dense

__all__ = [
    "CLOUD_LEAST",
    "LEAST",
    "CloudField",
    "DirectorField",
    "MeshField",
    "Reading",
    "Tiling",
    "cloud_field",
    "dense_lines",
    "tiling",
    "trace_dense",
]
