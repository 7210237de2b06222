"""Curves on a mesh, and networks of them in which no vertex lies on two.

Parts of a mesh, and weights that fade out towards their boundary.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import CurveError, ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.numbers import as_number, first_few, is_whole

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


@dataclass(frozen=True, eq=False, repr=False)
class Curve:
    """A polyline over vertices of a mesh.

    Attributes:
        vertices: (M,) int32, read-only: vertex indices in order, none of them twice.
        closed: Whether the last vertex is followed by the first (which is not repeated).
        name: What its author calls it, or an empty string.

    Raises:
        CurveError: No vertices, a vertex twice, indices that are not whole numbers from 0, or a
            closed curve of fewer than three vertices.
    """

    vertices: NDArray[np.int32]
    closed: bool
    name: str

    def __init__(self, vertices: ArrayLike, closed: bool = False, name: str = "") -> None:
        title = f"curve '{name}'" if name else "a curve"
        own = _as_indices(vertices, title)
        if own.size == 0:
            raise CurveError(f"{title} has no vertices; it needs at least one")
        if own.min() < 0:
            raise CurveError(
                f"{title} names vertex {own.min()}; vertices are counted from 0, so an index "
                "cannot be negative"
            )
        if closed and own.size < 3:
            raise CurveError(
                f"{title} is closed but has {own.size} vertices; a closed curve needs at least 3"
            )
        ordered = np.sort(own)
        twice = ordered[1:] == ordered[:-1]
        if twice.any():
            vertex = int(ordered[np.argmax(twice)])
            hint = (
                "; a closed curve does not repeat its first vertex, say closed=True instead"
                if own[0] == own[-1] == vertex
                else ""
            )
            raise CurveError(f"{title} passes through vertex {vertex} twice{hint}")
        own.flags.writeable = False
        for key, value in (("vertices", own), ("closed", bool(closed)), ("name", name)):
            object.__setattr__(self, key, value)

    @property
    def edges(self) -> NDArray[np.int32]:
        """(M - 1, 2) pairs of consecutive vertices; (M, 2) when closed."""
        if self.closed:
            return np.stack([self.vertices, np.roll(self.vertices, -1)], axis=1)
        return np.stack([self.vertices[:-1], self.vertices[1:]], axis=1)

    def __len__(self) -> int:
        return int(self.vertices.size)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Curve):
            return NotImplemented
        return (
            self.closed == other.closed
            and self.name == other.name
            and np.array_equal(self.vertices, other.vertices)
        )

    def __hash__(self) -> int:
        return hash((self.vertices.tobytes(), self.closed, self.name))

    def __repr__(self) -> str:
        title = f" '{self.name}'" if self.name else ""
        return f"Curve({'closed' if self.closed else 'open'}{title}, {len(self)} vertices)"


class CurveNetwork(Sequence[Curve]):
    """Curves of one mesh, each vertex on at most one of them. Immutable; reads like a tuple.

    Args:
        curves: The curves, in the order that numbers them.
        vertex_count: Number of vertices V of the mesh.

    Attributes:
        curves: The curves.
        vertex_count: Number of vertices V of the mesh.

    Raises:
        CurveError: A curve names a vertex that the mesh does not have, two curves share one, or
            something is no curve.
    """

    __slots__ = ("__dict__", "curves", "vertex_count")

    curves: tuple[Curve, ...]
    vertex_count: int

    def __init__(self, curves: Iterable[Curve], vertex_count: int) -> None:
        self.curves = tuple(curves) if isinstance(curves, Iterable) else (curves,)
        for curve in self.curves:
            if not isinstance(curve, Curve):
                raise CurveError(f"a network is made of Curves, found {type(curve).__name__}")
        if not is_whole(vertex_count):
            raise CurveError(f"the number of vertices must be whole, found {vertex_count!r}")
        self.vertex_count = int(vertex_count)
        _ = self.curve_of

    @cached_property
    def curve_of(self) -> NDArray[np.int32]:
        """(V,) int32, read-only: the curve that each vertex lies on, -1 for none."""
        lengths = [len(curve) for curve in self.curves]
        vertices = np.concatenate([np.empty(0, np.int32), *(c.vertices for c in self.curves)])
        owner = np.repeat(np.arange(len(self.curves), dtype=np.int32), lengths)
        if vertices.size and int(vertices.max()) >= self.vertex_count:
            entry = int(np.argmax(vertices >= self.vertex_count))
            raise CurveError(
                f"{self._title(owner[entry])} names vertex {vertices[entry]}, but the mesh has "
                f"{self.vertex_count:,} vertices (0 to {self.vertex_count - 1:,})"
            )
        found = np.full(self.vertex_count, -1, dtype=np.int32)
        found[vertices] = owner
        shared = found[vertices] != owner
        if shared.any():
            entry = int(np.argmax(shared))
            raise CurveError(
                f"vertex {vertices[entry]} lies on {self._title(owner[entry])} and on "
                f"{self._title(found[vertices[entry]])}; a vertex can lie on one curve only"
            )
        found.flags.writeable = False
        return found

    def _title(self, index: int) -> str:
        name = self.curves[index].name
        return f"curve {index} ('{name}')" if name else f"curve {index}"

    def restricted(self, region: ArrayLike) -> CurveNetwork:
        """The parts of the curves inside a region, for interpolation of a local region.

        Each run of consecutive vertices inside becomes a curve with the name of the whole. A
        closed curve stays closed only where it lies inside entirely; a run across its first
        vertex stays one run.

        Args:
            region: (N,) vertex indices, or (V,) bool.

        Raises:
            CurveError: The region names a vertex that the mesh does not have.
        """
        inside = as_region(region, self.vertex_count)
        parts: list[Curve] = []
        for curve in self.curves:
            kept = inside[curve.vertices]
            if kept.all():
                parts.append(curve)
            elif kept.any():
                parts.extend(Curve(run, False, curve.name) for run in _runs(curve, kept))
        return CurveNetwork(parts, self.vertex_count)

    def relabelled(self, new_index: ArrayLike, vertex_count: int | None = None) -> CurveNetwork:
        """The same curves on a mesh whose vertices are numbered otherwise.

        Args:
            new_index: (V,) whole numbers; vertex i becomes ``new_index[i]``. Vertices that lie on
                no curve may have any number, such as -1.
            vertex_count: Number of vertices of the other mesh; the same number unless given.

        Raises:
            CurveError: Not (V,) whole numbers, or two vertices of curves become one.
        """
        new = _as_indices(new_index, "the renumbering")
        if new.shape != (self.vertex_count,):
            raise CurveError(
                f"the renumbering has {new.size:,} entries; it needs one for each of the "
                f"{self.vertex_count:,} vertices"
            )
        return CurveNetwork(
            (Curve(new[curve.vertices], curve.closed, curve.name) for curve in self.curves),
            self.vertex_count if vertex_count is None else vertex_count,
        )

    def __len__(self) -> int:
        return len(self.curves)

    def __getitem__(self, index: Any) -> Any:
        return self.curves[index]

    def __iter__(self) -> Iterator[Curve]:
        return iter(self.curves)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, CurveNetwork):
            return NotImplemented
        return self.vertex_count == other.vertex_count and self.curves == other.curves

    def __hash__(self) -> int:
        return hash((self.curves, self.vertex_count))

    def __repr__(self) -> str:
        return f"CurveNetwork({len(self.curves):,} curves, {self.vertex_count:,} vertices)"


def require_curves_of(curves: object, vertex_count: int, mesh: str) -> None:
    """Check that curves are a `CurveNetwork` of a mesh of so many vertices."""
    if not isinstance(curves, CurveNetwork):
        raise CurveError(
            "curves must be a CurveNetwork, as em.extract_curves(mesh) finds it, found "
            + (repr(curves) if isinstance(curves, str) else type(curves).__name__)
        )
    if curves.vertex_count != vertex_count:
        raise CurveError(
            f"the curves belong to a mesh of {curves.vertex_count:,} vertices, {mesh} has "
            f"{vertex_count:,}: extract them from it"
        )


def _runs(curve: Curve, kept: NDArray[np.bool_]) -> list[NDArray[np.int32]]:
    """The runs of kept vertices; of a closed curve, counted from a vertex that is left out."""
    vertices = curve.vertices
    if curve.closed:
        gap = int(np.argmin(kept))
        vertices, kept = np.roll(vertices, -gap), np.roll(kept, -gap)
    changes = np.flatnonzero(np.diff(kept)) + 1
    pieces = np.split(vertices, changes)
    return pieces[0 if kept[0] else 1 :: 2]


def _as_indices(values: ArrayLike, title: str) -> NDArray[np.int32]:
    """A copy as (N,) int32."""
    try:
        own = np.array(values)
    except (TypeError, ValueError):
        own = np.array(None)
    if own.ndim != 1 or (own.size and own.dtype.kind not in "iu"):
        raise CurveError(f"{title} must be a list of whole numbers, found {own.dtype} {own.shape}")
    if own.size and int(own.max()) > np.iinfo(np.int32).max:
        raise CurveError(f"{title} names vertex {own.max()}, more than any mesh can have")
    return own.astype(np.int32)
