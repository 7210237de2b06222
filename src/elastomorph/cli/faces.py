"""The faces that a page shows, as the command line names them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from elastomorph.cli.options import NamedRig
from elastomorph.cli.output import Say

if TYPE_CHECKING:
    from elastomorph.rig import Rig
    from elastomorph.viewer.face_files import FaceFile


def face_file(named: NamedRig, name: str, say: Say) -> FaceFile:
    """A rig that was named, to be read when it is shown; ``name`` is how it was called."""
    from elastomorph.viewer.face_files import FaceFile, gltf_in

    settings = named.followed if named.settings is not None else None
    if settings is None:
        character = None if named.place is None else gltf_in(named.place)
        meshes = tuple(named.mesh)
    else:
        rig = settings.character.rig
        character = None if rig is None else gltf_in(settings.file(rig))
        meshes = settings.character.mesh

    def read(stored: Rig | None) -> Rig:
        return named.full(say, stored=stored)

    said = named.settings is not None or named.method is not None
    return FaceFile(name, read, character, meshes, settled=said or bool(named.mesh))
