"""Scenes of files: a face with its paths, looks and clips, or a GLB file of ours as it is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from elastomorph.bending.opened import OpenedCharacter
from elastomorph.character import Settings
from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import ElastomorphError, FormatError, ParameterError
from elastomorph.io import read_rig
from elastomorph.io.atomic import is_folder, read_bytes
from elastomorph.io.gltf.clips import WeightClip, weight_clips
from elastomorph.io.gltf.container import GltfFile, gltf_of
from elastomorph.paths import Method
from elastomorph.rig import Rig
from elastomorph.rig.build import extent_of, with_paths
from elastomorph.viewer.rig_scenes import comparison_start, rig_model
from elastomorph.viewer.scene import Role, Scene, SceneModel

# Faces as they were named: where they are, and how the rig of each is read, once.

_GLTF = (".glb", ".vrm", ".gltf")


@dataclass(frozen=True, eq=False)
class FaceFile:
    """A face as somebody named it.

    Attributes:
        name: How it was named.
        read: Reads the rig; of a character it is handed what was read of its file.
        character: The .glb, .vrm or .gltf file that it is, or that settings name; None for others.
        meshes: Names of the meshes of that file that are meant; all where there are none.
        settled: Whether settings, a method or names of meshes say what it is, so that no file is
            shown as it stands.
    """

    name: str
    read: Callable[[Rig | None], Rig]
    character: Path | None = None
    meshes: tuple[str, ...] = ()
    settled: bool = False

    @classmethod
    def of(cls, path: str, say: Callable[[str], None] = lambda _: None, **reading: Any) -> FaceFile:
        """Any rig file or folder, with the paths that it has and the default where it has none.

        It is read as by `elastomorph.io.read_rig`.
        """

        def read(stored: Rig | None) -> Rig:
            if stored is not None:
                return with_paths(stored, say=say)
            return read_rig(path, say=say, **reading)

        return cls(path, read, gltf_in(path))

    @classmethod
    def by_settings(
        cls, name: str, settings: Settings, read: Callable[[Rig | None], Rig]
    ) -> FaceFile:
        """What settings name, with the paths that they say."""
        own = settings.character
        rig = None if own.rig is None else gltf_in(settings.file(own.rig))
        return cls(name, read, rig, own.mesh, settled=True)

    @property
    def title(self) -> str:
        """Its name without folder and suffix."""
        return Path(self.name).resolve().stem

    def shown_as_it_is(self) -> bytes | None:
        """The content of the file, where elastomorph wrote all of it and nothing else is asked."""
        if self.settled or self.character is None or not _is_ours(self._file):
            return None
        return self._content if self._file.is_glb else None

    @cached_property
    def opened(self) -> OpenedCharacter | None:
        """The character that was read, if it is one."""
        return None if self.character is None else OpenedCharacter.of(self._file, self.meshes)

    @cached_property
    def rig(self) -> Rig:
        """The rig with its paths."""
        return self.read(None if self.opened is None else self.opened.rig)

    def own_glb(self, rig: Rig) -> bytes | None:
        """The file itself with the paths of a rig in it; None where that cannot be made."""
        if self.opened is None or not is_split(self.opened.rig):
            return None
        with suppress(ElastomorphError):
            return self.opened.glb(rig)
        return None

    def clips(self, rig: Rig) -> list[WeightClip]:
        """The clips of the file that move sliders of a rig."""
        return weight_clips(self._file, rig.sliders) if self.character and rig.names else []

    @cached_property
    def _content(self) -> bytes:
        assert self.character is not None
        return read_bytes(self.character)

    @cached_property
    def _file(self) -> GltfFile:
        assert self.character is not None
        return gltf_of(self.character, self._content)


def gltf_in(path: str | Path) -> Path | None:
    """A path, if it is that of a character in glTF by its suffix."""
    return Path(path) if Path(path).suffix.lower() in _GLTF and not is_folder(path) else None


def is_split(rig: Rig) -> bool:
    """Whether a face is of triangles that were cut apart at seams, as players want them."""
    neutral = rig.neutral
    split = neutral.source is not None and neutral.source.split
    return split and bool((neutral.faces.sizes == 3).all())


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
