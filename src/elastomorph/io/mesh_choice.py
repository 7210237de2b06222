"""Which of the meshes in a file become the rig: the same rule for glTF, USD and FBX.

By default all that the author sees, with or without blend shapes, in the order of the file: a face
keeps its eyes, teeth and hair. Names restrict it to the meshes that have one of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from elastomorph.errors import ParameterError

__all__ = ["ListedMesh", "chosen_meshes", "wanted_names"]

_MOST_SHOWN = 12


@dataclass(frozen=True)
class ListedMesh:
    """A mesh that may be chosen.

    Attributes:
        names: What it may be asked for by; the first is shown in messages.
        shapes: Number of its blend shapes.
        shown: Whether its author sees it.
    """

    names: tuple[str, ...]
    shapes: int
    shown: bool = True


def wanted_names(mesh: str | Sequence[str] | None) -> tuple[str, ...]:
    """The names in an argument ``mesh=``; none means all meshes."""
    if mesh is None:
        return ()
    names = (mesh,) if isinstance(mesh, str) else tuple(mesh)
    if not names:
        raise ParameterError("name at least one mesh, or leave 'mesh' out")
    return names


def chosen_meshes(
    meshes: Sequence[ListedMesh], wanted: Sequence[str], *, need_shapes: bool = True
) -> list[int]:
    """The places of the meshes to read, rising.

    Hidden meshes are taken where they are asked for, or where no other has blend shapes.
    """
    for name in wanted:
        if not any(name in mesh.names for mesh in meshes):
            raise ParameterError(f"no mesh is called '{name[:60]}'; {_listed(meshes)}")
    if wanted:
        names = set(wanted)
        return [i for i, mesh in enumerate(meshes) if names.intersection(mesh.names)]
    shaped = [i for i, mesh in enumerate(meshes) if mesh.shapes]
    if need_shapes and not shaped:
        raise ParameterError(
            f"no mesh has blend shapes; {_listed(meshes)}. Switch on blend shapes (shape keys, "
            "morpher) when exporting"
        )
    if any(meshes[i].shown for i in shaped):
        shaped = []
    return [i for i, mesh in enumerate(meshes) if mesh.shown or i in shaped]


def _listed(meshes: Sequence[ListedMesh]) -> str:
    shown = [
        f"'{mesh.names[0][:60]}' ({mesh.shapes or 'no'} shapes)" for mesh in meshes[:_MOST_SHOWN]
    ]
    more = ", …" if len(meshes) > _MOST_SHOWN else ""
    return f"there are {', '.join(shown) or 'no meshes'}{more}"
