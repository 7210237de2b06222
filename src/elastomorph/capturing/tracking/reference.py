"""The neutral with its photographs, prepared once for all poses that are followed from it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera, View
from elastomorph.capturing.geometry.deformation import Deformation
from elastomorph.capturing.geometry.sampling import blurred, sampled
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.tracking.lips import touching
from elastomorph.capturing.tracking.patches import Patches
from elastomorph.model.geometry import largest_distance

Points = NDArray[np.float64]
Single = NDArray[np.float32]

# Of the angle between a normal and the direction to a camera, below which nothing is believed.
LEAST_COSINE = 0.2
# Pixels by which something may stand before a vertex that is still said to be seen.
_BEFORE = 1.5
# Pixels between samples of a patch, and its radius.
_SPACING, PATCH_RADIUS = 1.5, 9.0
# Of D: how near skin is that touches.
_TOUCHING = 0.006
# Photographs that would be made smaller by less than this are left as they are.
_ALMOST = 0.85
# Every so many pixels of a neutral photograph the depth of the surface is kept.
_DEPTH_STEP = 2


class Level:
    """The neutral with photographs of one size.

    Attributes:
        surface: of the neutral.
        views: its photographs at this size.
        pixel: length on the surface that a pixel shows.
    """

    def __init__(self, surface: Surface, views: Sequence[View], scale: float) -> None:
        self.surface = surface
        self.views = [view.scaled(scale) for view in views]
        self.scale = scale
        middle = surface.vertices.mean(axis=0)
        self.pixel = float(
            np.median([v.camera.project(middle)[1] / v.camera.focal for v in self.views])
        )

    def looked(self, posed: Surface, camera: Camera) -> tuple[NDArray[np.bool_], Points]:
        """Which vertices of the surface, neutral or posed, a camera sees, and their cosines."""
        return posed.visible(
            camera,
            posed.vertices,
            posed.normals,
            least_cosine=LEAST_COSINE,
            tolerance=_BEFORE * self.pixel,
        )

    @cached_property
    def seen(self) -> tuple[NDArray[np.bool_], Points]:
        """(K, V) which vertices each photograph of the neutral sees, and the cosines."""
        found = [self.looked(self.surface, view.camera) for view in self.views]
        visible = np.stack(
            [
                each & view.usable(view.camera.project(self.surface.vertices)[0])
                for (each, _), view in zip(found, self.views, strict=True)
            ]
        )
        return visible, np.stack([cosines for _, cosines in found])

    @cached_property
    def ways(self) -> Points:
        """(K, V, 3) directions from the neutral's vertices to each camera."""
        far = np.stack([v.camera.position for v in self.views])[:, None] - self.surface.vertices
        found: Points = far / np.linalg.norm(far, axis=2, keepdims=True)
        return found

    @cached_property
    def depths(self) -> list[Single]:
        """Of the surface in each photograph, every second pixel."""
        return [
            self.surface.cast(v.camera.position, v.camera.directions(_DEPTH_STEP)).depths.astype(
                np.float32
            )
            for v in self.views
        ]

    @cached_property
    def patches(self) -> Patches:
        """Around each vertex that any photograph sees."""
        return Patches.of(
            self.surface,
            np.any(self.seen[0], axis=0),
            _SPACING * self.pixel,
            PATCH_RADIUS * self.pixel,
        )

    @cached_property
    def shown(self) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        """(K, S) what each photograph shows at the samples, and which it sees."""
        places = self.patches.at(self.surface.vertices)
        corners = self.surface.triangles[self.patches.triangles]
        values = [
            sampled(blurred(view.grey), view.camera.project(places)[0]) for view in self.views
        ]
        known = np.stack([each[corners].all(axis=1) for each in self.seen[0]])
        return np.stack(values), known


class Reference:
    """The neutral: surface, photographs, and its deformations.

    Attributes:
        surface: its vertices and triangles.
        views: its photographs.
    """

    def __init__(
        self, vertices: Points, triangles: NDArray[np.integer], views: Sequence[View]
    ) -> None:
        self.surface = Surface(vertices, triangles)
        # A sequence that reads photographs when asked is gone through once.
        self.views = list(views)
        self._levels: dict[float, Level] = {}

    @cached_property
    def extent(self) -> float:
        """D: the largest distance between two of its vertices."""
        return largest_distance(self.surface.vertices)

    def scales(self, heads: Sequence[float]) -> list[float]:
        """Sizes of the photographs at which D is about so many pixels long, 1 at most."""
        middle = self.surface.vertices.mean(axis=0)
        lengths = [
            v.camera.focal * self.extent / max(float(v.camera.project(middle)[1]), 1e-9)
            for v in self.views
        ]
        wanted = [head / float(np.median(lengths)) for head in heads]
        return [1.0 if scale > _ALMOST else scale for scale in wanted]

    @cached_property
    def touching(self) -> NDArray[np.bool_]:
        """(V,) where the surface touches itself: lips that are closed, lids."""
        return touching(self.surface, _TOUCHING * self.extent)

    @cached_property
    def deformation(self) -> Deformation:
        """Of the surface at rest."""
        return Deformation(self.surface.vertices, self.surface.triangles)

    def level(self, scale: float) -> Level:
        """The photographs at a size; kept for the next pose."""
        if scale not in self._levels:
            self._levels[scale] = Level(self.surface, self.views, scale)
        return self._levels[scale]
