"""The surface of the neutral, in the vertices of a template, from its photographs.

The template is placed by landmarks, bent to them, drawn to the sparse points of the cameras, and
then moved to where pairs of photographs agree with each other through it (`stereo`), from coarse
photographs to fine ones. What no two photographs show follows what they do.

Lengths are parts of the face, which is the root mean square distance of the landmarks from their
middle, or pixels; weights have no unit. So neither the units of the template nor its axes matter.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera, View
from elastomorph.capturing.geometry.closest_fit import along_normals, robust, to_places, to_points
from elastomorph.capturing.geometry.deformation import Deformation
from elastomorph.capturing.geometry.parts import Parts
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.landmarks.landmarks import fit_landmarks
from elastomorph.capturing.landmarks.typical_face import typical_face
from elastomorph.capturing.neutral.lip_line import Lips
from elastomorph.capturing.neutral.stereo import offsets_from, pairs_of
from elastomorph.capturing.photographs.crops import cropped, no_finer
from elastomorph.errors import CaptureError

Points = NDArray[np.float64]
# Called with what is being done and the part of it that is done, from 0 to 1.
Say = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class NeutralSurface:
    """The template on the surface that photographs show.

    Attributes:
        vertices: (V, 3) in the frame of the cameras.
        covered: (V,) int64 how many pairs of photographs agree on it; 0 where it follows others.
        spread: (V,) by how much they differ along the normal, as a standard deviation, in the
            units of the vertices; infinite where none agree.
    """

    vertices: Points
    covered: NDArray[np.int64]
    spread: Points


@dataclass(frozen=True)
class _Round:
    """One comparison of photographs. Lengths are parts of the face or pixels.

    Attributes:
        density: pixels on the length of the face; photographs with more are made smaller.
        reach: largest offset of a vertex, part of the face.
        bending: stiffness.
    """

    density: float
    reach: float
    bending: float


@dataclass(frozen=True)
class _Step:
    """How the template is drawn to points. Lengths are parts of the face.

    Attributes:
        reach: farther points do nothing.
        width: of the robust weight of a distance.
        landmarks: their weight.
        arap: stiffness.
        bending: stiffness.
    """

    reach: float
    width: float
    landmarks: float
    arap: float
    bending: float


_STEPS = (
    _Step(0.5, 0.1, 3.0, 0.02, 1.0),
    _Step(0.15, 0.05, 1.0, 0.02, 0.3),
    _Step(0.1, 0.02, 0.3, 0.01, 0.05),
)
_ROUNDS = (_Round(60, 0.15, 0.05), _Round(120, 0.12, 0.02), _Round(240, 0.1, 0.01))
_ARAP = 0.005
# Pixels: the median deviation up to which observations agree, and the width of their mean.
_DEVIATION, _WIDTH = 0.8, 0.45
_FEWEST, _EACH = 3, 2
# Most weight of a vertex: many pairs share their errors.
_MOST_WEIGHT = 1.5
# Parts of the face from landmarks within which points of the cameras are looked at first. Once
# the face is in place, the template stands nearer to a scalp than the hair on it does.
_FROM_LANDMARKS = 0.8
# Part of the face that may stand before a vertex without hiding it.
_BEFORE = 0.015


def neutral_surface(
    views: Sequence[View],
    cloud: Points,
    template: Points,
    triangles: NDArray[np.integer],
    landmarks: Mapping[str, int],
    places: Mapping[str, Points],
    *,
    say: Say = lambda text, part: None,
) -> NeutralSurface:
    """Bring a template onto the surface that photographs show.

    Args:
        views: photographs of the neutral, opened one after the other.
        cloud: (N, 3) points of the surface and of anything else, from their cameras.
        template: (V, 3) positions, of any person, size and orientation.
        triangles: (T, 3) of the template.
        landmarks: landmark → vertex of the template.
        places: landmark → (3,) in the frame of the cameras.
        say: called with what is being done and the part of it that is done.

    Raises:
        CaptureError: Landmarks are too few or exchanged, they are on no face, or too few
            photographs show it.
    """
    names = [name for name in landmarks if name in places]
    typical_face({name: template[vertex] for name, vertex in landmarks.items()}, "the template")
    marked = {name: template[landmarks[name]] for name in names}
    rest = fit_landmarks(marked, places, "the photographs")(template)
    vertices = {name: landmarks[name] for name in names}
    goals = np.array([places[name] for name in names])
    return _Neutral(views, cloud, rest, triangles, vertices, goals, say).surface()


class _Neutral:
    """The template on its way to the surface."""

    def __init__(
        self,
        views: Sequence[View],
        cloud: Points,
        rest: Points,
        triangles: NDArray[np.integer],
        landmarks: Mapping[str, int],
        goals: Points,
        say: Say,
    ) -> None:
        self.say = say
        marks = np.array(list(landmarks.values()))
        self.triangles = np.asarray(triangles, dtype=np.int64)
        self.parts = Parts.of(rest, self.triangles, marks)
        on_skin = self.parts.place[marks] >= 0
        self.marks, self.goals = self.parts.place[marks[on_skin]], goals[on_skin]
        self.middle = self.goals.mean(axis=0)
        self.face = float(np.sqrt(((self.goals - self.middle) ** 2).sum(axis=1).mean()))
        self.deformation = Deformation(rest[self.parts.skin], self.parts.triangles)
        self.skin = rest[self.parts.skin]
        self.lips = Lips.of(Surface(rest, self.triangles), landmarks)
        self.cloud = cloud[_near(cloud, rest, self.face)]
        finest = _ROUNDS[-1].density / self.face
        crops = [cropped(view, rest) for view in views]
        self.crops = [no_finer(crop, finest, self.middle) for crop in crops if crop is not None]
        if len(self.crops) < 2:
            raise CaptureError(
                f"{len(self.crops)} of {len(views)} photographs show the face where its landmarks "
                "are: were they clicked in other photographs than these?"
            )

    def surface(self) -> NeutralSurface:
        self.say("the template to the landmarks", 0.0)
        self._solve(self._landmarks(100.0), arap=0.02, bending=5.0, rounds=4)
        self._to_cloud()
        count, spread = self._by_stereo()
        vertices = self.parts.carried(self.skin)
        covered = np.zeros(len(vertices), dtype=np.int64)
        spreads = np.full(len(vertices), np.inf)
        covered[self.parts.skin], spreads[self.parts.skin] = count, spread
        return NeutralSurface(vertices, covered, spreads)

    def _to_cloud(self) -> None:
        """Draw the skin to the points of the cameras: first the face, then what is around it."""
        near = _distances(self.cloud, self.goals) < _FROM_LANDMARKS * self.face
        for number, step in enumerate(_STEPS):
            points = self.cloud[near] if number == 0 else self.cloud
            shown = self._shown()
            for turn in range(3):
                self.say("the template to the cameras' points", (3 * number + turn) / 9)
                width, reach = step.width * self.face, step.reach * self.face
                drawn = to_points(self._own(), points, shown, width=width, reach=reach)
                terms = _sum(drawn, self._landmarks(step.landmarks))
                self._solve(terms, arap=step.arap, bending=step.bending, rounds=3)

    def _by_stereo(self) -> tuple[NDArray[np.int64], Points]:
        """Move the skin to where photographs agree: how many do at each vertex, and how well."""
        pairs = pairs_of([crop.camera for crop in self.crops], self.middle, _EACH)
        for number, each in enumerate(_ROUNDS):
            self.say("the template to the photographs", number / len(_ROUNDS))
            density = each.density / self.face
            crops = [no_finer(crop, density, self.middle) for crop in self.crops]
            pixel = 1 / min(density, float(np.median([self._density(c.camera) for c in crops])))
            vertices = self.parts.carried(self.skin)
            whole = Surface(vertices, self.triangles)
            found = offsets_from(crops, whole, self.parts.place >= 0, pairs, _BEFORE * self.face)
            own = self.parts.place[found.vertices]
            agreed = _agreed(own, found.offsets, found.weights, len(self.skin), pixel)
            agreed.drop(np.abs(agreed.offsets) > each.reach * self.face)
            surface = self._own()
            terms = along_normals(surface, agreed.weights, agreed.offsets)
            # Photographs tell more than single points, where they tell anything.
            rest = self._shown() & (agreed.counts == 0)
            width, reach = 0.01 * self.face, 0.1 * self.face
            drawn = to_points(surface, self.cloud, rest, width=width, reach=reach)
            terms = _sum(terms, drawn, 0.3)
            terms = _sum(terms, self._landmarks(0.2))
            if self.lips is not None:
                terms = _sum(terms, self._ends_of_lips(self.lips, crops, whole))
            self._solve(terms, arap=_ARAP, bending=each.bending, rounds=3)
        return agreed.counts, agreed.spread

    def _density(self, camera: Camera) -> float:
        """Pixels to a unit of length at the face."""
        return camera.focal / float(np.linalg.norm(self.middle - camera.position))

    def _own(self) -> Surface:
        return Surface(self.skin, self.parts.triangles)

    def _shown(self) -> NDArray[np.bool_]:
        """(S,) which vertices of the skin any photograph shows."""
        whole = Surface(self.parts.carried(self.skin), self.triangles)
        shown = np.zeros(len(self.skin), dtype=bool)
        for crop in self.crops:
            shown |= whole.visible(
                crop.camera,
                self.skin,
                whole.normals[self.parts.skin],
                least_cosine=0.0,
                tolerance=_BEFORE * self.face,
            )[0]
        return shown

    def _landmarks(self, weight: float) -> tuple[Points, Points]:
        return to_places(len(self.skin), self.marks, self.goals, weight)

    def _ends_of_lips(
        self, lips: Lips, crops: Sequence[View], whole: Surface
    ) -> tuple[Points, Points]:
        up, higher, weights = lips.moved(crops, whole)
        higher, weights = higher[self.parts.skin], weights[self.parts.skin]
        return (
            weights[:, None, None] * np.outer(up, up),
            (weights * (self.skin @ up + higher))[:, None] * up,
        )

    def _solve(
        self, terms: tuple[Points, Points], *, arap: float, bending: float, rounds: int
    ) -> None:
        self.skin = self.deformation.solve(
            self.skin, *terms, arap=arap, bending=bending, rounds=rounds
        )


@dataclass(eq=False)
class _Agreed:
    """What observations say of each vertex together.

    Attributes:
        offsets: (S,) along the normal.
        weights: (S,) 0 where too few observations agree.
        counts: (S,) int64 observations that agree.
        spread: (S,) their standard deviation; infinite where too few agree.
    """

    offsets: Points
    weights: Points
    counts: NDArray[np.int64]
    spread: Points

    def drop(self, some: NDArray[np.bool_]) -> None:
        """Forget what was observed at some vertices."""
        self.offsets[some] = self.weights[some] = 0
        self.counts[some] = 0
        self.spread[some] = np.inf


def _agreed(
    vertices: NDArray[np.int64], offsets: Points, weights: Points, count: int, pixel: float
) -> _Agreed:
    """The mean of the observations of each of `count` vertices that agree with their median."""
    middles = _medians(vertices, offsets, count)
    away = offsets - middles[vertices]
    deviations = _medians(vertices, np.abs(away), count)
    weights = weights * robust(away, _WIDTH * pixel)
    total = np.bincount(vertices, weights, count)
    mean = np.bincount(vertices, weights * offsets, count) / np.maximum(total, 1e-30)
    near = np.abs(away) < 2 * _WIDTH * pixel
    counts = np.bincount(vertices[near], minlength=count)
    found = _Agreed(mean, np.minimum(total, _MOST_WEIGHT), counts, 1.4826 * deviations)
    found.drop((counts < _FEWEST) | (deviations > _DEVIATION * pixel))
    return found


def _medians(vertices: NDArray[np.int64], values: Points, count: int) -> Points:
    """(count,) median of the values at each vertex; 0 where there are none."""
    order = np.lexsort((values, vertices))
    ordered = np.append(values[order], 0.0)
    times = np.bincount(vertices, minlength=count)
    first = np.cumsum(times) - times
    low, high = first + np.maximum(times - 1, 0) // 2, first + times // 2
    return np.where(times > 0, (ordered[low] + ordered[np.minimum(high, len(values))]) / 2, 0.0)


def _near(cloud: Points, rest: Points, face: float) -> NDArray[np.bool_]:
    """(N,) which points are in the box of the placed template, and half a face around it."""
    low, high = rest.min(axis=0) - face / 2, rest.max(axis=0) + face / 2
    return np.asarray(((cloud > low) & (cloud < high)).all(axis=1))


def _distances(points: Points, others: Points) -> Points:
    """(N,) from (N, 3) points to the nearest of (M, 3) others."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(others).query(points)[0])


def _sum(
    terms: tuple[Points, Points], others: tuple[Points, Points], share: float = 1.0
) -> tuple[Points, Points]:
    return terms[0] + share * others[0], terms[1] + share * others[1]
