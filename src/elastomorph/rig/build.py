"""Rigs built of bare targets, and the rig of another whose paths a method makes anew."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

from elastomorph.curves import CurveNetwork
from elastomorph.model.geometry import moved_extent
from elastomorph.model.mesh import Mesh
from elastomorph.paths import Method, prepare
from elastomorph.rig.rig import Rig
from elastomorph.rig.targets import each_path

__all__ = ["bare_rig", "extent_of", "with_paths"]


def bare_rig(neutral: Mesh, targets: Mapping[str, Mesh]) -> Rig:
    """A rig of which only the shapes are known: see `elastomorph.Morph.bare`.

    Args:
        neutral: The face at rest.
        targets: Its targets by name.

    Raises:
        TopologyError: A target has other vertices or polygons than the neutral.
    """
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
    """The rig with a path to each target.

    Args:
        rig: The rig.
        method: Makes all paths anew, as for `elastomorph.interpolate`. None: the default method
            where only the target is known; all other paths stay.
        names: The only morphs that get paths, for some methods take their time; all by default.
            The others stay as they are, and count for D.
        curves: The curves that beams follow; found on the neutral by default.
        say: Told what is being done.
        extent: D for ``auto``; that of what the targets move by default.
        **settings: Fields of `Method`, for all paths.

    Returns:
        The same rig where there is nothing to be done.

    Raises:
        ElastomorphError: As `elastomorph.prepare`.
    """
    anew = any(value is not None for value in (method, extent, *settings.values()))
    method = "auto" if method is None else method
    missing = [
        name
        for name, morph in rig.morphs.items()
        if (anew or morph.bare) and (names is None or name in names)
    ]
    if not missing:
        return rig
    if extent is None and "extent" in Method.of(method).inputs():
        extent = extent_of(rig)
    to = prepare(rig.neutral, method, curves=curves, extent=extent, **settings)  # type: ignore[arg-type]
    made = each_path(to, {name: rig.morphs[name].target for name in missing}, say)
    morphs = {**rig.morphs, **made}
    return Rig(rig.neutral, morphs, correctives=rig.sliders.correctives, groups=rig.sliders.groups)
