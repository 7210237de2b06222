"""Scenes of files: a face with its paths, looks and clips, or a GLB file of ours as it is."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import FormatError, ParameterError
from elastomorph.paths import Method
from elastomorph.rig import Rig
from elastomorph.rig.build import extent_of, with_paths
from elastomorph.viewer.face_files import FaceFile, is_split
from elastomorph.viewer.rig_scenes import comparison_start, rig_model
from elastomorph.viewer.scene import Role, Scene, SceneModel


def read_scene(
    files: Sequence[str | FaceFile],
    methods: Sequence[str] = (),
    *,
    unit: str = "",
    say: Callable[[str], None] = lambda _: None,
) -> Scene:
    """A scene of each file by each method; every file is read once.

    Args:
        files: Rig files and folders of meshes, or what says how they are read. A GLB file of ours
            is shown as it is if no method is named.
        methods: How paths are made from the targets, as for `elastomorph.interpolate`. Without
            any, the paths are those that are read.
        unit: Unit of the coordinates, for legends.
        say: Told what is being done.
    """
    parsed = [Method.parse(text) for text in methods]
    role: Role = "rig" if len(files) * max(1, len(methods)) == 1 else "method"
    models: list[SceneModel] = []
    curves: CurveNetwork | None = None
    diameter: float | None = None
    faces = [file if isinstance(file, FaceFile) else FaceFile.of(file) for file in files]
    names = _names(faces)
    for face, name in zip(faces, names, strict=True):
        content = None if parsed else face.shown_as_it_is()
        if content is not None:
            say(f"reading {face.name}")
            models.append(_file_model(face, content, name, role))
            if curves is None and face.opened is not None:
                curves = extract_curves(face.opened.rig.neutral)
            continue
        rig = face.rig
        curves = _curves(rig) if curves is None else curves
        diameter = _diameter(rig) if diameter is None else diameter
        say(f"preparing {name}")
        if not parsed:
            models.append(_model(face, rig, name, role))
        for method in parsed:
            title = f"{name}, {method.label}" if len(files) > 1 else method.label
            models.append(_model(face, with_paths(rig, method), title, role))
    start = comparison_start(len(models))
    rigs = " and ".join(names)
    title = f"{rigs}: {', '.join(method.label for method in parsed)}" if parsed else rigs
    return Scene(tuple(models), title, unit, diameter, curves, start, rigs)


def _model(face: FaceFile, rig: Rig, name: str, role: Role) -> SceneModel:
    """A model of a rig that was read from a file.

    A character is its own file with these paths in it, so that the page shows all that it shows of
    that file by itself. Of what was changed in ways of which that cannot be made there is one mesh,
    with the looks of surfaces that we know.
    """
    own = face.own_glb(rig)
    if own is not None:
        return SceneModel(name, role, own)
    return rig_model(rig, name, role, face.clips(rig))


def _file_model(face: FaceFile, content: bytes, name: str, role: Role) -> SceneModel:
    """A model that is a GLB file as it stands."""
    try:
        return SceneModel(name, role, content)
    except ParameterError:
        raise FormatError(
            face.character or face.name,
            "no GLB file, or a damaged one: expected glTF 2.0 in binary form with a mesh",
        ) from None


def _curves(rig: Rig) -> CurveNetwork | None:
    """The curves on a face, if it has polygons whose edges follow on.

    Triangles do not, and at seams where vertices were cut apart curves would end.
    """
    return None if is_split(rig) else extract_curves(rig.neutral)


def _diameter(rig: Rig) -> float:
    """The unit of distances: of a whole character, the extent of what its targets move."""
    return (is_split(rig) and extent_of(rig)) or rig.neutral.diameter


def _names(faces: Sequence[FaceFile]) -> list[str]:
    """The names of the files without folder and suffix, if that tells them apart."""
    titles = [face.title for face in faces]
    return titles if len(set(titles)) == len(titles) else [face.name for face in faces]
