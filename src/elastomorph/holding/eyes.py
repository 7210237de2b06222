"""The eyes of a rig, found in its shapes: the slit between the lids, the ball and what is shut."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.geometry import component_of, connected_parts, neighbours, sides_of
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.surface import triangulate
from elastomorph.rig import Rig
from elastomorph.rig.naming import shape_of

Points = NDArray[np.float64]
Vertices = NDArray[np.int64]

COLUMNS = 25
"""Places along the slit at which it is measured."""
_STRONG = 0.3
"""Part of its farthest way that a blink moves what is surely lid."""
_MOVED = 0.05
"""Part of its farthest way that a blink moves skin, and does not move an eyeball."""
_OPEN = 0.25
"""Part of its widest place that the slit is open where it is measured: corners are always shut."""
# An eyeball is a sphere for most of its vertices, these within this part of its radius, and lids
# lie within half a radius of it. Rings of few vertices fit any sphere.
_SPHERE = 0.7
_BALL = 64
_ROUND = 0.06
_OVER_BALL = 0.5
_HALF = 1.5
"""Radii across which even half a ball is wide; a strand of hair fits a sphere too."""
_SEEN = 2.0
"""Radii of the ball round its centre within which skin may cover the eye."""
_INSIDE = 0.85
"""Radii of the ball from which on skin covers it: a socket is closed behind some eyes."""
_NEAR = 1.4
"""Radii round its centre within which margins lie: a nose may cover part of the slit as well."""
_STEP = 2e-3
"""Radians beside an edge at which nothing may cover the eye where it borders the slit."""
_SLOPE = 0.5
"""Least upright part of the unit normal of an edge of a margin: those across its ends are none."""
_CLOSING = (0.0, 0.3, 0.6, 0.9)
"""Weights of a blink at which edges that border the slit are the margins of the lids."""

_BLINKS = {
    "eyeBlinkLeft", "eyeBlinkRight", "blinkLeft", "blinkRight", "Fcl_EYE_Close_L",
    "Fcl_EYE_Close_R", "eyeBlink", "blink", "Fcl_EYE_Close",
}  # fmt: skip
_BOTH = {"eyeBlink", "blink", "Fcl_EYE_Close"}


@dataclass(frozen=True, eq=False)
class Eye:
    """The slit between two lids, seen from the middle of the eyeball.

    A place is a longitude and a latitude in radians: along the slit, and up where a blink comes
    from. A height is a latitude times the radius.

    Attributes:
        name: The slider that blinks.
        centre: (3,) of the eyeball, or of where one would be.
        radius: Of the sphere that fits the white of the eye.
        ball: Whether there is one, vertices of which nothing may sink into.
        axes: (3, 3) rows: to the side, up, and forward.
        vertices: (N,) all that the blink moves and the skin round the eye, rising.
        skin: (N,) bool, which of them are skin round the eyeball.
        upper: (E, 2) edges that hold the margin of the upper lid, of numbers in `vertices`.
        lower: (E, 2) of the lower one.
        columns: (K,) longitudes at which the slit is measured.
        open: (K,) its heights in the neutral.
    """

    name: str
    centre: Points
    radius: float
    ball: bool
    axes: Points
    vertices: Vertices
    skin: NDArray[np.bool_]
    upper: Vertices
    lower: Vertices
    columns: Points
    open: Points

    def places(self, positions: Points) -> tuple[Points, Points, Points]:
        """(…,) longitude, latitude and distance from the centre of (…, 3) positions."""
        side, up, forward = np.moveaxis((positions - self.centre) @ self.axes.T, -1, 0)
        distance = np.sqrt(side**2 + up**2 + forward**2)
        return np.arctan2(side, forward), np.arctan2(up, np.hypot(side, forward)), distance

    def at(self, longitude: Points, latitude: Points, distance: Points) -> Points:
        """(…, 3) positions at places."""
        level = np.cos(latitude)
        seen = np.stack(
            [level * np.sin(longitude), np.sin(latitude), level * np.cos(longitude)], axis=-1
        )
        return np.asarray(self.centre + distance[..., None] * seen @ self.axes)

    def margins(self, positions: Points) -> tuple[Points, Points]:
        """(S, K) latitudes of the upper lid's margin and of the lower one's in (S, N, 3) faces."""
        longitude, latitude, _ = self.places(positions)
        upper = -_highest(longitude, -latitude, self.upper, self.columns)
        return upper, _highest(longitude, latitude, self.lower, self.columns)

    def slit(self, positions: Points) -> Points:
        """(S, K) height by which lids are apart in (S, N, 3) faces, negative past each other."""
        upper, lower = self.margins(positions)
        return np.asarray((upper - lower) * self.radius)


def _highest(across: Points, up: Points, edges: Vertices, columns: Points) -> Points:
    """(S, K) the highest point of edges at each column; (S, N) places across and up."""
    start, stop = across[:, edges[:, 0], None], across[:, edges[:, 1], None]
    least, most = np.minimum(start, stop).min(axis=1), np.maximum(start, stop).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = (np.clip(columns, least, most)[:, None] - start) / (stop - start)
        there = (1 - part) * up[:, edges[:, 0], None] + part * up[:, edges[:, 1], None]
    return np.asarray(np.where((part >= 0) & (part <= 1), there, -np.inf).max(axis=1))


def part_rig(rig: Rig, vertices: Vertices) -> Rig:
    """The rig of some vertices, without polygons."""
    neutral = Mesh(rig.neutral.vertices[vertices])
    morphs = {}
    for name, morph in rig.morphs.items():
        target, bends = Mesh(morph.target.vertices[vertices]), morph.bends[:, vertices]
        morphs[name] = replace(morph, neutral=neutral, target=target, bends=bends)
    return Rig(neutral, morphs, correctives=rig.sliders.correctives)


def faces_of(rig: Rig, weights: Points) -> Points:
    """(S, N, 3) float64 faces of (S, J) weights."""
    return np.asarray(rig.batch(weights, dtype=np.float64), dtype=np.float64)


def blinks_of(names: Sequence[str]) -> dict[str, bool]:
    """The sliders that shut an eye, and whether both: those of one eye where there are any."""
    found: dict[str, bool] = {}
    for name in names:
        shape = shape_of(name) or next((b for b in _BLINKS if name.endswith(b)), None)
        if shape in _BLINKS:
            found[name] = shape in _BOTH
    return {name: both for name, both in found.items() if not both} or found


def find_eyes(rig: Rig) -> Iterator[Eye | str]:
    """Each eye that a slider shuts, or why it is left out.

    Raises:
        ParameterError: The rig has no slider that blinks, or no polygons.
    """
    if not len(rig.neutral.faces):
        raise ParameterError("lids are found in the polygons of a rig, which has none")
    blinks = blinks_of(rig.names)
    if not blinks:
        raise ParameterError(
            "the rig has no slider that shuts an eye: expected eyeBlinkLeft and eyeBlinkRight, "
            f"blink or Fcl_EYE_Close, in any spelling, found {', '.join(rig.names[:8])}, …"
        )
    scene = _Scene.of(rig)
    for name, both in blinks.items():
        yield from scene.eyes(rig[name], name, both)


@dataclass(frozen=True, eq=False)
class _Scene:
    """The mesh of a rig with vertices at one place joined, and its parts that may be eyeballs."""

    rig: Rig
    triangles: Vertices  # (T, 3)
    parts: list[Vertices]

    @classmethod
    def of(cls, rig: Rig) -> _Scene:
        corners = triangulate(rig.neutral)[0].astype(np.int64)
        triangles = joined(rig.neutral.vertices, corners)
        # A seam is an edge of two triangles; where a shell hangs on the skin there are three.
        seams = corners[neighbours(triangles), 0]
        edges = np.concatenate([sides_of(corners), seams])
        return cls(rig, corners, connected_parts(len(rig.neutral.vertices), edges))

    def eyes(self, blink: Morph, name: str, both: bool) -> Iterator[Eye | str]:
        """The eyes that a blink shuts: one, or two where it shuts both."""
        moved = np.linalg.norm(blink.delta, axis=1)
        # Lashes move farther than skin, but there is less of them.
        skin = max(self.parts, key=lambda part: int((moved[part] > _MOVED * moved.max()).sum()))
        is_skin = np.zeros(len(moved), bool)
        is_skin[skin] = True
        strong = is_skin & (moved > _STRONG * moved[skin].max())
        if not moved[skin].max() > 0:
            yield f"{name} moves nothing"
            return
        kept = joined(self.rig.neutral.vertices, self.triangles[strong[self.triangles].all(axis=1)])
        found = component_of(len(moved), sides_of(kept))
        lids = [np.flatnonzero(strong & (found == c)) for c in np.unique(found[kept])]
        lids.sort(key=len, reverse=True)
        lids = [lid for lid in lids if 2 * len(lid) > len(lids[0])]
        if len(lids) != 1 + both:
            yield f"{name} moves {len(lids)} lids far, expected {1 + both}"
            return
        for lid in lids:
            try:
                yield self._eye(blink, name, moved, is_skin, lid)
            except ParameterError as error:
                yield f"{name}: {error}"

    def _ball(self, moved: Points, lid: Vertices, way: Points) -> tuple[Points, float, bool]:
        """Centre and radius of the eyeball under a lid, and whether there is one."""
        points = self.rig.neutral.vertices
        middle = points[lid].mean(axis=0)
        best: tuple[float, Points, float] | None = None
        for part in self.parts:
            if len(part) < _BALL or moved[part].max() > _MOVED * moved[lid].max():
                continue
            centre, radius, uneven = fit_sphere(points[part])
            off = np.linalg.norm(points[lid] - centre, axis=1) - radius
            beside = abs(np.median(off)) <= _OVER_BALL * radius
            beside &= radius < np.ptp(points[lid], axis=0).max()
            beside &= np.sort(np.ptp(points[part], axis=0))[1] > _HALF * radius
            if beside and uneven <= (_ROUND if best is None else best[0]):
                best = uneven, centre, radius
        if best is not None:
            return best[1], best[2], True
        corners = points[self.triangles[np.isin(self.triangles, lid).any(axis=1)]]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
        normal -= normal @ way * way
        normal /= np.linalg.norm(normal) or 1.0
        radius = float(np.ptp(points[lid] @ np.cross(way, normal))) / 2
        return middle - radius * normal, radius, False

    def _eye(
        self, blink: Morph, name: str, moved: Points, is_skin: NDArray[np.bool_], lid: Vertices
    ) -> Eye:
        points = self.rig.neutral.vertices
        up = -blink.delta[lid].mean(axis=0)
        up /= np.linalg.norm(up)
        centre, radius, ball = self._ball(moved, lid, up)
        forward = (points[lid] - centre).mean(axis=0)
        forward -= forward @ up * up
        forward /= np.linalg.norm(forward)
        axes = np.stack([np.cross(up, forward), up, forward])
        off = points - centre
        far = np.linalg.norm(off, axis=1) / radius
        seen = is_skin & (off @ forward > 0) & (far > _INSIDE * ball) & (far < _SEEN)
        vertices = np.flatnonzero(seen | (moved > 0))
        number = np.full(len(points), -1)
        number[vertices] = np.arange(len(vertices))
        own = joined(points[vertices], number[self.triangles[seen[self.triangles].all(axis=1)]])
        no, none = np.zeros((0, 2), np.int64), np.zeros(0)
        eye = Eye(name, centre, radius, ball, axes, vertices, seen[vertices], no, no, none, none)
        closing = self.rig.only([name])
        faces = faces_of(part_rig(closing, vertices), np.array(_CLOSING)[:, None])
        return _with_margins(eye, faces, own, moved[vertices])


def _with_margins(eye: Eye, closing: Points, triangles: Vertices, moved: Points) -> Eye:
    """The eye with the margins that border its slit in (S, N, 3) faces from rest to a blink."""
    longitude, latitude, _ = eye.places(closing)
    above, below = np.zeros((2, len(moved)), bool)
    for face, (across, up) in enumerate(zip(longitude, latitude, strict=True)):
        over, under = _slit_edges(eye, closing[face], triangles, moved)
        if not face:
            if not (over.any() and under.any()):
                raise ParameterError(
                    "no open slit was found between its lids: are they modelled shut?"
                )
            first = over | under
            ends = [(place[first].min(), place[first].max()) for place in (across, up)]
        (left, right), (low, high) = ends
        within = (across >= left) & (across <= right) & (up >= low) & (up <= high)
        above |= over & within
        below |= under & within
    edges = np.unique(np.sort(sides_of(triangles), axis=1), axis=0)
    upper, lower = (
        edges[own[edges].all(axis=1) & ~other[edges].any(axis=1)]
        for own, other in ((above, below), (below, above))
    )
    if not (len(upper) and len(lower)):
        raise ParameterError("no margins were found on both lids")
    most = [longitude[0][np.unique(margin)] for margin in (upper, lower)]
    start, stop = max(each.min() for each in most), min(each.max() for each in most)
    fine = np.linspace(start, stop, 4 * COLUMNS)
    wide = replace(eye, upper=upper, lower=lower, columns=fine).slit(closing[:1])[0]
    open_there = fine[wide > max(_OPEN * wide.max(), 0)]
    if not (start < stop and len(open_there)):
        raise ParameterError("its lids do not face each other along a slit")
    columns = np.linspace(open_there.min(), open_there.max(), COLUMNS)
    eye = replace(eye, upper=upper, lower=lower, columns=columns)
    return replace(eye, open=eye.slit(closing[:1])[0])


def joined(points: Points, triangles: Vertices) -> Vertices:
    """(T, 3) triangles with one vertex of theirs for all at its place; none shrinks to an edge."""
    used = np.unique(triangles)
    _, first, inverse = np.unique(points[used], axis=0, return_index=True, return_inverse=True)
    own = np.zeros(len(points), np.int64)
    own[used] = used[first][inverse.ravel()]
    return own[triangles]


def fit_sphere(points: Points) -> tuple[Points, float, float]:
    """Centre, radius and unevenness of the sphere through most of the points.

    A cornea, or what closes half a ball at its back, is left out.
    """
    off = np.zeros(len(points))
    for _ in range(6):
        near = points[off <= np.quantile(off, _SPHERE)]
        # |p|² = 2 p·c + (r² - |c|²) is linear in what is sought.
        table = np.c_[2 * near, np.ones(len(near))]
        fit, *_ = np.linalg.lstsq(table, (near**2).sum(axis=1), rcond=None)
        centre, radius = fit[:3], float(np.sqrt(max(fit[3] + fit[:3] @ fit[:3], 0.0)))
        off = np.abs(np.linalg.norm(points - centre, axis=1) - radius)
    return centre, radius, float(np.quantile(off, _SPHERE)) / (radius or 1.0)


def _slit_edges(
    eye: Eye, positions: Points, triangles: Vertices, moved: Points
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(N,) which vertices are of edges that border the slit from above, and which from below.

    Seen from the centre, an edge borders it where all its triangles lie on one side and nothing
    covers the other.
    """
    longitude, latitude, far = eye.places(positions)
    flat = np.stack([longitude, latitude], axis=1)
    sides = np.sort(sides_of(triangles), axis=1)
    opposite = flat[np.concatenate([triangles[:, 2], triangles[:, 0], triangles[:, 1]])]
    edges, inverse = np.unique(sides, axis=0, return_inverse=True)
    inverse = inverse.ravel()
    start, stop = flat[edges[:, 0]], flat[edges[:, 1]]
    normal = np.stack([start[:, 1] - stop[:, 1], stop[:, 0] - start[:, 0]], axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None]
    side = np.sign(np.einsum("ij,ij->i", opposite - start[inverse], normal[inverse]))
    total = np.bincount(inverse, side, len(edges))
    border = np.flatnonzero(np.abs(total) == np.bincount(inverse, minlength=len(edges)))
    away = -normal[border] * np.sign(total[border])[:, None]
    beside = (start[border] + stop[border]) / 2 + _STEP * away
    turns = []
    for one, two in ((0, 1), (1, 2), (2, 0)):
        a, b = flat[triangles[:, one]], flat[triangles[:, two]]
        x, y = (beside[:, None] - a).transpose(2, 0, 1)
        turns.append((b - a)[:, 0] * y - (b - a)[:, 1] * x)
    inside = np.stack(turns)
    within = np.asarray((inside > 0).all(axis=0) | (inside < 0).all(axis=0))
    covered = within.any(axis=1)
    margin = ~covered & (far[edges[border]].max(axis=1) < _NEAR * eye.radius)
    edges, away = edges[border[margin]], away[margin]
    up, down = np.zeros((2, len(flat)), bool)
    if not len(edges):
        return up, down
    # The outline of all that was looked at is a border too: the slit is where the blink moves most.
    ends = np.unique(edges)
    between = sides_of(triangles)
    between = between[np.isin(between, ends).all(axis=1)]
    loops = component_of(len(flat), np.concatenate([edges, between]))[edges[:, 0]]
    own = np.asarray(loops == np.bincount(loops, moved[edges].sum(axis=1)).argmax())
    up[edges[own & (away[:, 1] < -_SLOPE)]] = True
    down[edges[own & (away[:, 1] > _SLOPE)]] = True
    return up, down
