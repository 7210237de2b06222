"""From a neutral and a target to a path, by any method."""

from __future__ import annotations

from collections.abc import Callable, Collection
from threading import Lock
from typing import Any

from numpy.typing import ArrayLike

from elastomorph.blas_threads import one_blas_thread
from elastomorph.curves import CurveNetwork, extract_curves, region_of, require_curves_of
from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.mesh import Mesh, require_mesh, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.paths.method import Method, Prepared
from elastomorph.paths.region import blend_into_rest, weights_inside
from elastomorph.paths.welding import Welding


def interpolate(
    neutral: Mesh,
    target: Mesh,
    method: str | Method = "auto",
    *,
    curves: CurveNetwork | None = None,
    region: ArrayLike | str | None = None,
    falloff: float | None = None,
    rest: str | None = None,
    rigidity: ArrayLike | None = None,
    pinned: ArrayLike | None = None,
    extent: float | None = None,
    weld: bool = True,
    **settings: object,
) -> Morph:
    """The path from a neutral to a target.

    Args:
        neutral: The mesh at t = 0.
        target: The mesh at t = 1, with the vertices and polygons of the neutral.
        method: A name (``linear``, ``cosine``, ``ease``, ``beam``, ``plate``, ``arc``,
            ``rotation``, ``auto``), a text such as ``beam:3``, or a `Method`.
        curves: The curves that beams follow; found by `extract_curves` by default.
        region: Vertex indices, (V,) bool, or the name of a group of the neutral's polygons; the
            method is used there only, on the parts of the curves inside.
        falloff: Rings of edges inside the border of the region over which its path blends into
            the rest, without a jump; 3 by default.
        rest: What vertices outside the region do: ``linear`` (default) or ``neutral`` (stay).
        rigidity: (V,) painted rigidity of a ``plate``, times that of its material.
        pinned: Vertices of a ``plate`` that follow the limit law, indices or (V,) bool.
        extent: The length D that ``straight_within`` of ``auto`` is a fraction of, in the unit of
            the vertices: for a rig the size of what its targets move, see
            `moved_extent`. ``neutral.diameter`` by default. Only for ``auto``.
        weld: Whether vertices at one place in the neutral and in the target move as one, whatever
            file they come from. Curves, rigidity and pinned vertices that are given are of the
            mesh as it is, and so is the path.
        **settings: What the method named has, its fields: ``order``, ``material``,
            ``closure``, ``load``, ``basis``, ``stiffness``, ``harmonics``, ``tolerance``,
            ``straight_within``.

    Raises:
        TopologyError: Neutral and target differ in vertices or polygons.
        MeshError: The neutral has fewer than three vertices, or it or the target is no Mesh.
        CurveError: The curves belong to another mesh, or are none.
        ParameterError: A setting or a region is not understood, or the method has no such setting;
            falloff or rest without a region.
        ResonanceError: The material is singular for this load.
    """
    require_same_topology(neutral, target)
    prepared = prepare(
        neutral,
        method,
        curves=curves,
        region=region,
        falloff=falloff,
        rest=rest,
        rigidity=rigidity,
        pinned=pinned,
        extent=extent,
        weld=weld,
        targets=[target],
        **settings,
    )
    return prepared(target)


@one_blas_thread()
def prepare(
    neutral: Mesh,
    method: str | Method = "auto",
    *,
    curves: CurveNetwork | None = None,
    region: ArrayLike | str | None = None,
    falloff: float | None = None,
    rest: str | None = None,
    rigidity: ArrayLike | None = None,
    pinned: ArrayLike | None = None,
    extent: float | None = None,
    weld: bool = True,
    targets: Collection[Mesh] | None = None,
    **settings: object,
) -> Prepared:
    """A function from target to path, for many targets of one neutral.

    Curves and time laws are found once, and the function may be called from several threads: each
    uses one thread of BLAS. Arguments and errors as in `interpolate`.

    With all `targets` of a rig, vertices move as one that are at one place in the neutral and in
    every one of them; without, those that are in the neutral and in the target of the call.
    """
    require_mesh(neutral, "the neutral")
    count = len(neutral.vertices)
    if count < 3:
        raise MeshError(f"{neutral.name} has {count} vertices; a face needs at least 3")
    if isinstance(method, Method) and (given := _given(**settings)):
        raise ParameterError(
            f"give {', '.join(sorted(given))} within the Method, or the method by its name"
        )
    chosen = method if isinstance(method, Method) else Method.parse(method, **settings)
    if curves is not None:
        require_curves_of(curves, count, neutral.name)
    own = _given(rigidity=rigidity, pinned=pinned, extent=extent)
    for name in own:
        if name not in chosen.inputs():
            takers = ", ".join(each.name for each in Method.known if name in each.inputs())
            raise ParameterError(f"only {takers} takes {name}, not {chosen.name}")
    border = _given(falloff=falloff, rest=rest)
    if region is None and border:
        raise ParameterError(f"{' and '.join(border)} without a region: name one as region=…")
    if region is not None:
        region = region_of(neutral, region)

    def made(welding: Welding | None = None) -> Prepared:
        start, network, inside = neutral, curves, region
        if welding is not None:
            start, network = welding.neutral, None
            inside = None if region is None else welding.vertices(region)
        weights = None
        if inside is not None:
            network = extract_curves(start) if network is None else network
            weights = weights_inside(start, network, inside, border.get("falloff", 3))
            network = network.restricted(inside)
        to = chosen.prepare(start, network, **own)
        if welding is not None:
            to = welding.around(neutral, to)
            weights = None if weights is None else welding.fields(weights[:, None])[:, 0]
        return to if weights is None else blend_into_rest(to, weights, border.get("rest", "linear"))

    # Curves and what is painted are of the vertices as they are.
    painted = (curves is not None and chosen.on_curves) or {"rigidity", "pinned"}.intersection(own)
    if not weld or chosen.pointwise or painted or not len(neutral.faces):
        return one_blas_thread()(made())
    if "extent" in chosen.inputs():
        own.setdefault("extent", neutral.diameter)
    return one_blas_thread()(_welded(neutral, targets, made))


def _welded(
    neutral: Mesh, targets: Collection[Mesh] | None, made: Callable[[Welding | None], Prepared]
) -> Prepared:
    """Prepare for the vertices that are one, for all targets together or for each by itself."""
    split = neutral.source is not None and neutral.source.split

    def welding_of(ends: Collection[Mesh], still: bool) -> Welding | None:
        found = Welding.of(neutral, [end.vertices for end in ends], weld=True, still=still)
        return found if found.joins else None

    if targets is not None:
        # Files that split vertices are of whole characters: what hangs on no part that moves is
        # left out of what is solved.
        return made(welding_of(targets, still=len(targets) < 2 or not split))
    common = welding_of([], still=True)
    if common is None:
        return made(None)
    known = {common.first.tobytes(): made(common)}
    lock = Lock()

    def to(target: Mesh) -> Morph:
        require_same_topology(neutral, target)
        welding = welding_of([target], still=True)
        key = b"" if welding is None else welding.first.tobytes()
        with lock:
            if key not in known:
                known[key] = made(welding)
        return known[key](target)

    return to


def _given(**options: Any) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}
