"""Vertices at one place, as one while paths are made.

A vertex has one texture coordinate and one normal in glTF, so where a texture or a smooth surface
ends, there are two at the same place; other files have them where lashes grow out of lids. To a
surface that is a cut: on both sides of it everything turns by itself, and what hangs on the surface
there only is torn loose. Vertices that are at the same place in the neutral and in every target are
one here. The mesh of the rig is never changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError
from elastomorph.model.geometry import component_of, moved_extent
from elastomorph.model.mesh import FaceLabels, Mesh, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons
from elastomorph.paths.method import Prepared

# Single precision and products of matrices round; in two of a million million cases this is also
# the border of a cell, and a seam stays: it is no fraction that anyone would model with.
_CELL = 1.1180339887e-6
# How far a path may be off at the copies of a vertex along seams, as a fraction of the diameter.
_ALIKE = 1e-5


@dataclass(frozen=True, eq=False)
class Welding:
    """The parts of a mesh that move, without seams.

    Attributes:
        neutral: The mesh, its vertices in the order of their first ones.
        first: (W,) int64, the vertex of the whole that each vertex is, the first of several.
        place: (V,) int64, the vertex that each vertex of the whole is, -1 where nothing moves.
    """

    neutral: Mesh
    first: NDArray[np.int64]
    place: NDArray[np.int64]

    @classmethod
    def of(
        cls,
        neutral: Mesh,
        targets: Sequence[NDArray[np.float64]],
        *,
        weld: bool | None = None,
        still: bool = False,
    ) -> Welding:
        """The connected parts of a neutral that (V, 3) targets move.

        Args:
            neutral: The whole.
            targets: All shapes.
            weld: Whether vertices at one place in all of them become one; by default where the
                format of the file splits vertices.
            still: Whether the parts that stay are kept too.
        """
        if weld is None:
            weld = neutral.source is not None and neutral.source.split
        vertices = neutral.vertices
        moves = np.full(len(vertices), still)
        for target in targets:
            moves |= (target != vertices).any(axis=1)
        first = everywhere = np.arange(len(vertices))
        if weld:
            # What is at one place is soon found, and among that what is one.
            touching = _same(vertices, [], everywhere)
            several = np.bincount(touching)[touching] > 1
            first = everywhere.copy()
            first[several] = first[several][_same(vertices, targets, everywhere[several])]
        # A surface goes on across its seams.
        kept = _hanging_on(neutral, everywhere, first, moves)
        first, at = np.unique(first[kept], return_inverse=True)
        place = np.full(len(vertices), -1, dtype=np.int64)
        place[kept] = at
        return cls(_restricted(neutral, first, place), first, place)

    @property
    def joins(self) -> bool:
        """Whether there were several at one place."""
        return len(self.first) < int((self.place >= 0).sum())

    def mesh(self, whole: Mesh) -> Mesh:
        """A mesh of the whole, as the welded one."""
        return self.neutral.with_vertices(whole.vertices[self.first])

    def fields(self, welded: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., V, 3) of the whole, from (..., W, 3); zero where nothing moves."""
        padded = np.concatenate([welded, np.zeros_like(welded[..., :1, :])], axis=-2)
        return np.asarray(padded[..., self.place, :])

    def vertices(self, whole: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(W,) those that are one of (V,) vertices of the whole."""
        found = np.zeros(len(self.first), dtype=bool)
        found[self.place[whole & (self.place >= 0)]] = True
        return found

    def around(self, neutral: Mesh, to: Prepared) -> Prepared:
        """From a target of the whole to its path, by what makes that of the welded one."""

        def path(target: Mesh) -> Morph:
            require_same_topology(neutral, target)
            return self.morph(neutral, target, to(self.mesh(target)))

        return path

    def morph(self, neutral: Mesh, target: Mesh, path: Morph) -> Morph:
        """The path of the whole that is this one where vertices are welded."""
        scale = self.neutral.diameter / (neutral.diameter or 1.0)
        return replace(
            path,
            neutral=neutral,
            target=target,
            bends=self.fields(path.bends),
            bake_error=path.bake_error * scale,
        )

    def welded(self, path: Morph) -> Morph:
        """The path of the whole, where its vertices are welded.

        Raises:
            MeshError: It differs from one side of a seam to the other.
        """
        diameter = path.neutral.diameter
        bends = path.bends[:, self.first]
        for whole, own in zip(path.bends, self.fields(bends), strict=True):
            if np.abs(whole - own).max(initial=0.0) > _ALIKE * diameter:
                raise MeshError("a path differs from one side of a seam to the other")
        return replace(
            path,
            neutral=self.neutral,
            target=self.mesh(path.target),
            bends=bends,
            bake_error=path.bake_error * diameter / (self.neutral.diameter or 1.0),
        )


def _hanging_on(
    neutral: Mesh, these: NDArray[np.int64], first: NDArray[np.int64], moves: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Rising vertices of the parts that move, where these are one with their first ones."""
    edges = np.concatenate([neutral.edges, np.column_stack([these, first])])
    part = component_of(len(neutral.vertices), edges)
    return np.flatnonzero(np.isin(part, part[moves]))


def _same(
    vertices: NDArray[np.float64], targets: Sequence[NDArray[np.float64]], kept: NDArray[np.int64]
) -> NDArray[np.int64]:
    """(N,) for each kept vertex the first kept one that is at its place in all shapes."""
    number = np.zeros(len(kept), dtype=np.int64)
    if not len(kept):
        return number
    here = vertices[kept]
    scale = moved_extent(vertices, targets) or float(np.ptp(here, axis=0).max())
    for shape in (here, *(target[kept] - here for target in targets)):
        cells = np.round(shape / (_CELL * (scale or 1.0)))
        rows = np.column_stack([number, cells])
        order = np.lexsort(rows.T)
        new = np.append(True, (np.diff(rows[order], axis=0) != 0).any(axis=1))
        # Numbers of equal rows are those of their first vertex, so that the order stays.
        label = np.empty(len(kept), dtype=np.int64)
        label[order] = np.cumsum(new) - 1
        least = np.full(int(new.sum()), len(kept), dtype=np.int64)
        np.minimum.at(least, label, np.arange(len(kept)))
        number = least[label]
    return number


def _restricted(neutral: Mesh, first: NDArray[np.int64], place: NDArray[np.int64]) -> Mesh:
    """The polygons between welded vertices; corners that are now one are written once."""
    faces = neutral.faces
    corners = place[faces.indices]
    of_face = np.repeat(np.arange(len(faces)), faces.sizes)
    kept = (corners >= 0) & (corners != corners[faces.next_corners])
    sizes = np.bincount(of_face[kept], minlength=len(faces))
    whole = np.flatnonzero(sizes >= 3)
    kept &= np.isin(of_face, whole)
    polygons = Polygons(
        corners[kept].astype(np.int32), np.concatenate([[0], np.cumsum(sizes[whole])])
    )
    materials, groups = (
        None if own is None else FaceLabels(own.names, own.of_face[whole])
        for own in (neutral.materials, neutral.groups)
    )
    source = None if neutral.source is None else replace(neutral.source, split=False)
    return Mesh(
        neutral.vertices[first], polygons, materials=materials, groups=groups, source=source
    )
