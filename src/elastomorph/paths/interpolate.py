"""From a neutral and a target to a path, by any method."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from elastomorph.blas_threads import one_blas_thread
from elastomorph.curves import CurveNetwork, extract_curves, region_of, require_curves_of
from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.mesh import Mesh, require_mesh, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.paths.method import Method, Prepared
from elastomorph.paths.region import blend_into_rest, weights_inside

__all__ = ["interpolate", "prepare"]


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
    **settings: object,
) -> Prepared:
    """A function from target to path, for many targets of one neutral.

    Curves and time laws are found once, and the function may be called from several threads: each
    uses one thread of BLAS. Arguments and errors as in `interpolate`.
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
    if region is None:
        return one_blas_thread()(chosen.prepare(neutral, curves, **own))
    network = extract_curves(neutral) if curves is None else curves
    region = region_of(neutral, region)
    weights = weights_inside(neutral, network, region, border.get("falloff", 3))
    prepared = chosen.prepare(neutral, network.restricted(region), **own)
    return one_blas_thread()(blend_into_rest(prepared, weights, border.get("rest", "linear")))


def _given(**options: Any) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}
