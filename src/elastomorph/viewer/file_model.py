"""Models from files: a GLB as it is, with its clips, and what elastomorph stored in it."""

from __future__ import annotations

import warnings
from pathlib import Path

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import ElastomorphWarning, FormatError, ParameterError
from elastomorph.io.atomic import read_bytes
from elastomorph.io.gltf import read_glb
from elastomorph.io.gltf.container import GltfFile, open_gltf
from elastomorph.viewer.scene import Role, SceneModel

__all__ = ["file_curves", "file_model", "stands_as_it_is"]


def file_model(path: str | Path, name: str, role: Role) -> SceneModel:
    """A model that is a GLB file as it stands.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is no GLB file.
    """
    try:
        return SceneModel(name, role, read_bytes(path))
    except ParameterError:
        raise FormatError(
            path, "no GLB file, or a damaged one: expected glTF 2.0 in binary form with a mesh"
        ) from None


def file_curves(path: str | Path) -> CurveNetwork | None:
    """The curves on a GLB file of elastomorph; None for one of others.

    Files of other programs hold triangles, whose edges are no loops, and copies of vertices along
    seams, where curves would end.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is damaged.
    """
    return extract_curves(read_glb(path).neutral) if _is_ours(open_gltf(path)) else None


def stands_as_it_is(path: str | Path) -> bool:
    """Whether there is nothing to be bent in a GLB file, or its clips would be lost by that.

    The paths of a file of elastomorph are its own; a file without morph targets has none; and one
    of others with clips can play them only as it is, of which a warning says how to bend it.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is damaged.
    """
    file = open_gltf(path)
    meshes = [mesh for mesh in file.items("meshes") if isinstance(mesh, dict)]
    primitives = [p for mesh in meshes for p in file.list_in(mesh, "primitives", "a mesh")]
    moves = any(isinstance(each, dict) and each.get("targets") for each in primitives)
    if _is_ours(file) or not moves:
        return True
    if not file.items("animations"):
        return False
    warnings.warn(
        f"{path}: shown as it is, on straight paths, so that its clips can be played; "
        "--method auto bends the paths and leaves the clips out",
        ElastomorphWarning,
        stacklevel=2,
    )
    return True


def _is_ours(file: GltfFile) -> bool:
    extras = [mesh.get("extras") for mesh in file.items("meshes") if isinstance(mesh, dict)]
    return any(isinstance(each, dict) and "elastomorph" in each for each in extras)
