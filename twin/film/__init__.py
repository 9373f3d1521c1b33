"""The flat film: mesh, layers, and how passes become directors and contractions."""
