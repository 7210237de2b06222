"""The colours of scans, whatever their format: images on materials, or colours of vertices."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.atomic import is_file
from elastomorph.model.mesh import Mesh


def dressed(mesh: Mesh) -> Mesh:
    """A mesh with what its materials look like, as the file says that it was read from.

    Where nothing is said there, or where it has looks already, it is returned as it is.

    Raises:
        FileError: The file cannot be read.
        FormatError: It is damaged.
    """
    if mesh.appearance or mesh.source is None:
        return mesh
    if Path(mesh.source.path).suffix.lower() == ".ply":
        from elastomorph.io.ply import with_ply_looks

        return with_ply_looks(mesh)
    from elastomorph.io.mtl import with_looks

    return with_looks(mesh)


def vertex_colours(mesh: Mesh) -> NDArray[np.uint8] | None:
    """The colours of the vertices of a mesh in the file that it was read from.

    Returns:
        (V, 3) uint8, red first, as screens show them; None where the file has none, is there no
        longer, or has other vertices by now.

    Raises:
        FileError: The file cannot be read.
        FormatError: It is damaged.
    """
    if mesh.source is None or not is_file(mesh.source.path):
        return None
    path = Path(mesh.source.path)
    found = None
    if path.suffix.lower() == ".ply" and len(mesh.faces):
        from elastomorph.io.ply import read_ply_colours

        found = read_ply_colours(path)
    elif path.suffix.lower() == ".obj":
        from elastomorph.io.obj import read_obj_colours

        found = read_obj_colours(path)
    elif path.suffix.lower() in (".glb", ".gltf"):
        from elastomorph.io.gltf.primitives import read_gltf_colours

        found = read_gltf_colours(path)
    return found if found is not None and len(found) == len(mesh.vertices) else None
