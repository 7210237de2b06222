"""Parts of a mesh, and weights that fade out towards their boundary."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import CurveError, ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.numbers import as_number, first_few

_MOST_SHOWN = 12


def as_region(region: ArrayLike, vertex_count: int) -> NDArray[np.bool_]:
    """(V,) bool of a region: (N,) vertex indices in any order, repeats allowed, or (V,) bool."""
    given = np.asarray(list(region) if isinstance(region, set | frozenset | range) else region)
    if given.dtype == np.bool_ and given.shape == (vertex_count,):
        return np.array(given)
    if given.ndim != 1 or (given.size and given.dtype.kind not in "iu"):
        raise CurveError(
            f"a region must be a list of vertex indices, or ({vertex_count:,},) bool; "
            f"found {given.dtype} {given.shape}"
        )
    outside = (given < 0) | (given >= vertex_count)
    if outside.any():
        raise CurveError(
            f"the region names vertex {given[outside][0]}, but the mesh has {vertex_count:,} "
            f"vertices (0 to {vertex_count - 1:,})"
        )
    inside = np.zeros(vertex_count, dtype=np.bool_)
    inside[given.astype(np.int64)] = True
    return inside


def region_of(mesh: Mesh, region: ArrayLike | str) -> NDArray[np.bool_]:
    """Which vertices of a mesh a region holds, as (V,) bool.

    A region is what `as_region` takes, or the name of a group of the mesh's polygons, whose corners
    it is.
    """
    if not isinstance(region, str):
        return as_region(region, len(mesh.vertices))
    if mesh.groups is None or region not in mesh.groups.names:
        names = () if mesh.groups is None else mesh.groups.names
        raise ParameterError(f"{mesh.name} has no group {region!r}: {_nearest(region, names)}")
    chosen = mesh.groups.of_face == mesh.groups.names.index(region)
    corners = mesh.faces.indices[chosen[mesh.faces.corner_faces]]
    return as_region(corners, len(mesh.vertices))


def _nearest(name: str, names: Sequence[str]) -> str:
    if not names:
        return "its polygons have no groups; name the vertices of the region by their numbers"
    near = get_close_matches(name, names, n=3, cutoff=0.5)
    if near:
        return f"did you mean {' or '.join(map(repr, near))}?"
    return f"it has {first_few(names, _MOST_SHOWN)}"


def region_weights(
    edges: NDArray[np.int32], vertex_count: int, region: ArrayLike, falloff: float = 3
) -> NDArray[np.float64]:
    """(V,) weights from 0 to 1 that take a local region smoothly into the rest of the mesh.

    With d the number of edges from a vertex to the nearest one outside the region, the weight is
    3 s² − 2 s³ with s = min(d / falloff, 1): 0 outside, 1 from ``falloff`` edges inwards (sharp up
    to 1). A region without boundary (a whole component) has weight 1 throughout. Edges are (E, 2)
    as ``Mesh.edges``.
    """
    falloff = as_number(falloff, "falloff", least=0)
    inside = as_region(region, vertex_count)
    distance = np.where(inside, np.inf, 0.0)
    ends = np.concatenate([edges, edges[:, ::-1]])
    for ring in range(1, int(np.ceil(falloff))):
        ends = ends[~np.isfinite(distance[ends[:, 1]])]
        reached = ends[distance[ends[:, 0]] == ring - 1, 1]
        if reached.size == 0:
            break
        distance[reached] = ring
    s = np.minimum(distance / max(falloff, 1.0), 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s), dtype=np.float64)
