"""From what a user names, files and methods, to a scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.io import read_rig
from elastomorph.paths import Method
from elastomorph.rig import Rig
from elastomorph.rig.remade import with_paths
from elastomorph.viewer.file_model import file_curves, file_model, stands_as_it_is
from elastomorph.viewer.rig_scenes import comparison_start, rig_model
from elastomorph.viewer.scene import Role, Scene, SceneModel

__all__ = ["read_scene"]


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

    Raises:
        FileError: A file is missing or cannot be read.
        FormatError: A file is not what its format allows.
        ParameterError: A method is not understood, there are no polygons, or the models do not
            have the same vertices.
        MissingExtraError: A format needs a package that is not installed.
    """
    parsed = [Method.parse(text) for text in methods]
    role: Role = "rig" if len(files) * max(1, len(methods)) == 1 else "method"
    models: list[SceneModel] = []
    curves: CurveNetwork | None = None
    diameter: float | None = None
    for file, name in zip(files, _names(files), strict=True):
        if _is_glb(file) and not (parsed or chosen) and stands_as_it_is(file):
            say(f"reading {file}")
            models.append(file_model(file, name, role))
            curves = file_curves(file) if curves is None else curves
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


def _is_glb(file: str) -> bool:
    return Path(file).suffix.lower() in (".glb", ".vrm")


def _names(files: Sequence[str]) -> list[str]:
    """The names of the files without folder and suffix, if that tells them apart."""
    stems = [Path(file).resolve().stem for file in files]
    return stems if len(set(stems)) == len(stems) else list(files)


def _title(files: Sequence[str], methods: Sequence[Method]) -> str:
    title = " and ".join(_names(files))
    return f"{title}: {', '.join(method.label for method in methods)}" if methods else title
