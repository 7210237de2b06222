"""How the surface around each vertex turns from one mesh to another, smoothed over a few rings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.geometry import connected_parts
from elastomorph.paths.rotations.bends import EdgeBend

if TYPE_CHECKING:
    from scipy.sparse import csr_array


# Many rotations at once, nearest to covariances, and those of parts that turn as a whole.

# Prior for "no turn", as a part of the covariance: it decides only what the edges leave open.
_PRIOR = 1e-10
# Newton steps to the largest eigenvalue, how far the last of them may go, and the least product of
# its distances to the others; covariances have size 1.
_NEWTON = 12
_REACHED = 1e-14
_SEPARATED = 1e-2
# A rotation vector may be longer than half a turn, to stay beside its neighbours, up to here.
_LONGEST = 4.0 * np.pi / 3.0


def nearest_quaternions(covariances: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotations R that maximise tr(R·C), never a reflection: Horn, JOSA A 4(4), 1987.

    (N, 4) unit quaternions (w, x, y, z), w ≥ 0, for (N, 3, 3) C = Σ w e₀ e₁ᵀ of vectors before and
    after. Where a covariance leaves a turn open (all on one line, or none), it is the smallest.
    """
    c = covariances
    size = np.sqrt(np.einsum("nij,nij->n", c, c))
    scaled = c / np.where(size > 0, size, 1.0)[:, None, None]
    form = np.empty((len(c), 4, 4))
    trace = np.einsum("nii->n", scaled)
    form[:, 0, 0] = trace + 3.0 * _PRIOR
    form[:, 1:, 1:] = scaled + scaled.transpose(0, 2, 1)
    diagonal = np.arange(1, 4)
    form[:, diagonal, diagonal] -= trace[:, None] + _PRIOR
    for row, (i, j) in enumerate(((1, 2), (2, 0), (0, 1)), start=1):
        form[:, 0, row] = form[:, row, 0] = scaled[:, i, j] - scaled[:, j, i]
    quaternions = _top_eigenvectors(form)
    quaternions[quaternions[:, 0] < 0] *= -1.0
    return quaternions


def _top_eigenvectors(form: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 4) unit eigenvectors K v = λv of the largest eigenvalues of (N, 4, 4) forms of trace 0.

    λ is the largest root of λ⁴ + aλ² + bλ + c, to which Newton's method falls from above
    (Theobald, Acta Cryst. A61, 2005), and K³ + λK² + (λ² + a)K + (λ³ + aλ + b) = 4-fold vvᵀ times
    the product of the distances to the other eigenvalues. Where that is small, or λ is not reached,
    all eigenvectors are found.
    """
    squared = form @ form
    second, fourth = (np.einsum("nij,nij->n", m, m) for m in (form, squared))
    third = np.einsum("nij,nij->n", form, squared)
    a, b, c = -second / 2.0, -third / 3.0, second**2 / 8.0 - fourth / 4.0
    top = np.sqrt(0.75 * second)
    for _ in range(_NEWTON):
        slope = 4.0 * top**3 + 2.0 * a * top + b
        value = ((top**2 + a) * top + b) * top + c
        step = np.divide(value, slope, out=np.zeros_like(top), where=slope > 0)
        top -= step
    slope = 4.0 * top**3 + 2.0 * a * top + b
    linear, constant = top**2 + a, (top**2 + a) * top + b
    projector = form @ squared + top[:, None, None] * squared + linear[:, None, None] * form
    diagonal = np.arange(4)
    projector[:, diagonal, diagonal] += constant[:, None]
    best = projector[:, diagonal, diagonal].argmax(axis=1)
    vectors: NDArray[np.float64] = projector[np.arange(len(form)), best]
    vectors /= np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(float).tiny)
    unsure = (slope < _SEPARATED) | (np.abs(step) > _REACHED)
    vectors[unsure] = np.linalg.eigh(form[unsure])[1][:, :, -1]
    return np.asarray(vectors)


def rotated(quaternions: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) points turned by (N, 4) unit quaternions."""
    w, axis = quaternions[:, :1], quaternions[:, 1:]
    across = np.cross(axis, points)
    return points + 2.0 * (w * across + np.cross(axis, across))


def aligned_with(
    quaternions: NDArray[np.float64], beside: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The same rotations by the way round that others take.

    A quaternion and its negative lead to the same place, by a turn of θ and by one of 2π - θ the
    other way. Close to half a turn, which of them is shorter says nothing: the way of the others
    is taken, unless it is longer than 240°. ``beside`` is (N, 4) or (1, 4), of any length.
    """
    across = np.sum(quaternions * beside, axis=1) < 0
    across &= near_half_turn(quaternions)
    return np.where(across[:, None], -quaternions, quaternions)


def near_half_turn(quaternions: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) rotations that are at most 240° long by either way round."""
    return np.asarray(np.abs(quaternions[:, 0]) <= -np.cos(_LONGEST / 2.0))


def rotation_vectors(quaternions: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) axis times angle, radians, of (N, 4) rotations; longer than π where w < 0."""
    sine = np.linalg.norm(quaternions[:, 1:], axis=1)
    angle = 2.0 * np.arctan2(sine, quaternions[:, 0])
    # angle/sine → 2 for small turns, where (x, y, z) is half the rotation vector.
    factor = np.divide(angle, sine, out=np.full_like(sine, 2.0), where=sine > 0)
    return np.asarray(quaternions[:, 1:] * factor[:, None])


# How far a part may be from a rigid motion: as a fraction of D, so that noise of a scan does not
# matter, and of its own radius, so that a small part is not called rigid for being small.
_RIGID_OF_DIAMETER = 1e-3
_RIGID_OF_RADIUS = 0.02
# How far from an affine map, as a fraction of its radius: the rounding of a text file.
_AFFINE = 1e-5
# Parts thinner than this fraction of their length are flat: what happens across is not known.
_FLAT = 1e-3
# What is smaller than this fraction of its size at the other end is a point there, or a line: what
# is left of it is rounding or noise, and says nothing about a turn.
_POINT = 1e-3


def vanishes(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) which sizes shrink to next to nothing, or grow from it."""
    return np.asarray((after < _POINT * before) | (before < _POINT * after))


def common_turns(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    parts: Sequence[NDArray[np.int64]],
    diameter: float,
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The one rotation of each part that turns as a whole.

    A part does so if a rigid motion carries it, up to a small residual, or an affine map: the
    rotation is then the polar factor of the map, none at all for a symmetric stretch. A part that
    shrinks to a point, or grows from one, does so without a turn.

    (P, 4) unit quaternions (w, x, y, z) and (P,) whether the part turns by it as a whole.
    """
    if not parts:
        return np.zeros((0, 4)), np.zeros(0, dtype=bool)
    sizes = np.array([len(part) for part in parts])
    firsts, part_of = np.cumsum(sizes) - sizes, np.repeat(np.arange(len(parts)), sizes)
    vertices = np.concatenate(parts)

    def centred(points: NDArray[np.float64]) -> NDArray[np.float64]:
        mine = points[vertices]
        means = np.add.reduceat(mine, firsts, axis=0) / sizes[:, None]
        return np.asarray(mine - means[part_of])

    def longest(offsets: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.maximum.reduceat(np.linalg.norm(offsets, axis=1), firsts))

    before, after = centred(start), centred(end)
    radius = longest(before)
    gone = vanishes(radius, longest(after))
    unit = np.where(radius > 0, radius, 1.0)
    before, after = before / unit[part_of, None], after / unit[part_of, None]
    own, joint = (
        np.add.reduceat(before[:, :, None] * other[:, None, :], firsts) for other in (before, after)
    )
    affine, rank = _affine(own, joint)
    missed = longest(np.einsum("vi,vij->vj", before, affine[part_of]) - after)
    is_affine = (missed <= _AFFINE) | (radius == 0)
    turns = nearest_quaternions(np.where(is_affine[:, None, None], _of_lines(affine), joint))
    turns[gone | (radius == 0)] = 1.0, 0.0, 0.0, 0.0
    residual = radius * longest(rotated(turns[part_of], before) - after)
    allowed = np.minimum(_RIGID_OF_DIAMETER * diameter, _RIGID_OF_RADIUS * radius)
    return turns, gone | is_affine | ((rank >= 2) & (residual <= allowed))


def _of_lines(maps: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P, 3, 3) maps without what is left across where they lead to a line: it is noise."""
    left, sizes, right = np.linalg.svd(maps)
    to_lines = sizes[:, 1] < _POINT
    lines = left[:, :, :1] * sizes[:, None, :1] @ right[:, :1]
    return np.where(to_lines[:, None, None], lines, maps)


def _affine(
    own: NDArray[np.float64], joint: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """(P, 3, 3) the maps x → xA nearest to the motions, nothing across flat parts, and the ranks.

    `own` is Σ x₀ᵀ x₀, `joint` Σ x₀ᵀ x₁.
    """
    squares, axes = np.linalg.eigh(own)
    known = squares > _FLAT**2 * squares[:, -1:]
    inverse = np.divide(1.0, squares, out=np.zeros_like(squares), where=known)
    return (axes * inverse[:, None, :]) @ (axes.transpose(0, 2, 1) @ joint), known.sum(axis=1)


# The change of length, as a logarithm, at which an edge counts half. Edges between lips or between
# gums are stretched many times over; what they turn by means nothing.
_HALF_TRUSTED = 0.3
# The part of the change of edges that a turn may leave: chins with markers leave 5 to 11 %, brows
# 40 to 90 %, lids more than there was.
_UNEXPLAINED = 0.25
# Rounds in which vertices close to half a turn take the way round of their neighbours.
_ALIGNMENTS = 8


@dataclass(frozen=True, eq=False)
class Neighbourhoods:
    """The (E, 2) edges around every vertex of a mesh, found once for all targets."""

    edges: NDArray[np.integer]
    at_vertex: csr_array  # (V, E) ones where an edge ends at a vertex
    adjacency: csr_array  # (V, V) ones where an edge joins two vertices
    parts: list[NDArray[np.int64]]  # vertices of each connected component

    @classmethod
    def of(cls, count: int, edges: NDArray[np.integer]) -> Neighbourhoods:
        """Of V vertices, with and without edges, and (E, 2) edges, each once."""
        from scipy.sparse import coo_array, csr_array

        numbers, ends = np.tile(np.arange(len(edges)), 2), edges.T.ravel()
        one = np.ones(ends.size)
        at_vertex = csr_array(coo_array((one, (ends, numbers)), shape=(count, len(edges))))
        others = edges[:, ::-1].T.ravel()
        adjacency = csr_array(coo_array((one, (ends, others)), shape=(count, count)))
        return cls(edges, at_vertex, adjacency, connected_parts(count, edges))

    def within(self, vertices: NDArray[np.bool_], rings: int) -> NDArray[np.bool_]:
        """(V,) the vertices and all that are up to a number of edges away."""
        reached = vertices.astype(np.float64)
        for _ in range(rings):
            reached = np.minimum(1.0, reached + self.adjacency @ reached)
        return np.asarray(reached > 0)


@dataclass(frozen=True, eq=False)
class VertexRotations:
    """A rotation at each vertex: (V, 4) unit (w, x, y, z), where w < 0 is a turn by more than π.

    ``whole`` are the vertices of each component that moves and turns as a whole, by one rotation.
    ``straight`` are those that have no rotation, (V,) bool: around them everything shrinks to a
    point, or grows from one.
    """

    quaternions: NDArray[np.float64]
    whole: tuple[NDArray[np.int64], ...]
    straight: NDArray[np.bool_]

    @cached_property
    def vectors(self) -> NDArray[np.float64]:
        """(V, 3) axis times angle, radians; zero where nothing is known."""
        return rotation_vectors(self.quaternions)

    def of_edges(self, ends: NDArray[np.integer]) -> NDArray[np.float64]:
        """(E, 3) rotation vector halfway between those of (E, 2) vertices."""
        first, second = self.quaternions[ends[:, 0]], self.quaternions[ends[:, 1]]
        opposed = np.sum(first * second, axis=1) < 0
        mean = first + np.where(opposed[:, None], -second, second)
        return rotation_vectors(mean / np.linalg.norm(mean, axis=1, keepdims=True))

    def without(self, vertices: NDArray[np.bool_]) -> VertexRotations:
        """The same with some more vertices that go straight: whole components."""
        quaternions = np.where(vertices[:, None], [1.0, 0.0, 0.0, 0.0], self.quaternions)
        return VertexRotations(quaternions, self.whole, self.straight | vertices)

    def where_edges_turn(
        self, start: NDArray[np.float64], end: NDArray[np.float64], around: Neighbourhoods
    ) -> VertexRotations:
        """No rotation in components whose edges hardly turn by theirs.

        A few edges on a curve have some rotation even where one marker moves alone. It means
        something if it explains most of how they change: Σ ‖R e₀ - e₁‖² ≤ ¼ Σ ‖e₀ - e₁‖².
        """
        before, after = (p[around.edges[:, 1]] - p[around.edges[:, 0]] for p in (start, end))
        turned = EdgeBend.of(before, after, self.of_edges(around.edges)).missed(before, after)
        part_of = np.empty(len(start), dtype=np.int64)
        for number, part in enumerate(around.parts):
            part_of[part] = number
        missed, changed = (
            np.bincount(
                part_of[around.edges[:, 0]], np.einsum("ei,ei->e", off, off), len(around.parts)
            )
            for off in (turned, before - after)
        )
        still = (missed > _UNEXPLAINED * changed)[part_of]
        quaternions = np.where(still[:, None], [1.0, 0.0, 0.0, 0.0], self.quaternions)
        return replace(self, quaternions=quaternions)


def vertex_rotations(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    around: Neighbourhoods,
    *,
    diameter: float,
    rings: int,
) -> VertexRotations:
    """The smoothed local rotation at each vertex.

    It is the polar factor of the covariance Σ w e₀ e₁ᵀ of the edges e₀ → e₁ around the vertex,
    summed over its rings with binomial weights: covariances are averaged, not rotations, so long
    edges count more than short ones and no angle has to be unwrapped. Edges that become longer or
    shorter by a factor s ≥ 1 count w = s⁻¹/(1 + (log s/0.3)²). Components that turn as a whole
    (`common_turns`) have one rotation; where all edges at a vertex, or a whole component, shrink to
    under a thousandth of their size, or grow from it, there is none.
    """
    scale = diameter or 1.0
    before = (start[around.edges[:, 1]] - start[around.edges[:, 0]]) / scale
    after = (end[around.edges[:, 1]] - end[around.edges[:, 0]]) / scale
    products = np.einsum("ei,ej->eij", before, after).reshape(-1, 9)
    covariances = around.at_vertex @ (products * _trust(before, after)[:, None])
    most = nearest_quaternions(covariances.sum(axis=0).reshape(1, 3, 3))
    for _ in range(rings):
        covariances = covariances + around.adjacency @ covariances
    moving = (start != end).any(axis=1)
    near = around.within(moving, rings + 1)
    # Edges that stay as they are turn by nothing.
    quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (len(start), 1))
    quaternions[near] = nearest_quaternions(covariances[near].reshape(-1, 3, 3))
    # A mesh that hardly turns as a whole has no say about its parts.
    turns_far = bool(most[0, 0] < np.cos(np.pi / 4))
    if turns_far:
        quaternions = aligned_with(quaternions, most)
    for _ in range(_ALIGNMENTS):
        if not near_half_turn(quaternions).any():
            break
        quaternions = aligned_with(quaternions, around.adjacency @ quaternions)
    parts = [part for part in around.parts if moving[part].any()]
    turns, as_one = common_turns(start, end, parts, diameter)
    if turns_far:
        turns = aligned_with(turns, most)
    whole = [part for part, one in zip(parts, as_one, strict=True) if one]
    straight = vanishes(*(np.sqrt(around.at_vertex @ (e * e).sum(axis=1)) for e in (before, after)))
    # What such a vertex is joined to is at the same point.
    straight = around.within(straight, 1)
    for part, turn in zip(whole, turns[as_one], strict=True):
        quaternions[part] = turn
        straight[part] = straight[part].all()
    quaternions[straight] = 1.0, 0.0, 0.0, 0.0
    return VertexRotations(quaternions, tuple(whole), straight)


def _trust(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """(E,) weight of each edge: 1 where it keeps its length, 0 where it appears or vanishes."""
    lengths = np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1)
    real = (lengths[0] > 0) & (lengths[1] > 0)
    weights = np.zeros(len(before))
    stretch = np.abs(np.log(lengths[1][real]) - np.log(lengths[0][real]))
    # s⁻¹: a covariance grows with both lengths, but an edge should not count for being torn.
    weights[real] = np.exp(-stretch) / (1.0 + (stretch / _HALF_TRUSTED) ** 2)
    return weights
