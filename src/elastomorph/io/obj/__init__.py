"""Wavefront OBJ: meshes of polygons as text, the file most scans and face rigs come in.

Vertices keep their order and polygons their corners, whatever texture coordinates, normals,
groups or materials say. What is not kept: a vertex's weight and colour (columns 4 to 7 of ``v``;
colours are read where they are asked for), normals (``vn``; they go stale as soon as a vertex
moves), smoothing groups, points, lines, curves and surfaces.
"""

from elastomorph.io.obj.colours import read_obj_colours
from elastomorph.io.obj.reader import read_obj
from elastomorph.io.obj.writer import write_obj

__all__ = ["read_obj", "read_obj_colours", "write_obj"]
