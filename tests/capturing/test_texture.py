"""Colours of a painted ball, photographed by formulas: who sees what is known without any rays."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import elastomorph as em
from elastomorph.capturing.geometry import Camera, Surface
from elastomorph.capturing.neutral import Painted, paint
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from needs import extra

for module in ("cv2", "embreex"):
    extra(module, "capture")

ACROSS, UP = 64, 32
MOON, MOON_SIZE = np.array([0.1, 0.2, 1.7]), 0.25  # it hides part of the ball
SIZE, FOCAL, AWAY = (260, 240), 560.0, 5.0
GAINS = (1.0, 1.06, 0.94, 1.02, 0.97)


def ball(middle: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of a ball and, of its quads, the corners; those of u = 0 and u = 1 are apart."""
    u, v = np.meshgrid(np.linspace(0, 1, ACROSS + 1), np.linspace(0, 1, UP + 1))
    vertices = middle + radius * at(u, v).reshape(-1, 3)
    rows = np.arange((ACROSS + 1) * UP).reshape(UP, -1)[:, :-1].ravel()
    return vertices, np.stack([rows, rows + 1, rows + ACROSS + 2, rows + ACROSS + 1], axis=1)


def at(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(..., 3) the point of the unit ball at texture coordinates: v = 1 above."""
    around, up = 2 * np.pi * (u - 0.5), np.pi * (v - 0.5)
    return np.stack([np.sin(around) * np.cos(up), np.sin(up), np.cos(around) * np.cos(up)], axis=-1)


def colours(points: np.ndarray) -> np.ndarray:
    """(..., 3) from 0 to 255, of no symmetry."""
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack(
        [140 + 60 * np.sin(4 * x + y), 120 + 70 * y, 110 + 50 * np.cos(3 * z - 2 * x)], axis=-1
    )


def cameras() -> list[Camera]:
    """Around the front of the ball."""
    found = []
    for k, (around, up) in enumerate([(0, 0), (50, 10), (-50, -10), (20, 45), (-25, -40)]):
        a, e = np.radians([around, up])
        place = AWAY * np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])
        z = -place / AWAY
        x = np.cross(z, [0.0, 1.0, 0.0])
        x /= np.linalg.norm(x)
        turn = np.stack([x, np.cross(z, x), z])
        middle = np.array(SIZE) / 2 + [3, -2]
        found.append(Camera(f"{k}.png", SIZE, FOCAL, middle, 0.0, turn, -turn @ place))
    return found


def met(camera: Camera, ways: np.ndarray, middle: np.ndarray, radius: float) -> np.ndarray:
    """(...) lengths of (..., 3) directions at which rays of a camera meet a ball, or infinity."""
    start = camera.position - middle
    a, b, c = (ways**2).sum(-1), ways @ start, (start**2).sum() - radius**2
    root = b**2 - a * c
    return np.where(root > 0, (-b - np.sqrt(np.maximum(root, 0))) / a, np.inf)


def photographed(camera: Camera, gain: float) -> np.ndarray:
    """What it sees, the moon black, the sky white, and a highlight of its own."""
    ways = camera.directions()
    far, moon = met(camera, ways, np.zeros(3), 1.0), met(camera, ways, MOON, MOON_SIZE)
    points = camera.position + np.where(np.isfinite(far), far, 1.0)[..., None] * ways
    seen = gain * colours(points)
    mirror = camera.position / AWAY + [0.3, 0.5, 0.0]
    shine = np.clip(points @ (mirror / np.linalg.norm(mirror)), 0, 1) ** 3000
    seen = seen + 150 * shine[..., None]
    seen[~np.isfinite(far)] = 255
    seen[moon < far] = 0
    return np.clip(np.round(seen), 0, 255).astype(np.uint8)


def visible(camera: Camera, points: np.ndarray) -> np.ndarray:
    """(N,) which points of the ball a camera sees, by formulas."""
    away = camera.position - points
    cosines = (away * points).sum(axis=1) / np.linalg.norm(away, axis=1)
    pixels, _ = camera.project(points)
    return (cosines > 0.2) & camera.inside(pixels, 4) & ~(met(camera, -away, MOON, MOON_SIZE) < 1)


@dataclass(frozen=True, eq=False)
class Case:
    """The ball and the moon as one mesh, photographs, and what became of them."""

    mesh: Mesh
    painted: Painted


def mesh(materials: FaceLabels | None = None, tile: float = 0.0) -> Mesh:
    """The ball, with texture coordinates, and the moon, without."""
    vertices, quads = ball(np.zeros(3), 1.0)
    others, more = ball(MOON, MOON_SIZE)
    u, v = np.meshgrid(np.linspace(0, 1, ACROSS + 1), np.linspace(0, 1, UP + 1))
    uv = np.stack([u.ravel() + tile, v.ravel()], axis=1)
    corners = np.concatenate([quads.ravel(), np.full(more.size, -1)]).astype(np.int32)
    faces = np.concatenate([quads, more + len(vertices)])
    return Mesh(np.concatenate([vertices, others]), faces, UVMap(uv, corners), materials)


def paint_it(shape: Mesh, folder: Path) -> dict[str, Painted]:
    files = {}
    for camera, gain in zip(cameras(), GAINS, strict=True):
        files[camera.name] = folder / camera.name
        Image.fromarray(photographed(camera, gain)).save(files[camera.name])
    places, place = np.unique(shape.vertices.round(9), axis=0, return_inverse=True)
    surface = Surface(places, place[shape.faces.triangles()])
    return paint(shape, surface, place, cameras(), files)


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    shape = mesh()
    found = paint_it(shape, tmp_path_factory.mktemp("ball"))
    assert list(found) == [""]
    return Case(shape, found[""])


def texels(side: int) -> np.ndarray:
    """(S, S, 3) the point of the ball at each texel, the row of v = 1 first."""
    u, v = np.meshgrid((np.arange(side) + 0.5) / side, 1 - (np.arange(side) + 0.5) / side)
    return at(u, v)


def test_colours_are_those_of_the_skin(case: Case) -> None:
    """Median per channel within one part of 255, of whatever exposure and beside highlights."""
    painted = case.painted
    true = colours(texels(len(painted.image)))
    level = np.median(painted.image[painted.seen] / true[painted.seen])  # exposures differ
    assert level == pytest.approx(1, abs=0.05)
    signed = (painted.image / level - true)[painted.seen]
    off = abs(signed)
    assert np.median(off, axis=0).max() < 1.0
    assert np.percentile(off, 99) < 3
    assert signed.min() > -6  # the moon is nowhere
    assert (
        np.percentile(off, 99.9) < 20
    )  # nor the sky, nor a highlight that two others do not share


def test_the_mask_is_what_some_camera_sees(case: Case) -> None:
    seen, side = case.painted.seen, len(case.painted.image)
    points = texels(side).reshape(-1, 3)
    true = np.any([visible(camera, points) for camera in cameras()], axis=0).reshape(side, side)
    assert 0.2 < true.mean() < 0.8
    assert (seen == true).mean() > 0.97
    assert (seen & ~true).mean() < 0.002  # what hides leaves nothing behind
    assert case.painted.shown.mean() > 0.99


def test_what_no_camera_saw_is_filled_in_from_around(case: Case) -> None:
    painted = case.painted
    rest = painted.image[~painted.seen]
    low, high = (f(painted.image[painted.seen], axis=0) for f in (np.min, np.max))
    assert (rest >= low).all()
    assert (rest <= high).all()


def test_each_material_has_its_image_and_those_unseen_have_none(tmp_path: Path) -> None:
    """The back is another material, which lies on the same texels in a file of its own."""
    shape = mesh()
    middles = np.array([shape.vertices[face].mean(axis=0) for face in shape.faces])
    of_face = np.where(middles[:, 2] < -0.75, 1, 0).astype(np.int32)
    labels = FaceLabels(("front", "back"), of_face)
    found = paint_it(mesh(labels), tmp_path)
    assert list(found) == ["front"]
    elsewhere = paint_it(mesh(labels, tile=3.0), tmp_path)["front"]  # as tiles of UDIM are
    assert (elsewhere.image != found["front"].image).mean() < 0.01
    assert 0.6 < found["front"].shown.mean() < 0.95


def test_without_texture_coordinates_there_is_none(tmp_path: Path) -> None:
    shape = mesh()
    assert paint_it(em.Mesh(shape.vertices, shape.faces), tmp_path) == {}
