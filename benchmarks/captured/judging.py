"""How far registered poses are from the truth, region by region.

What is compared. A registered vertex of the neutral stands for the point of the true neutral that
is closest to it (its *material point*). Where that point of the skin is in a true pose is where the
vertex should be; where it is not on the template's own place of the face does no harm to paths. The
error of a pose is that of its *displacement*: |(V − V₀) − (X − X₀)| with V, V₀ registered and X, X₀
the material point, in percent of D, the largest distance between two vertices of the true neutral
with the template's topology. The scale and the frame come from the true cameras of the neutral.

Regions, all of skin (not eyes, teeth, gums), of points whose registered vertex lies within 0.5 % of
D of them:

front       in front of the corners of the jaw and above 1 cm below the chin
moving      of the front, moved by more than 0.1 cm, shown by at least 4 photographs of the neutral
            and 4 of the pose, more than 1 cm from the lip line and not under the chin
lips        within 1 cm of the line where the lips meet, shown by 2 photographs of the neutral
chin        under the chin: normals that point down by more than 50°, lower than the lower lip, at
            most 3 cm below the chin, shown by 2 photographs of the neutral and 2 of the pose
visible     of the front and under the chin, shown by 2 photographs of the neutral and of the pose

A point is shown by a photograph where nothing hides it and its normal is within 78° of the camera.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import pdist

from captured.geometry import Nearest, closest, to_segments, views_of
from photographs.truth import Truth

__all__ = ["REGIONS", "Chosen", "Judge", "Spread", "extent", "flags", "normals_of"]

Points = NDArray[np.float64]
Chosen = NDArray[np.bool_]
REGIONS = ("moving", "lips", "chin", "visible")
_SKIN = 0
_OFF = 0.005  # of D: a vertex farther from the neutral stands for nothing


@dataclass(frozen=True)
class Spread:
    """Errors in percent of D: count, mean, 95th and 99th percentile, largest."""

    count: int
    mean: float
    p95: float
    p99: float
    largest: float

    @classmethod
    def of(cls, errors: Points) -> Spread:
        """Of errors in percent; not a number where there are none."""
        if not len(errors):
            return cls(0, *[float("nan")] * 4)
        parts = np.percentile(errors, [95, 99])
        return cls(len(errors), float(errors.mean()), *map(float, parts), float(errors.max()))

    def __str__(self) -> str:
        return f"{self.mean:.3f} / {self.p95:.3f} / {self.p99:.2f} / {self.largest:.2f}"


def extent(points: Points) -> float:
    """D: the largest distance between two points (N, 3)."""
    # Both ends lie among the extreme points of many directions, closely enough for percents of it.
    ways = np.random.default_rng(0).normal(size=(2000, 3))
    ends = np.unique(np.concatenate([(points @ ways.T).argmax(0), (points @ ways.T).argmin(0)]))
    return float(pdist(points[ends]).max())


def normals_of(vertices: Points, triangles: NDArray[np.integer]) -> Points:
    """(V, 3) unit normals, triangles weighted by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    faces = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    summed = np.stack(
        [np.bincount(triangles.ravel(), axis, len(vertices)) for axis in faces.T], axis=1
    )
    return summed / np.maximum(np.linalg.norm(summed, axis=1, keepdims=True), 1e-300)


class Judge:
    """The truth, and the registered neutral that poses are judged from.

    Args:
        truth: Of the photographs.
        neutral: (N, 3) registered, in the frame of the truth.
        first: Name of the neutral.
    """

    def __init__(self, truth: Truth, neutral: Points, first: str = "p00") -> None:
        self.truth, self.neutral, self.first = truth, neutral, first
        self.rest = truth.vertices[first]
        self.extent = extent(self.rest[truth.of_template])

    @cached_property
    def material(self) -> Nearest:
        """The point of the true neutral that each vertex stands for."""
        return closest(self.neutral, self.rest, self.truth.triangles)

    @cached_property
    def points(self) -> Points:
        """(N, 3) where it is in the true neutral."""
        return self.material.on(self.rest, self.truth.triangles)

    def of(self, pose: str) -> Points:
        """(N, 3) where it is in a true pose, in the frame of the neutral."""
        return self.material.on(self.truth.vertices[pose], self.truth.triangles)

    def normals(self, pose: str) -> Points:
        """(N, 3) of the true surface there."""
        corners = normals_of(self.truth.vertices[pose], self.truth.triangles)
        own = self.material.on(corners, self.truth.triangles)
        return own / np.maximum(np.linalg.norm(own, axis=1, keepdims=True), 1e-300)

    def views(self, pose: str) -> NDArray[np.int64]:
        """(N,) how many photographs of a pose show it."""
        own, normals = self.of(pose), self.normals(pose)
        turn, shift = self.truth.turns[pose], self.truth.shifts[pose]
        cameras = []
        for shot in self.truth.cameras[pose]:
            pixels = shot.project(self.truth.in_world(pose, own))
            within = ((pixels >= 0) & (pixels <= np.array(shot.lens.size) - 1)).all(axis=1)
            cameras.append(((shot.position - shift) @ turn, within))
        return views_of(own, normals, self.truth.vertices[pose], self.truth.triangles, cameras)

    @cached_property
    def neutral_views(self) -> NDArray[np.int64]:
        """(N,) of the neutral."""
        return self.views(self.first)

    @cached_property
    def skin(self) -> Chosen:
        """(N,) whether it is skin and the vertex close to it."""
        own = self.truth.materials[self.material.triangles] == _SKIN
        return own & (self.material.distances < _OFF * self.extent)

    @cached_property
    def before(self) -> Chosen:
        """(N,) in front of the corners of the jaw."""
        jaw = [v for name, v in self.truth.landmarks.items() if name.endswith("jaw")]
        return self.points[:, 2] > self.rest[jaw, 2].mean()

    @cached_property
    def above(self) -> Chosen:
        """(N,) above 1 cm below the chin."""
        return self.points[:, 1] > self.rest[self.truth.landmarks["chin"], 1] - 1

    @cached_property
    def front(self) -> Chosen:
        """(N,) of the skin, the face without ears and neck."""
        return self.skin & self.before & self.above

    @cached_property
    def lips(self) -> Chosen:
        """(N,) within 1 cm of the lip line."""
        starts, ends = (self.rest[self.truth.lip_line[:, k]] for k in (0, 1))
        return self.skin & (to_segments(self.points, starts, ends) < 1.0)

    @cached_property
    def chin(self) -> Chosen:
        """(N,) under the chin."""
        lower, chin = (self.rest[self.truth.landmarks[k], 1] for k in ("lower_lip", "chin"))
        down = self.normals(self.first)[:, 1] < -np.sin(np.radians(50))
        height = self.points[:, 1]
        return self.skin & down & self.before & (height < lower) & (height > chin - 3) & ~self.lips

    def regions(self, pose: str) -> dict[str, Chosen]:
        """(N,) members of each region in a pose."""
        views, before = self.views(pose), self.neutral_views
        both = (views >= 2) & (before >= 2)
        moved = np.linalg.norm(self.of(pose) - self.points, axis=1) > 0.1
        well = (views >= 4) & (before >= 4)
        return {
            "moving": self.front & moved & well & ~self.lips & ~self.chin,
            "lips": self.lips & (before >= 2),
            "chin": self.chin & both,
            "visible": (self.front | self.chin) & both,
        }

    def errors(self, pose: str, vertices: Points) -> Points:
        """(N,) of displacements, in percent of D."""
        found, true = vertices - self.neutral, self.of(pose) - self.points
        return 100 * np.linalg.norm(found - true, axis=1) / self.extent

    def surface(self) -> Spread:
        """Distance of the neutral from the true one, over skin of the front seen twice or more.

        Here every vertex counts, however far it is.
        """
        skin = self.truth.materials[self.material.triangles] == _SKIN
        chosen = skin & self.before & self.above & (self.neutral_views >= 2)
        return Spread.of(100 * self.material.distances[chosen] / self.extent)

    def pose(self, pose: str, vertices: Points) -> dict[str, Spread]:
        """Errors of a registered pose (N, 3) in each region."""
        errors = self.errors(pose, vertices)
        return {name: Spread.of(errors[own]) for name, own in self.regions(pose).items()}


def flags(errors: Points, confidence: Points, chosen: Chosen) -> tuple[float, float, int]:
    """Share of the vertices off by more than 0.5 that are flagged, share flagged, how many are off.

    Args:
        errors: (N,) in percent of D.
        confidence: (N,) below 0.5 is flagged.
        chosen: (N,) the vertices that count.
    """
    off, flagged = errors[chosen] > 0.5, confidence[chosen] < 0.5
    caught = float(flagged[off].mean()) if off.any() else 1.0
    return caught, float(flagged.mean()), int(off.sum())
