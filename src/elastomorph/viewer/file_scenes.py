"""Scenes of files: a face with its paths, looks and clips, or a GLB file of ours as it is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from elastomorph.bending.gltf import glb_with_paths
from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import FormatError, ParameterError
from elastomorph.io import read_rig
from elastomorph.io.atomic import read_bytes
from elastomorph.io.gltf import read_glb
from elastomorph.io.gltf.clips import WeightClip, read_weight_clips
from elastomorph.io.gltf.container import GltfFile, open_gltf
from elastomorph.paths import Method
from elastomorph.rig import Rig
from elastomorph.rig.build import extent_of, with_paths
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
        files: Rig files, folders of meshes, or whatever ``read`` knows. A GLB file of ours is
            shown as it is if no method is named.
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
        if _is_glb(file) and not (parsed or chosen) and _is_ours(open_gltf(file)):
            say(f"reading {file}")
            models.append(_file_model(file, name, role))
            curves = extract_curves(read_glb(file).neutral) if curves is None else curves
            continue
        rig = read(file)
        curves = _curves(rig) if curves is None else curves
        diameter = _diameter(rig) if diameter is None else diameter
        say(f"preparing {name}")
        if not parsed:
            models.append(_model(file, rig, name, role))
        for method in parsed:
            title = f"{name}, {method.label}" if len(files) > 1 else method.label
            models.append(_model(file, with_paths(rig, method), title, role))
    start = comparison_start(len(models))
    rigs = " and ".join(_names(files))
    title = f"{rigs}: {', '.join(method.label for method in parsed)}" if parsed else rigs
    return Scene(tuple(models), title, unit, diameter, curves, start, rigs)


def _model(file: str, rig: Rig, name: str, role: Role) -> SceneModel:
    """A model of a rig that was read from a file.

    A character in GLB or VRM is its own file with these paths in it, so that the page shows all
    that it shows of that file by itself. Of what was changed in ways of which that cannot be made
    there is one mesh, with the looks of surfaces that we know.
    """
    if _is_glb(file) and _is_split(rig):
        with suppress(FormatError):
            return SceneModel(name, role, glb_with_paths(file, rig))
    return rig_model(rig, name, role, _clips(file, rig))


def _file_model(path: str | Path, name: str, role: Role) -> SceneModel:
    """A model that is a GLB file as it stands."""
    try:
        return SceneModel(name, role, read_bytes(path))
    except ParameterError:
        raise FormatError(
            path, "no GLB file, or a damaged one: expected glTF 2.0 in binary form with a mesh"
        ) from None


def _is_ours(file: GltfFile) -> bool:
    """Whether elastomorph wrote all of a file; of a character that it bent, others wrote the rest.

    The page shows its own files as they are, unless they are compressed. Those of others are read
    here, where their skins, compression and further meshes are known, and handed over as one face
    with its looks.
    """
    if any("compression" in str(name) for name in file.items("extensionsUsed")):
        return False
    extras = [mesh.get("extras") for mesh in file.items("meshes") if isinstance(mesh, dict)]
    own = [
        each["elastomorph"] for each in extras if isinstance(each, dict) and "elastomorph" in each
    ]
    return any(isinstance(each, dict) and "surface" in each for each in own)


def _is_split(rig: Rig) -> bool:
    """Whether a face is of triangles that were cut apart at seams, as players want them."""
    neutral = rig.neutral
    split = neutral.source is not None and neutral.source.split
    return split and bool((neutral.faces.sizes == 3).all())


def _curves(rig: Rig) -> CurveNetwork | None:
    """The curves on a face, if it has polygons whose edges follow on.

    Triangles do not, and at seams where vertices were cut apart curves would end.
    """
    return None if _is_split(rig) else extract_curves(rig.neutral)


def _diameter(rig: Rig) -> float:
    """The unit of distances: of a whole character, the extent of what its targets move."""
    return (_is_split(rig) and extent_of(rig)) or rig.neutral.diameter


def _clips(file: str, rig: Rig) -> list[WeightClip]:
    """The clips of a file that move sliders; they play on the paths of the rig."""
    played = _is_glb(file) or Path(file).suffix.lower() == ".gltf"
    return read_weight_clips(file, rig.sliders) if played and rig.names else []


def _is_glb(file: str) -> bool:
    return Path(file).suffix.lower() in (".glb", ".vrm")


def _names(files: Sequence[str]) -> list[str]:
    """The names of the files without folder and suffix, if that tells them apart."""
    stems = [Path(file).resolve().stem for file in files]
    return stems if len(set(stems)) == len(stems) else list(files)
