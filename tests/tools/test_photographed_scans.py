"""Scans of a head whose truth is known lie on it, with the colour that it has there."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from needs import extra

extra("cv2", "capture")
extra("embreex", "capture")

from captured.geometry import closest  # noqa: E402
from photographs.backdrop import Backdrop  # noqa: E402
from photographs.rendering import Scene  # noqa: E402
from photographs.scans import scanned  # noqa: E402
from photographs.skin import Skin  # noqa: E402
from photographs.subjects import subject  # noqa: E402

pytestmark = pytest.mark.photographs


@pytest.fixture(scope="module")
def person():
    return subject("small", 1)


@pytest.fixture(scope="module")
def scene(person):
    (vertices,) = person.poses("smile", np.array([0.7]))
    return Scene(person.surface, vertices, Skin(1), Backdrop())


@pytest.fixture(scope="module")
def scan(scene, person):
    return scanned(scene, person.aim, 5, grid=(150, 90), texture=1024)


def nearest(scene, points):
    return closest(points, scene.vertices, scene.surface.triangles)


def test_vertices_lie_on_the_head_but_for_the_noise(scene, person, scan):
    """Along a ray that meets the surface at an angle, so that the distance is a little less."""
    off = nearest(scene, scan.vertices).distances
    assert np.sqrt((off**2).mean()) == pytest.approx(0.013, rel=0.2)
    exact = scanned(scene, person.aim, 5, grid=(150, 90), noise=0, texture=0)
    assert nearest(scene, exact.vertices).distances.max() < 1e-4
    assert exact.texture is None


def test_triangles_face_outward_and_are_not_torn(person, scan):
    corners = scan.vertices[scan.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = np.einsum("na,na->n", normals, corners.mean(axis=1) - person.aim)
    assert (outward > 0).mean() > 0.99
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert sides.max() < 3 * np.median(sides.max(axis=1)) * 1.5
    uv = scan.uv[scan.triangles]
    assert np.ptp(uv[:, :, 0], axis=1).max() < 0.02  # no triangle runs across the whole texture


def test_the_texture_shows_the_skin_of_the_point(scene, scan):
    chosen = np.linspace(0, len(scan.vertices) - 1, 600).astype(int)
    near = nearest(scene, scan.vertices[chosen])
    own = scene.unlit(near.triangles, near.weights.astype(np.float32))
    wanted = np.clip(0.9 * own, 0, 1) ** (1 / 1.4) * 255
    height, width, _ = scan.texture.shape
    u, v = scan.uv[chosen].T
    column = np.clip((u * width).astype(int), 0, width - 1)
    row = np.clip(((1 - v) * height).astype(int), 0, height - 1)
    off = np.abs(scan.texture[row, column] - wanted).mean(axis=1)
    assert np.median(off) < 6
    assert np.corrcoef(scan.texture[row, column][:, 1], wanted[:, 1])[0, 1] > 0.9


def test_a_scan_is_read_as_it_was_written(scan, tmp_path):
    scan.save(tmp_path / "scan.obj")
    read = em.read(tmp_path / "scan.obj")
    np.testing.assert_allclose(read.vertices, scan.vertices, atol=1e-6)
    np.testing.assert_array_equal(read.faces.triangles(), scan.triangles)
    assert (tmp_path / "scan.png").read_bytes().startswith(b"\x89PNG")
    assert "map_Kd scan.png" in (tmp_path / "scan.mtl").read_text()
