"""Faces as they were named: where they are, and how the rig of each is read, once."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from elastomorph.bending.opened import OpenedCharacter
from elastomorph.character import Settings
from elastomorph.errors import ElastomorphError
from elastomorph.io import read_rig
from elastomorph.io.atomic import is_folder, read_bytes
from elastomorph.io.gltf.clips import WeightClip, weight_clips
from elastomorph.io.gltf.container import GltfFile, gltf_of
from elastomorph.rig import Rig
from elastomorph.rig.build import with_paths

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
