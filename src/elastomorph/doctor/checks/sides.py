"""Left and right targets: are there both, mirror images, and on the side their names say?

The symmetry of a neutral: its plane, and the mirror image of every vertex.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.checks.order import inside_out
from elastomorph.doctor.findings import Finding, finding, percent
from elastomorph.doctor.isomorphism import Parts, Relabelling, find_relabelling, reversed_polygons
from elastomorph.doctor.neutral import Neutral
from elastomorph.doctor.settings import SIDES
from elastomorph.errors import ParameterError
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


Pairs = Sequence[tuple[str, str]]

# How clearly a target must be on one side to be called left or right: the mean distance from the
# plane of what moves, signed over unsigned;
_CLEARLY = 0.8
# and how clearly one that moves the middle must go to one side: its mean motion, across the plane
# over all. Jaws and mouths of three rigs have 0.76 and more.
_ASIDE = 0.5
# From so many pairs on, what most of them do tells what is left.
_ENOUGH = 3
# A face looks along an axis if where what moves is, and where its surface looks, both have this
# cosine with it. Lids alone tell nothing: they and their lashes look up as much as ahead.
_FACES = 0.75


def parse_sides(text: str) -> tuple[tuple[str, str], ...]:
    """Sides from text such as ``_lft=_rgt,lf_=rt_``."""
    sides = []
    for part in text.split(","):
        left, _, right = (word.strip() for word in part.partition("="))
        if not left or not right or left == right or "=" in right:
            raise ParameterError(f"--pairs {part!r}: expected left=right, such as _lft=_rgt")
        sides.append((left, right))
    return tuple(sides)


def sided_pairs(
    names: Iterable[str], sides: Pairs = SIDES
) -> tuple[list[tuple[str, str]], list[str]]:
    """The pairs (left, right) among names of targets, and names that say a side without another.

    A name that ends in a side only by chance, as "cleft" does, is not counted among those.
    """
    known = dict.fromkeys(names)
    pairs: dict[str, tuple[str, str]] = {}
    alone = []
    for name in known:
        others = _others(name, sides)
        partner = next(((other, left) for other, left in others if other in known), None)
        if partner is not None:
            pair = (name, partner[0]) if partner[1] else (partner[0], name)
            pairs[pair[0]] = pair
        elif others:
            alone.append(name)
    return list(pairs.values()), alone


def _others(name: str, sides: Pairs) -> list[tuple[str, bool]]:
    """What the other side may be called, and whether this one is the left."""
    found = []
    for pair in sides:
        beginning = all(word.endswith("_") for word in pair)
        for mine, other, is_left in ((*pair, True), (*pair[::-1], False)):
            if len(name) <= len(mine):
                continue
            if beginning and name.startswith(mine):
                found.append((other + name[len(mine) :], is_left))
            elif not beginning and name.endswith(mine):
                found.append((name[: -len(mine)] + other, is_left))
    return found


def missing_sides(files: Mapping[str, str], sides: Pairs = SIDES) -> list[Finding]:
    """Targets (file by name) whose name says a side that has no other, where others have both."""
    pairs, alone = sided_pairs(files, sides)
    return [
        finding("missing-pair", files[name], "there is no target for the other side")
        for name in (alone if pairs else ())
    ]


def asymmetric_pairs(
    neutral: Neutral,
    targets: Mapping[str, Mesh],
    files: Mapping[str, str],
    mirror: Mirror,
    pairs: Pairs,
    faulty: Mapping[str, Sequence[int]] | None = None,
) -> list[Finding]:
    """Left targets whose motion is not the mirror image of that of the right one.

    Targets and files are by name; vertices that are ``faulty``, with a finding of their own, are
    left out.
    """
    found, limits = [], neutral.limits
    for names in pairs:
        mine, their = (neutral.moved(targets[name]) for name in names)
        known = _compared(mirror, *((faulty or {}).get(name, ()) for name in names))
        off = np.linalg.norm(mirror.reflected(their[mirror.partner[known]]) - mine[known], axis=1)
        most = float(max(np.linalg.norm(moved, axis=1).max() for moved in (mine, their)))
        worst = float(off.max(initial=0.0))
        if worst <= limits.asymmetry * most or worst <= limits.asymmetry_of_d * neutral.scale:
            continue
        vertex = int(known[int(off.argmax())])
        other = int(mirror.partner[vertex])
        message = (
            f"differs from the mirror image of {Path(files[names[1]]).name} by up to "
            f"{percent(worst / neutral.scale)} of D ({percent(worst / most)} of its motion) at "
            f"vertex {vertex} (there {other})"
        )
        found.append(
            finding(
                "asymmetric-pair",
                files[names[0]],
                message,
                vertices=(vertex, other),
                severity="warning" if worst > limits.one_sided * most else None,
            )
        )
    return found


def _compared(
    mirror: Mirror, faulty_left: Sequence[int], faulty_right: Sequence[int]
) -> NDArray[np.int64]:
    """The vertices of the left target that have a mirror image, neither of them faulty."""
    known = mirror.partner >= 0
    known[list(faulty_left)] = False
    known[np.isin(mirror.partner, list(faulty_right))] = False
    return np.flatnonzero(known)


def swapped_sides(
    neutral: Neutral,
    targets: Mapping[str, Mesh],
    files: Mapping[str, str],
    mirror: Mirror,
    pairs: Pairs,
) -> list[Finding]:
    """Pairs whose left is where the right of most others is, or of the face itself."""
    heights = mirror.heights(neutral.mesh.vertices)
    clear = []
    for names in pairs:
        moved = [neutral.moved(targets[name]) for name in names]
        place = _clear_side([_place(own, heights) for own in moved], _CLEARLY)
        way = _clear_side([_way(own, mirror.normal) for own in moved], _ASIDE)
        if place or way:
            clear.append((names, place or way, "" if place else "to "))
    if not clear:
        return []
    enough = len(clear) >= _ENOUGH
    usual = float(np.sign(sum(side for _, side, _ in clear))) if enough else 0.0
    which = "of the other right targets"
    if not usual:
        usual = _left_of(neutral, [targets[name] for pair in pairs for name in pair], mirror)
        which = "that is the right one of the face"
    others = [pair for pair in clear if pair[1] == -usual]
    if enough and 3 * len(others) > len(clear):
        return []
    return [
        finding(
            "swapped-sides",
            files[left],
            f"moves {to}the side {which}, and {Path(files[right]).name} {to}the left",
        )
        for (left, right), _, to in others
    ]


def _clear_side(sides: Sequence[float], least: float) -> float:
    """The sign of the left one, if both are clear and opposite; else 0."""
    left, right = sides
    clear = min(abs(left), abs(right)) > least and left * right < 0
    return float(np.sign(left)) if clear else 0.0


def _place(moved: NDArray[np.float64], heights: NDArray[np.float64]) -> float:
    """From -1, all that moves is on one side of the plane, to 1, all is on the other."""
    weights = np.linalg.norm(moved, axis=1)
    total = float(weights @ np.abs(heights))
    return float(weights @ heights) / total if total > 0 else 0.0


def _way(moved: NDArray[np.float64], normal: NDArray[np.float64]) -> float:
    """From -1, all moves one way across the plane, to 1, all moves the other way."""
    total = float(np.linalg.norm(moved, axis=1).sum())
    return float((moved @ normal).sum()) / total if total > 0 else 0.0


def _left_of(neutral: Neutral, targets: Sequence[Mesh], mirror: Mirror) -> float:
    """Which way along the normal of the plane the left of the character is: 1, -1, or 0 unknown.

    A face is on the side of the head that expressions move, and looks where that surface does. Up
    is y, or z where it looks along y; left is up × front.
    """
    mesh = neutral.mesh
    points, triangles = mesh.vertices, mesh.faces.triangles()
    moved = np.asarray(sum(np.linalg.norm(neutral.moved(own), axis=1) for own in targets))
    a, b, c = (points[triangles[:, i]] for i in range(3))
    outwards = np.cross(b - a, c - a)
    outwards[np.repeat(inside_out(mesh), mesh.faces.sizes - 2)] *= -1.0
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    ways = []
    for way in (moved @ (points - middle), moved[triangles].mean(axis=1) @ outwards):
        across = way - (way @ mirror.normal) * mirror.normal
        ways.append(across / max(float(np.linalg.norm(across)), 1e-300))
    axis = int(np.abs(ways[0]).argmax())
    front = np.sign(ways[0][axis]) * np.eye(3)[axis]
    if min(float(way @ front) for way in ways) < _FACES:
        return 0.0
    up = np.eye(3)[2 if axis == 1 else 1]
    return float(np.sign(np.cross(up, front) @ mirror.normal))
