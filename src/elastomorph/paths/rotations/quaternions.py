"""Many rotations at once, nearest to covariances, and those of parts that turn as a whole."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

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
