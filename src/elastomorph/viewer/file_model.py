"""Models from files: a GLB as it is, with its clips, and what elastomorph stored in it."""

from __future__ import annotations

from pathlib import Path

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import read_bytes
from elastomorph.io.gltf import read_glb
from elastomorph.io.gltf.container import open_gltf
from elastomorph.viewer.scene import Role, SceneModel

__all__ = ["file_curves", "file_model"]


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
    extras = [mesh.get("extras") for mesh in open_gltf(path).items("meshes")]
    if not any(isinstance(each, dict) and "elastomorph" in each for each in extras):
        return None
    return extract_curves(read_glb(path).neutral)
