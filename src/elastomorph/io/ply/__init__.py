"""Stanford PLY: vertices and polygons, as ASCII or binary of either byte order.

Only positions and polygons are read and written, and colours of vertices and images read where they
are asked for. Normals and whatever else a file holds are passed over; groups have no place in PLY.
"""

from elastomorph.io.ply.colours import read_ply_colours
from elastomorph.io.ply.looks import with_ply_looks
from elastomorph.io.ply.mesh import read_ply, write_ply

__all__ = ["read_ply", "read_ply_colours", "with_ply_looks", "write_ply"]
