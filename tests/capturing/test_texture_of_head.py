"""The texture of a rendered head, whose skin is known wherever it is."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from photographed_head import SESSION, cameras_of

import elastomorph as em
from elastomorph.capturing.geometry import Surface
from elastomorph.capturing.neutral import paint
from elastomorph.model.mesh import Mesh, UVMap
from needs import extra

for module in ("pycolmap", "cv2", "embreex"):
    extra(module, "capture")

import cv2  # noqa: E402

from photographs.sessions import photograph  # noqa: E402
from photographs.skin import Skin  # noqa: E402

pytestmark = [pytest.mark.slow, pytest.mark.photographs, pytest.mark.timeout(1000)]


def unrolled(mesh: Mesh) -> Mesh:
    """A head with texture coordinates of a cylinder around its front."""
    x, y, z = (mesh.vertices - mesh.vertices.mean(axis=0)).T
    u = np.arctan2(x, z + 2) / (2 * np.pi) * 1.5 + 0.5
    v = 0.01 + 0.98 * (y - y.min()) / np.ptp(y)
    faces = mesh.faces
    outside = (u <= 0) | (u >= 1)
    back = np.bincount(faces.corner_faces, outside[faces.indices]) > 0
    corners = np.where(back[faces.corner_faces], -1, faces.indices).astype(np.int32)
    return Mesh(mesh.vertices, faces, UVMap(np.stack([u, v], axis=1), corners))


def fine(values: np.ndarray, where: np.ndarray) -> np.ndarray:
    """(N, 3) logarithms without what changes over more than 25 texels, as light and shade do."""
    weight = where.astype(np.float32)
    logs = np.log(np.maximum(values, 1e-3)).astype(np.float32) * weight[..., None]
    around = (
        cv2.GaussianBlur(logs, (0, 0), 12)
        / np.maximum(cv2.GaussianBlur(weight, (0, 0), 12), 1e-3)[..., None]
    )
    return (logs - around)[where]


def test_pores_and_freckles_are_where_they_are_and_of_their_colour() -> None:
    with TemporaryDirectory() as place:
        folder = Path(place)
        truth = photograph(SESSION, folder)
        shape = unrolled(em.read(folder / "template.obj"))
        surface = Surface(truth.vertices["p00"][truth.of_template], shape.faces.triangles())
        cameras = cameras_of(truth, SESSION)
        files = {name: folder / "p00" / name for name in truth.files}
        everywhere = np.arange(len(shape.vertices))
        (painted,) = paint(shape, surface, everywhere, cameras, files).values()
    # Where each texel is on the true skin, of the forehead and the cheeks, told by another mesh.
    side = len(painted.image)
    uv = shape.uv
    assert uv is not None
    tall, wide = np.mgrid[0:side, 0:side]
    region = painted.seen & (abs(tall / side - 0.19) < 0.09) & (abs(wide / side - 0.5) < 0.3)
    rays = np.stack([wide[region] + 0.5, tall[region] + 0.5, -np.ones(region.sum())], axis=1)
    triangles = shape.faces.triangle_corners()
    triangles = triangles[(uv.corners[triangles] >= 0).all(axis=1)]
    flat = uv.coordinates[uv.corners[triangles]].reshape(-1, 2) * [1, -1] + [0, 1]
    sheet = Surface(
        np.concatenate([side * flat, np.zeros((len(flat), 1))], axis=1),
        np.arange(len(flat)).reshape(-1, 3),
    )
    hits = sheet.cast(rays, np.broadcast_to([0.0, 0, 1], rays.shape))
    corners = surface.vertices[shape.faces.indices[triangles]][hits.triangles]
    points = np.einsum("ni,nij->nj", hits.weights, corners).astype(np.float32)
    nothing = np.zeros((len(points), 2), dtype=np.float32)
    skin = Skin(SESSION.seed, SESSION.texture)
    true = np.zeros((side, side, 3))
    true[region] = skin.colours(points, np.zeros(len(points), dtype=np.int8), nothing)[0]
    shown = (painted.image / 255) ** 1.4  # as the renderer's film has it
    ours, theirs = fine(shown, region), fine(true, region)
    for channel in range(3):
        assert np.corrcoef(ours[:, channel], theirs[:, channel])[0, 1] > 0.7
    assert np.median(abs(ours - theirs), axis=0).max() < 0.03
    level = np.median(shown[region] / true[region], axis=0)
    np.testing.assert_allclose(level / level.mean(), 1, atol=0.03)  # no tint
