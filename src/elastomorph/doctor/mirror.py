"""The symmetry of a neutral: its plane, and the mirror image of every vertex."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.isomorphism.parts import Parts
from elastomorph.doctor.isomorphism.polygons import reversed_polygons
from elastomorph.doctor.isomorphism.search import Relabelling, find_relabelling
from elastomorph.model.mesh import Mesh

# How far the mirror image may be from the neutral, as fractions of D: faces are not symmetric,
# but a wrong pairing is off by a good part of the head.
_IMAGE_OFF = 0.05
_NEAREST_OFF = 1e-3
_PAIRED = 0.95
_SAMPLE = 2000


@dataclass(frozen=True, eq=False)
class Mirror:
    """The mirror images of vertices."""

    normal: NDArray[np.float64]  # (3,) unit, of the plane
    distance: float  # of the plane from the origin, along the normal
    # (V,) the vertex on the other side; itself on the plane, -1 where none is known
    partner: NDArray[np.int64]

    def reflected(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) mirror images of directions."""
        return np.asarray(vectors - 2.0 * np.outer(vectors @ self.normal, self.normal))

    def heights(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N,) distance from the plane, signed."""
        return np.asarray(points @ self.normal - self.distance)


def find_mirror(neutral: Mesh) -> Mirror | None:
    """The plane of symmetry and which vertex is the mirror image of which.

    By connectivity where the polygons are symmetric, so that an asymmetric face does not matter;
    otherwise by position, where nearly all vertices have a mirror image. None where the neutral is
    not symmetric enough to tell.
    """
    points, scale = neutral.vertices, neutral.diameter
    if not scale or not len(neutral.faces):
        return None
    axis = _likely_axis(points)
    image = _flipped(points, axis)
    ours = Parts(neutral)
    backwards = reversed_polygons(neutral.faces)
    theirs = Parts(neutral.with_vertices(image), faces=backwards, rounds=ours.colouring.rounds)
    found = find_relabelling(ours, theirs)
    if isinstance(found, Relabelling):
        mirror = _with_plane(points, found.new_index)
        image_at = points - 2.0 * np.outer(mirror.heights(points), mirror.normal)
        off = np.linalg.norm(points[found.new_index] - image_at, axis=1)
        if np.sqrt((off**2).mean()) <= _IMAGE_OFF * scale:
            # Among parts alike, such as teeth, a few may be taken for each other.
            partner = np.where(off <= _IMAGE_OFF * scale, mirror.partner, -1)
            return replace(mirror, partner=partner)
    return _by_position(points, image, scale)


def _flipped(points: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    """The mirror image of points within their own bounding box."""
    image = points.copy()
    image[:, axis] = points[:, axis].min() + points[:, axis].max() - image[:, axis]
    return image


def _likely_axis(points: NDArray[np.float64]) -> int:
    """The axis along which the points are most like their mirror image."""
    from scipy.spatial import cKDTree

    tree, step = cKDTree(points), -(-len(points) // _SAMPLE)
    off = [np.mean(tree.query(_flipped(points, axis)[::step])[0]) for axis in range(3)]
    return int(np.argmin(off))


def _by_position(
    points: NDArray[np.float64], image: NDArray[np.float64], scale: float
) -> Mirror | None:
    from scipy.spatial import cKDTree

    off, nearest = map(np.asarray, cKDTree(points).query(image))
    mutual = (nearest[nearest] == np.arange(len(points))) & (off <= _NEAREST_OFF * scale)
    if mutual.mean() < _PAIRED:
        return None
    return _with_plane(points, np.where(mutual, nearest, -1))


def _with_plane(points: NDArray[np.float64], partner: NDArray[np.int64]) -> Mirror:
    """The plane nearest to the middles of all pairs, across their connecting lines."""
    known = np.flatnonzero(partner >= 0)
    there = points[partner[known]]
    across = points[known] - there
    normal = np.linalg.svd(across, full_matrices=False)[2][0]
    if normal[int(np.argmax(np.abs(normal)))] < 0:
        normal = -normal
    middle = ((points[known] + there) / 2.0).mean(axis=0)
    return Mirror(normal, float(middle @ normal), partner.astype(np.int64))
