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

    def read(stored: Rig | None) -> Rig:
        return named.full(say, stored=stored)

    if named.settings is not None:
        return FaceFile.by_settings(name, named.followed or named.settings, read)
    character = None if named.place is None else gltf_in(named.place)
    settled = named.method is not None or bool(named.mesh)
    return FaceFile(name, read, character, tuple(named.mesh), settled)
