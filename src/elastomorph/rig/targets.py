"""The paths of a rig: those given, and those made to targets that are meshes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from elastomorph.blas_threads import in_own_threads
from elastomorph.errors import ParameterError
from elastomorph.model.geometry import moved_extent
from elastomorph.model.mesh import Mesh, require_mesh, require_same_topology
from elastomorph.model.morph import Morph

if TYPE_CHECKING:
    from elastomorph.paths import Method

__all__ = ["each_path", "paths_to"]


def paths_to(
    neutral: Mesh, morphs: Mapping[str, Morph | Mesh], method: str | Method | None = None
) -> dict[str, Morph]:
    """A path from the neutral by each name, in the order of the names.

    Args:
        neutral: The face at rest.
        morphs: Paths from this neutral, or targets of its vertices and polygons.
        method: How paths are made to the targets; the default of `Method` if none is named.

    Raises:
        MeshError: The neutral is no mesh, or something is neither a path nor a mesh.
        TopologyError: Something belongs to another mesh.
        ParameterError: Not a mapping from names, a path starts at another neutral, or a method is
            given and there is no mesh.
    """
    require_mesh(neutral, "the neutral of a rig")
    if not isinstance(morphs, Mapping):
        raise ParameterError(
            "a rig needs a mapping from names to morphs or meshes, such as "
            f"{{'jawOpen': mesh}}, found {type(morphs).__name__}"
        )
    targets: dict[str, Mesh] = {}
    for name, given in morphs.items():
        if not isinstance(name, str):
            raise ParameterError(f"the names of a rig are texts, found {name!r}")
        if isinstance(given, Morph):
            _require_start(neutral, name, given)
        else:
            require_mesh(given, f"{name!r} of the rig (if it is no Morph)")
            require_same_topology(neutral, given)
            targets[name] = given
    if not targets:
        if method is not None:
            raise ParameterError("every path of the rig is there: a method has nothing to make")
        return dict(morphs)  # type: ignore[arg-type]
    # Imported here: a rig whose paths are there needs nothing of what makes them.
    from elastomorph.paths import Method, prepare

    chosen = Method() if method is None else Method.of(method)
    extent = None
    if "extent" in chosen.inputs():
        ends = [m.target if isinstance(m, Morph) else m for m in morphs.values()]
        extent = moved_extent(neutral.vertices, [end.vertices for end in ends])
    made = each_path(prepare(neutral, chosen, extent=extent), targets)
    whole = {name: m for name, m in morphs.items() if isinstance(m, Morph)} | made
    return {name: whole[name] for name in morphs}


def each_path(
    to: Callable[[Mesh], Morph],
    targets: Mapping[str, Mesh],
    say: Callable[[str], None] = lambda _: None,
) -> dict[str, Morph]:
    """The path to each target by its name, made on all cores.

    Args:
        to: Makes a path, as `elastomorph.prepare` gives it.
        targets: Targets by name.
        say: Told which path is being made.
    """
    names = list(targets)
    made: dict[str, Morph] = {}

    def make(number: int) -> None:
        name = names[number]
        say(f"the path to {name}, {number + 1} of {len(names)}")
        made[name] = to(targets[name])

    in_own_threads(make, range(len(names)))
    return made


def _require_start(neutral: Mesh, name: str, morph: Morph) -> None:
    require_same_topology(neutral, morph.neutral)
    if not np.array_equal(neutral.vertices, morph.neutral.vertices):
        raise ParameterError(f"the morph {name!r} starts at another neutral than that of the rig")
