"""What must turn rigidly: ground truth inside a rig, the arc of a jaw, and how rigid a path is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.curves import CurveNetwork, region_of
from elastomorph.errors import ParameterError
from elastomorph.model.geometry import Screw, connected_parts, fit_rigid, largest_distance
from elastomorph.model.mesh import Mesh, part_of, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence

TIMES = (0.25, 0.5, 0.75)
"""Moments at which paths are compared with the arc of a hinge."""
_RIGID = 1e-3
"""Largest distance of a part from a rigid motion, as a fraction of D."""
_LEAST_TURN = 5.0
"""Smallest angle of interest, in degrees."""
_FRAMES = 11
_MOMENTS = 41
_CARRIED = 1e-6
"""What is carried along ends as near to the motion as the parts do, or within this part of D."""
_MOST_IN_PAIRS = 1500
# An eyeball with its cornea is a sphere within this part of its radius, root of the mean square,
# and the edge of a lid lies within half a radius of it. Rings of few vertices fit any sphere.
_BALL = 64
_ROUND = 0.06
_OVER_BALL = 0.5


@dataclass(frozen=True, eq=False)
class RigidParts:
    """Components of a mesh that one rigid motion carries from neutral to target."""

    vertices: NDArray[np.int64]  # (N,) their vertices in the whole mesh, rising
    components: int  # How many there are
    screw: Screw  # The motion
    residual: float  # Largest distance of a target vertex from it, as a fraction of D
    # The parts alone, on the screw at constant speed. Where they are at which time is not known,
    # so only errors with free timing say something about a method.
    truth: MeshSequence

    def curves(self, network: CurveNetwork) -> CurveNetwork:
        """The curves of the whole mesh that lie on the parts."""
        new_index = np.full(network.vertex_count, -1)
        new_index[self.vertices] = np.arange(len(self.vertices))
        return network.restricted(self.vertices).relabelled(new_index, len(self.vertices))

    def restricted(self, morph: Morph) -> Morph:
        """What a path of the whole mesh does to the parts alone."""
        truth = self.truth
        return replace(
            morph, neutral=truth.mesh, target=truth.target, bends=morph.bends[:, self.vertices]
        )


def find_rigid_parts(neutral: Mesh, target: Mesh) -> RigidParts | None:
    """The largest set of components that one rigid motion turns together, or none."""
    require_same_topology(neutral, target)
    scale = neutral.diameter or 1.0
    rigid: list[NDArray[np.int64]] = []
    for vertices in connected_parts(len(neutral.vertices), neutral.edges):
        if len(vertices) >= 4:
            start, end = neutral.vertices[vertices], target.vertices[vertices]
            screw, residual = fit_rigid(start, end)
            # What hardly moves is near to any motion, and to none that could be called its own.
            moves = np.abs(end - start).max() > _RIGID * scale
            turns = np.degrees(screw.angle) >= _LEAST_TURN
            if moves and turns and residual.max() <= _RIGID * scale:
                rigid.append(vertices)
    if not rigid:
        return None
    together = np.sort(np.concatenate(rigid))
    screw, residual = fit_rigid(neutral.vertices[together], target.vertices[together])
    if residual.max() > 2 * _RIGID * scale:
        largest = max(rigid, key=len)
        rigid, together = [largest], np.sort(largest)
        screw, residual = fit_rigid(neutral.vertices[together], target.vertices[together])
    off = float(residual.max()) / scale
    return RigidParts(together, len(rigid), screw, off, _truth(neutral, target, together, screw))


def _truth(neutral: Mesh, target: Mesh, vertices: NDArray[np.int64], screw: Screw) -> MeshSequence:
    start, end = neutral.vertices[vertices], target.vertices[vertices]
    left_over = end - screw.at(1.0, start)
    times = np.linspace(0.0, 1.0, _FRAMES)
    positions = np.stack([screw.at(float(t), start) + t * left_over for t in times])
    positions[-1] = end
    return MeshSequence(part_of(neutral, vertices), positions, times)


@dataclass(frozen=True, eq=False)
class Hinge:
    """What turns about one axis, rigidly, from a neutral to a target."""

    neutral: Mesh  # The whole face at rest
    screw: Screw  # The motion
    # (N,) vertices of pieces that move as one rigid body, such as teeth; rising.
    parts: NDArray[np.int64]
    # (M,) vertices that the motion carries as closely, of further pieces that it carries for the
    # most part, such as gums; rising.
    along: NDArray[np.int64]
    # How far the target itself is from the motion on all of these, as a fraction of D.
    residual: float

    @property
    def vertices(self) -> NDArray[np.int64]:
        """(N + M,) all that turns, rising."""
        return np.union1d(self.parts, self.along)

    def off(self, morph: Morph, time: float) -> NDArray[np.float64]:
        """(N + M,) distance of each of `vertices` from the true arc, as a fraction of D."""
        there = self.screw.at(time, self.neutral.vertices[self.vertices])
        away = np.linalg.norm(morph.at(time)[self.vertices] - there, axis=1)
        return np.asarray(away / (self.neutral.diameter or 1.0))


@dataclass(frozen=True)
class HingeError:
    """Largest distances from the true arc at t = 0.25, 0.5 and 0.75, as fractions of D."""

    label: str  # The method
    parts: float  # Of the rigid parts
    along: float  # Of what moves along with them; 0 where there is nothing


def find_hinge(neutral: Mesh, target: Mesh, parts: RigidParts) -> Hinge:
    """The hinge of rigid parts, and what else turns with it from a neutral to a target."""
    start, end = neutral.vertices, target.vertices
    left_over = np.linalg.norm(parts.screw.at(1.0, start) - end, axis=1)
    allowed = max(float(left_over[parts.vertices].max()), _CARRIED * neutral.diameter)
    carried = (left_over <= allowed) & (start != end).any(axis=1)
    carried[parts.vertices] = False
    along = np.zeros_like(carried)
    for piece in connected_parts(len(start), neutral.edges):
        # A gum is carried; a chin that happens to run along is skin, which may do as it likes.
        if 2 * np.count_nonzero(carried[piece]) > len(piece):
            along[piece] = carried[piece]
    turning = np.union1d(parts.vertices, np.flatnonzero(along))
    own = float(left_over[turning].max()) / (neutral.diameter or 1.0)
    return Hinge(neutral, parts.screw, parts.vertices, np.flatnonzero(along), own)


def hinge_errors(hinge: Hinge, morphs: Mapping[str, Morph]) -> list[HingeError]:
    """How far each labelled path of the whole face leaves the true arc, at even timing."""
    is_part = np.isin(hinge.vertices, hinge.parts)
    found = []
    for label, morph in morphs.items():
        worst = np.max([hinge.off(morph, time) for time in TIMES], axis=0)
        found.append(
            HingeError(label, float(worst[is_part].max()), float(worst[~is_part].max(initial=0.0)))
        )
    return found


@dataclass(frozen=True, eq=False)
class Eyelid:
    """A lid that sweeps over an eyeball, by its vertex that moves farthest."""

    vertex: int  # Of the lid
    centre: NDArray[np.float64]  # (3,) of the sphere that fits the eyeball
    radius: float  # Of that sphere
    axis: NDArray[np.float64]  # (3,) unit vector the lid turns about, through the centre

    def heights(self, morph: Morph, times: ArrayLike) -> NDArray[np.float64]:
        """(T,) distance of the vertex above the sphere, negative within, as a fraction of D."""
        way = morph.at(np.asarray(times, dtype=np.float64))[:, self.vertex]
        above = np.linalg.norm(way - self.centre, axis=1) - self.radius
        return np.asarray(above / (morph.neutral.diameter or 1.0))

    def dip(self, morph: Morph) -> float:
        """How far the vertex sinks towards the eye, as a fraction of D.

        Below the lower of its two ends, so that timing does not count. A lid that slides on the
        ball does not sink.
        """
        heights = self.heights(morph, np.linspace(0.0, 1.0, _MOMENTS))
        return float(min(heights[0], heights[-1]) - heights.min())


def find_eyelid(neutral: Mesh, target: Mesh) -> Eyelid | None:
    """The lid that a target closes, and the eyeball it sweeps over; None where there is no ball.

    The ball is the connected part of the mesh that is most nearly a sphere, near the lid, and that
    the target leaves where it is. The lid is of the part of which the target moves most vertices:
    lashes move farther, and are no skin.
    """
    require_same_topology(neutral, target)
    start, end = neutral.vertices, target.vertices
    moved = np.linalg.norm(end - start, axis=1)
    still = moved <= _RIGID * neutral.diameter
    parts = connected_parts(len(start), neutral.edges)
    skin = max(parts, key=lambda part: int(np.count_nonzero(~still[part])))
    vertex = int(skin[moved[skin].argmax()])
    best: tuple[float, NDArray[np.float64], float] | None = None
    for part in parts:
        if len(part) < _BALL or not still[part].all():
            continue
        points = start[part]
        # |p|² = 2 p·c + (r² - |c|²) is linear in what is sought.
        fit, *_ = np.linalg.lstsq(
            np.c_[2 * points, np.ones(len(points))], (points**2).sum(axis=1), rcond=None
        )
        centre = fit[:3]
        radius = float(np.sqrt(max(fit[3] + centre @ centre, 0.0)))
        off = np.linalg.norm(points - centre, axis=1) - radius
        uneven = float(np.sqrt(np.mean(off**2))) / (radius or 1.0)
        beside = abs(np.linalg.norm(start[vertex] - centre) - radius) <= _OVER_BALL * radius
        if beside and uneven <= (_ROUND if best is None else best[0]):
            best = uneven, centre, radius
    if best is None:
        return None
    _, centre, radius = best
    axis = np.cross(start[vertex] - centre, end[vertex] - centre)
    length = float(np.linalg.norm(axis))
    return Eyelid(vertex, centre, radius, axis / length) if length > 0 else None


@dataclass(frozen=True)
class Rigidity:
    """How a path treats vertices known to move as one rigid body, over the times asked for.

    Attributes:
        change: Largest change of the distance between two of the vertices, as a fraction of D.
        off_screw: Largest distance of a vertex from the screw motion between both ends, each
            moment compared with the part of the screw that fits it best, as a fraction of D.
        ends: Largest distance of the target from a rigid motion of the neutral, as a fraction of
            D: where it is large, the vertices are no rigid body.
    """

    change: float
    off_screw: float
    ends: float


def rigidity(morph: Morph, body: ArrayLike | str, times: Iterable[float]) -> Rigidity:
    """Measure how rigid a body stays along a path.

    Pairs are taken among at most 1500 vertices spread evenly over the body.

    Args:
        morph: The path.
        body: Vertex indices, (V,) bool or the name of a group, at least four vertices.
        times: Moments of the path.

    Raises:
        CurveError: A vertex that does not exist.
        ParameterError: Fewer than four vertices.
    """
    from scipy.optimize import minimize_scalar

    vertices = np.flatnonzero(region_of(morph.neutral, body))
    if vertices.size < 4:
        raise ParameterError(f"a rigid body needs at least 4 vertices, found {vertices.size}")
    start, end = morph.neutral.vertices[vertices], morph.target.vertices[vertices]
    screw, residual = fit_rigid(start, end)
    left_over = end - screw.at(1.0, start)
    sample = np.unique(np.linspace(0, vertices.size - 1, _MOST_IN_PAIRS).astype(int))
    at_rest = _distances(start[sample])
    scale = morph.neutral.diameter or largest_distance(morph.target.vertices)
    parts = np.linspace(0.0, 1.0, 201)
    arcs = np.stack([screw.at(float(part), start) + part * left_over for part in parts])
    change = off = 0.0
    for time in times:
        here = morph.at(float(time))[vertices]
        change = max(change, float(np.abs(_distances(here[sample]) - at_rest).max()))
        nearest = int(np.einsum("pvi,pvi->p", arcs - here, arcs - here).argmin())
        bracket = (parts[max(nearest - 1, 0)], parts[min(nearest + 1, len(parts) - 1)])

        def away(part: float, here: NDArray[np.float64] = here) -> NDArray[np.float64]:
            return screw.at(part, start) + part * left_over - here

        best = minimize_scalar(
            lambda part: float((away(part) ** 2).sum()),
            bounds=bracket,
            method="bounded",
            options={"xatol": 1e-12},
        ).x
        off = max(off, float(np.linalg.norm(away(float(best)), axis=1).max()))
    return Rigidity(change / scale, off / scale, float(residual.max()) / scale)


def _distances(points: NDArray[np.float64]) -> NDArray[np.float64]:
    from scipy.spatial.distance import pdist

    return np.asarray(pdist(points))
