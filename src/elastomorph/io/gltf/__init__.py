"""glTF 2.0: rigs as morph targets with weight animations that every viewer plays.

Δ and the bends of each morph are ordinary morph targets. What glTF has no place for, such as the
polygons before they were cut into triangles and the bend curves, is kept in ``extras.elastomorph``
of the mesh, which other software passes over.
"""

from __future__ import annotations

from elastomorph.io.gltf.reader import read_glb
from elastomorph.io.gltf.writer import GlbReport, Performance, write_glb

__all__ = ["GlbReport", "Performance", "read_glb", "write_glb"]
