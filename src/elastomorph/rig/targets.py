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
    from elastomorph.curves import CurveNetwork
    from elastomorph.paths import Method


def paths_to(
    neutral: Mesh,
    morphs: Mapping[str, Morph | Mesh],
    method: str | Method | None = None,
    *,
    curves: CurveNetwork | None = None,
    extent: float | None = None,
    say: Callable[[str], None] = lambda _: None,
    **settings: object,
) -> dict[str, Morph]:
    """A path from the neutral by each name, in their order: those given, and made to targets.

    They are made on all cores, by ``auto`` where no method is named, with D of what all move.
    Vertices at one place in the neutral and at the end of every path move as one, as for `prepare`.
    """
    require_mesh(neutral, "the neutral of a rig")
    if not isinstance(morphs, Mapping):
        raise ParameterError(
            "a rig needs a mapping from names to morphs or meshes, such as "
            f"{{'jawOpen': mesh}}, found {type(morphs).__name__}"
        )
    targets = _bare_targets(neutral, morphs)
    if not targets:
        if method is not None:
            raise ParameterError("every path of the rig is there: a method has nothing to make")
        return dict(morphs)  # type: ignore[arg-type]
    # Imported here: a rig whose paths are there needs nothing of what makes them.
    from elastomorph.paths import Method, prepare

    chosen = "auto" if method is None else method
    ends = {name: m.target if isinstance(m, Morph) else m for name, m in morphs.items()}
    if extent is None and "extent" in Method.of(chosen).inputs():
        extent = moved_extent(neutral.vertices, [end.vertices for end in ends.values()])
    to = prepare(
        neutral,
        chosen,
        curves=curves,
        extent=extent,
        targets=list(ends.values()),
        **settings,  # type: ignore[arg-type]
    )
    whole = dict(morphs)

    def make(task: tuple[int, str]) -> None:
        number, name = task
        say(f"the path to {name}, {number} of {len(targets)}")
        whole[name] = to(targets[name])

    in_own_threads(make, enumerate(targets, start=1))
    return whole  # type: ignore[return-value]


def _bare_targets(neutral: Mesh, morphs: Mapping[str, Morph | Mesh]) -> dict[str, Mesh]:
    """The targets that paths are still to be made to; all must fit the neutral."""
    targets: dict[str, Mesh] = {}
    for name, given in morphs.items():
        if not isinstance(name, str):
            raise ParameterError(f"the names of a rig are texts, found {name!r}")
        if isinstance(given, Morph):
            require_same_topology(neutral, given.neutral)
            if not np.array_equal(neutral.vertices, given.neutral.vertices):
                raise ParameterError(
                    f"the morph {name!r} starts at another neutral than that of the rig"
                )
        else:
            require_mesh(given, f"{name!r} of the rig (if it is no Morph)")
            require_same_topology(neutral, given)
            targets[name] = given
    return targets
