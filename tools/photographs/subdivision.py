"""Catmull-Clark subdivision as a matrix, so that a pose is refined by one product.

E. Catmull, J. Clark, Recursively generated B-spline surfaces on arbitrary topological meshes,
Computer-Aided Design 10 (1978). A border follows the cubic B-spline of the border alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from elastomorph.model.polygons import Polygons

__all__ = ["refined"]


def refined(faces: Polygons, count: int) -> tuple[sparse.csr_array, Polygons]:
    """The matrix (V', V) from old vertices to new ones, and the new quads.

    The first ``count`` new vertices are the old ones, moved; then come a point an edge and a point
    a face. Quads follow each other as the corners of the old faces do.
    """
    indices, following = faces.indices, faces.indices[faces.next_corners]
    ends = np.sort(np.stack([indices, following], axis=1), axis=1)
    edges, edge = np.unique(ends, axis=0, return_inverse=True)
    edge = edge.ravel()
    sides = np.bincount(edge, minlength=len(edges))
    border = sides != 2

    face_of, number = faces.corner_faces, np.arange(len(edges))
    to_face = _mean(face_of, indices, (len(faces), count))
    middle = _mean(np.repeat(number, 2), edges.ravel(), (len(edges), count))
    both_faces = _mean(edge, face_of, (len(edges), len(faces))) @ to_face
    share = np.where(border, 0, 0.5)
    to_edge = sparse.diags_array(1 - share) @ middle + sparse.diags_array(share) @ both_faces

    to_vertex = _vertices(
        edges, border, middle, _mean(indices, face_of, (count, len(faces))) @ to_face
    )
    matrix = sparse.csr_array(sparse.vstack([to_vertex, to_edge, to_face]))

    before = np.empty(len(indices), dtype=np.int64)
    before[faces.next_corners] = np.arange(len(indices))
    quads = [indices, count + edge, count + len(edges) + face_of, count + edge[before]]
    return matrix, Polygons.of(np.stack(quads, axis=1))


def _mean(
    row: NDArray[np.integer], column: NDArray[np.integer], shape: tuple[int, int]
) -> sparse.csr_array:
    """A matrix whose every row is the mean of its columns."""
    share = 1 / np.bincount(row, minlength=shape[0])[row]
    return sparse.csr_array((share, (row, column)), shape=shape)


def _vertices(
    edges: NDArray[np.integer],
    border: NDArray[np.bool_],
    middle: sparse.csr_array,
    faces_mean: sparse.csr_array,
) -> sparse.csr_array:
    """(F + 2E + (n - 3) v) / n inside; (v₋ + 6 v + v₊) / 8 at a border; others stay."""
    count = middle.shape[1]
    valence = np.bincount(edges.ravel(), minlength=count)
    at_border = np.bincount(edges[border].ravel(), minlength=count)
    inside = (at_border == 0) & (valence > 2)
    along = at_border == 2
    n = np.maximum(valence, 1)

    end = edges.ravel()
    edges_mean = _mean(end, np.repeat(np.arange(len(edges)), 2), (count, len(edges))) @ middle
    rim = edges[border]
    neighbours = _mean(rim.ravel(), rim[:, ::-1].ravel(), (count, count))
    stay = np.where(inside, (n - 3) / n, np.where(along, 0.75, 1.0))
    return sparse.csr_array(
        sparse.diags_array(inside / n) @ faces_mean
        + sparse.diags_array(inside * 2 / n) @ edges_mean
        + sparse.diags_array(np.where(along, 0.25, 0.0)) @ neighbours
        + sparse.diags_array(stay)
    )
