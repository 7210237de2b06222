"""Surfaces whose looks are known: square cards with images, and a figure of two balls."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import elastomorph as em
from elastomorph.draw.stage import BACKGROUND
from elastomorph.model.mesh import FaceLabels, Material, Mesh, Texture, UVMap
from scenes import ball, joined

FLAT = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
TRIANGLES = [[0, 1, 2], [0, 2, 3]]
UV = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
RED, GREEN, BLUE, WHITE = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)
PIXELS = [[RED, GREEN], [BLUE, WHITE]]
PAPER = tuple(round(255 * part) for part in BACKGROUND)
BOTH = [*TRIANGLES, [4, 5, 6], [4, 6, 7]]
BACK = [[0, 2, 1], [0, 3, 2]]


def image_of(pixels: Any = PIXELS, kind: str = "PNG", **settings: Any) -> bytes:
    file = io.BytesIO()
    Image.fromarray(np.array(pixels, dtype=np.uint8)).save(file, kind, **settings)
    return file.getvalue()


def texture(pixels: Any = PIXELS, **fields: Any) -> Texture:
    return Texture(image_of(pixels), "squares", smooth=False, **fields)


def unlit(shown: Texture | None = None, **fields: Any) -> Material:
    return Material(texture=shown, unlit=True, **fields)


def card(material: Material | None, faces: Any = TRIANGLES, uv: NDArray[np.float64] = UV) -> Mesh:
    """A square of 2 × 2 in the plane of the picture."""
    corners = np.array(faces, dtype=np.int32).reshape(-1)
    return Mesh(
        FLAT,
        faces,
        uv=UVMap(uv, corners),
        materials=FaceLabels(("card",), np.zeros(2, dtype=np.int32)),
        appearance={} if material is None else {"card": material},
    )


def character(*, dressed: bool = True) -> em.Rig:
    """A head on a long body, each a ball; a target opens the lower half of the head."""
    head, body = ball(), ball()
    whole = joined(
        head=head.with_vertices(head.vertices + [0, 6, 0]),
        body=body.with_vertices(body.vertices * [1, 5, 1]),
    )
    mesh = Mesh(whole.vertices, whole.faces, appearance={} if dressed else None)
    moved = mesh.vertices.copy()
    lower = (moved[:, 1] < 6) & (moved[:, 1] >= 5) & (np.arange(len(moved)) < len(head.vertices))
    moved[lower] -= [0.0, 0.2, 0.0]
    upper = (moved[:, 1] > 6.5) & (np.arange(len(moved)) < len(head.vertices))
    moved[upper] += [0.0, 0.1, 0.0]
    return em.Rig(mesh, {"open": mesh.with_vertices(moved)}, method="linear")
