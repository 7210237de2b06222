"""Rigs built of bare targets, and the rig of another whose paths a method makes anew."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

from elastomorph.curves import CurveNetwork
from elastomorph.model.geometry import moved_extent
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths import Method, prepare
from elastomorph.rig.laws import PRODUCT
from elastomorph.rig.pairs import is_pair_bend
from elastomorph.rig.rig import Rig, paths_to


def bare_rig(neutral: Mesh, targets: Mapping[str, Mesh]) -> Rig:
    """A rig of which only the shapes are known: see `elastomorph.Morph.bare`."""
    to = prepare(neutral, "linear")
    return Rig(neutral, {name: replace(to(mesh), bare=True) for name, mesh in targets.items()})


def extent_of(rig: Rig) -> float:
    """D of a rig: the largest distance between two vertices that one of its targets moves."""
    targets = (morph.target.vertices for morph in rig.morphs.values())
    return moved_extent(rig.neutral.vertices, targets)


def with_paths(
    rig: Rig,
    method: str | Method | None = None,
    *,
    names: Collection[str] | None = None,
    curves: CurveNetwork | None = None,
    say: Callable[[str], None] = lambda _: None,
    extent: float | None = None,
    **settings: object,
) -> Rig:
    """The rig with a path to each target; the same rig where there is nothing to be done.

    A `method` makes all paths anew, as for `elastomorph.interpolate`, with the `settings` of
    `Method` for all of them; None: the default where only the target is known, and all other paths
    stay, as do shapes that others drive by another law than a product: they correct those paths.
    `names` are the only morphs that get paths, for some methods take their time; the others count
    for D, the `extent`, which is that of what the targets move by default.
    """
    anew = any(value is not None for value in (method, extent, *settings.values()))
    driven = {n for n, own in rig.sliders.correctives.items() if own.law != PRODUCT}
    made = {
        name
        for name, morph in rig.morphs.items()
        if (anew or morph.bare) and (names is None or name in names)
        if not is_pair_bend(morph) and name not in driven.difference(rig.names)
    }
    if not made:
        return rig
    # Pair bends are of the paths that were, and new ones of those that are, whoever made these.
    gone = rig.pair_bends().keys() - rig.pair_bends(made)
    given: dict[str, Morph | Mesh] = {
        n: m.target if n in made else m for n, m in rig.morphs.items() if n not in gone
    }
    kept = {name: own for name, own in rig.sliders.correctives.items() if name not in gone}
    turned = {n for n, m in given.items() if n not in made and _turns(m)}
    morphs, correctives = paths_to(
        rig.neutral,
        given,
        method,
        curves=curves,
        extent=extent,
        correctives=kept,
        turned=turned,
        say=say,
        **settings,
    )
    return Rig(rig.neutral, morphs, correctives=correctives, groups=rig.sliders.groups)


def _turns(path: Morph | Mesh) -> bool:
    """Whether a path was made by a method that turns what moves."""
    return isinstance(path, Morph) and (
        path.choice is not None or path.method in ("rotation", "arc")
    )
