"""Scenes of files: paths made from their targets, or a GLB file as it is, with its clips."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import ElastomorphWarning, FormatError, ParameterError
from elastomorph.io import read_rig
from elastomorph.io.atomic import read_bytes
from elastomorph.io.gltf import read_glb
from elastomorph.io.gltf.container import GltfFile, open_gltf
from elastomorph.paths import Method
from elastomorph.rig import Rig
from elastomorph.rig.build import with_paths
from elastomorph.viewer.rig_scenes import comparison_start, rig_model
from elastomorph.viewer.scene import Role, Scene, SceneModel


def read_scene(
    files: Sequence[str],
    methods: Sequence[str] = (),
    *,
    unit: str = "",
    read: Callable[[str], Rig] = read_rig,
    say: Callable[[str], None] = lambda _: None,
    chosen: bool = False,
) -> Scene:
    """A scene of each file by each method.

    Args:
        files: Rig files, folders of meshes, or whatever ``read`` knows. A GLB file of ours, and
            one of others with clips, is shown as it is if no method is named.
        methods: How paths are made from the targets, as for `elastomorph.interpolate`. Without
            any, the paths are those that are read.
        unit: Unit of the coordinates, for legends.
        read: What reads a rig.
        say: Told what is being done.
        chosen: Whether ``read`` chooses among the meshes of a file, so that none is shown as it is.
    """
    parsed = [Method.parse(text) for text in methods]
    role: Role = "rig" if len(files) * max(1, len(methods)) == 1 else "method"
    models: list[SceneModel] = []
    curves: CurveNetwork | None = None
    diameter: float | None = None
    for file, name in zip(files, _names(files), strict=True):
        if _is_glb(file) and not (parsed or chosen) and _stands_as_it_is(file):
            say(f"reading {file}")
            models.append(_file_model(file, name, role))
            curves = _file_curves(file) if curves is None else curves
            continue
        rig = read(file)
        curves = extract_curves(rig.neutral) if curves is None else curves
        diameter = rig.neutral.diameter if diameter is None else diameter
        say(f"preparing {name}")
        if not parsed:
            models.append(rig_model(rig, name, role))
        for method in parsed:
            title = f"{name}, {method.label}" if len(files) > 1 else method.label
            models.append(rig_model(with_paths(rig, method), title, role))
    start = comparison_start(len(models))
    return Scene(tuple(models), _title(files, parsed), unit, diameter, curves, start)


def _file_model(path: str | Path, name: str, role: Role) -> SceneModel:
    """A model that is a GLB file as it stands."""
    try:
        return SceneModel(name, role, read_bytes(path))
    except ParameterError:
        raise FormatError(
            path, "no GLB file, or a damaged one: expected glTF 2.0 in binary form with a mesh"
        ) from None


def _file_curves(path: str | Path) -> CurveNetwork | None:
    """The curves on a GLB file of elastomorph; None for one of others.

    Files of other programs hold triangles, whose edges are no loops, and copies of vertices along
    seams, where curves would end.
    """
    return extract_curves(read_glb(path).neutral) if _is_ours(open_gltf(path)) else None


def _stands_as_it_is(path: str | Path) -> bool:
    """Whether there is nothing to be bent in a GLB file, or its clips would be lost by that.

    The paths of a file of elastomorph are its own; a file without morph targets has none; and one
    of others with clips can play them only as it is, of which a warning says how to bend it.
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


def _is_glb(file: str) -> bool:
    return Path(file).suffix.lower() in (".glb", ".vrm")


def _names(files: Sequence[str]) -> list[str]:
    """The names of the files without folder and suffix, if that tells them apart."""
    stems = [Path(file).resolve().stem for file in files]
    return stems if len(set(stems)) == len(stems) else list(files)


def _title(files: Sequence[str], methods: Sequence[Method]) -> str:
    title = " and ".join(_names(files))
    return f"{title}: {', '.join(method.label for method in methods)}" if methods else title
