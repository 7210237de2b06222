"""The small head of somebody else, photographed small: what a neutral is made from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import elastomorph as em
from elastomorph.capturing.geometry import Camera, Similarity, Surface, View, open_view
from elastomorph.capturing.landmarks import read_landmarks, triangulated
from photographs.sessions import Session, photograph
from photographs.truth import Truth

SESSION = Session(count=12, size=(450, 600), rings=(-8.0, 16.0), azimuth=50.0, poses=1)


@dataclass(frozen=True, eq=False)
class Head:
    """Photographs, what their cameras would know, a template, and the truth."""

    views: Sequence[View]
    cloud: np.ndarray
    template: np.ndarray
    triangles: np.ndarray
    landmarks: dict[str, int]
    places: dict[str, np.ndarray]
    true: np.ndarray
    surface: Surface

    @property
    def cameras(self) -> list[Camera]:
        return [view.camera for view in self.views]

    @property
    def extent(self) -> float:
        """D."""
        return em.Mesh(self.true).diameter

    def moved(self, similarity: Similarity) -> Head:
        """The same world elsewhere; the template, too."""
        return replace(
            self,
            views=[replace(view, camera=view.camera.moved(similarity)) for view in self.views],
            cloud=similarity(self.cloud),
            template=similarity(self.template),
            places={name: similarity(place) for name, place in self.places.items()},
            true=similarity(self.true),
            surface=Surface(similarity(self.surface.vertices), self.surface.triangles),
        )


def cameras_of(truth: Truth, session: Session) -> list[Camera]:
    """The cameras that took the photographs of the first pose."""
    return [
        Camera(
            name,
            session.size,
            shot.lens.focal,
            np.array(shot.lens.centre),
            shot.lens.radial,
            shot.rotation,
            shot.translation,
        )
        for name, shot in zip(truth.files, truth.cameras["p00"], strict=True)
    ]


@cache
def photographed_head() -> Head:
    """Rendered once; six seconds."""
    with TemporaryDirectory() as folder:
        truth = photograph(SESSION, folder)
        marks = read_landmarks(Path(folder) / "landmarks.json")
        template = em.read(Path(folder) / "template.obj")
        cameras = cameras_of(truth, SESSION)
        views = [open_view(camera, Path(folder) / "p00" / camera.name) for camera in cameras]
    surface = Surface(truth.vertices["p00"], truth.triangles)
    by_name = {camera.name: camera for camera in cameras}
    places = triangulated(marks.photographs["p00"], by_name)[0]
    return Head(
        views,
        _cloud(surface, cameras),
        template.vertices,
        template.faces.triangles(),
        dict(marks.vertices),
        places,
        surface.vertices[truth.of_template],
        surface,
    )


def _cloud(surface: Surface, cameras: Sequence[Camera], count: int = 4000) -> np.ndarray:
    """Points that cameras see, off by .02 cm; one in five is anywhere."""
    random = np.random.default_rng(2)
    triangles = random.integers(0, len(surface.triangles), 4 * count)
    weights = random.dirichlet([1, 1, 1], len(triangles))
    points = np.einsum("ni,nij->nj", weights, surface.vertices[surface.triangles[triangles]])
    normals = np.einsum("ni,nij->nj", weights, surface.normals[surface.triangles[triangles]])
    seen = np.zeros(len(points), dtype=int)
    for camera in cameras:
        seen += surface.visible(camera, points, normals, least_cosine=0.2, tolerance=0.1)[0]
    points = points[seen >= 3][:count]
    points += random.normal(0, 0.02, points.shape)
    low, high = surface.vertices.min(axis=0) - 20, surface.vertices.max(axis=0) + 20
    points[::5] = random.uniform(low, high, points[::5].shape)
    return points
