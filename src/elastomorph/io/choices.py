"""What was chosen: which meshes of a file become the rig, and why `auto` took a path.

By default all that the author sees, with or without blend shapes, in the order of the file: a face
keeps its eyes, teeth and hair. Names restrict it to the meshes that have one of them. The rule is
the same for glTF, USD and FBX. Why `auto` chose a path is kept beside every path that is stored.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from elastomorph.errors import ParameterError
from elastomorph.model.morph import Choice
from elastomorph.numbers import first_few

_MOST_SHOWN = 12
# What a choice counts, written where there is any.
_COUNTS = {
    "shrunk": int,
    "hidden": int,
    "eased": int,
    "crossing": int,
    "deeper": float,
    "meeting": float,
}


@dataclass(frozen=True)
class ListedMesh:
    """A mesh that may be asked for by any of its names; the first is shown in messages.

    It has so many blend shapes, and its author sees it or not.
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
    shown = (f"'{mesh.names[0][:60]}' ({mesh.shapes or 'no'} shapes)" for mesh in meshes)
    return f"there are {first_few(shown, _MOST_SHOWN) or 'no meshes'}"


def choice_to_json(choice: Choice | None) -> dict[str, Any] | None:
    """A choice as JSON, with what follows from it for those who only read; None of none."""
    if choice is None:
        return None
    return {
        "distance": float(choice.distance),
        "allowed": float(choice.allowed),
        "exact": choice.exact,
        "straight": choice.straight,
        **{name: getattr(choice, name) for name in _COUNTS if getattr(choice, name)},
    }


def choice_from_json(content: Any) -> Choice | None:
    """The choice in a file; None where nothing is said."""
    if content is None:
        return None
    try:
        distance, allowed = float(content["distance"]), float(content["allowed"])
        exact = content["exact"]
        counts = [number(content.get(name, 0)) for name, number in _COUNTS.items()]
    except (AttributeError, TypeError, LookupError, ValueError, OverflowError):
        exact = None
    if not isinstance(exact, bool) or not all(
        math.isfinite(number) and number >= 0 for number in (distance, allowed, *counts)
    ):
        raise ParameterError("the choice of a path is damaged")
    return Choice(distance, allowed, exact, *counts)
