"""Images of the head: made again they are the same, small, and show what they are to show."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest

import elastomorph as em
from elastomorph.samples.built_in_head import SKIN, materials
from needs import extra

pytestmark = pytest.mark.realdata
MOST = 900_000  # bytes of all images together
# Vertices of ICT's face: upper and lower lip, and right and left of the others.
LIPS, CHEEKS, BROWS, FOREHEAD = (5523, 5514), (1154, 3373), (1914, 4114), (2019, 4216)


@pytest.fixture(scope="module")
def painter():
    extra("embreex", "capture")
    import paint_head

    return paint_head


@pytest.fixture(scope="module")
def neutral(data_dir):
    return em.read(data_dir / "ict-facekit" / "generic_neutral_mesh.obj")


@pytest.fixture(scope="module")
def images(painter, neutral):
    return painter.paint(neutral)


def pixels(content):
    from PIL import Image

    with Image.open(BytesIO(content)) as image:
        return np.asarray(image).astype(float)


def colour_at(image, places):
    """The mean colour of 7 × 7 pixels about texture coordinates."""
    height, width = image.shape[:2]
    found = [
        image[row - 3 : row + 4, column - 3 : column + 4, :3].mean(axis=(0, 1))
        for column, row in np.rint([[x * width, (1 - y) * height] for x, y in places]).astype(int)
    ]
    return np.mean(found, axis=0)


def redness(colour):
    return colour[0] / colour[1:].mean()


def test_the_same_head_gives_the_same_bytes(painter, neutral, images):
    assert painter.paint(neutral) == images


def test_images_are_small(images):
    assert sum(map(len, images.values())) <= MOST


def test_skin_has_lips_and_brows(painter, neutral, images):
    skin = pixels(images["skin.jpg"])
    lips, cheeks, brows, forehead = (
        colour_at(skin, painter.places(neutral, vertices))
        for vertices in (LIPS, CHEEKS, BROWS, FOREHEAD)
    )
    assert redness(lips) > 1.1 * redness(cheeks) > redness(forehead)
    assert brows.mean() < 0.7 * forehead.mean()


def test_skin_fades_to_the_colour_of_the_head(painter, neutral, images):
    skin, part = pixels(images["skin.jpg"]), painter.labels(neutral)
    both = set(painter.corners_of(neutral, painter.chosen(part, "skin")).tolist()) & set(
        painter.corners_of(neutral, painter.chosen(part, "head")).tolist()
    )
    own = painter.chosen(part, "skin")[neutral.faces.corner_faces]
    seam = own & np.isin(neutral.faces.indices, list(both))
    across, up = neutral.uv.coordinates[neutral.uv.corners[seam], :2].T * len(skin)
    row, column = (len(skin) - up).astype(int), across.astype(int)
    assert abs(skin[row, column] - SKIN).max() <= 1


def test_pupils_are_black_and_the_eye_is_white_beside(images):
    eye = pixels(images["eye.jpg"])
    assert colour_at(eye, [(0.5, 0.5)]).max() < 12
    assert colour_at(eye, [(0.3, 0.5), (0.7, 0.5)]).min() > 170


def test_every_part_has_a_material_and_every_image_is_shown(painter, neutral, images):
    part, made = painter.labels(neutral), materials(images)
    assert set(part.names) == {*made, "iris", "unseen"}  # which the built-in head leaves out
    assert (part.of_face >= 0).all()
    layers = [each.finish.layers.values() for each in made.values() if each.finish]
    shown = {texture.image for some in layers for texture in some}
    shown |= {each.texture.image for each in made.values() if each.texture}
    assert shown == set(images.values())


def test_the_tongue_is_a_piece_of_its_own(painter, neutral):
    tongue = neutral.vertices[
        painter.corners_of(neutral, painter.chosen(painter.labels(neutral), "tongue"))
    ]
    assert tongue[:, 2].max() < 9.8  # behind the teeth
    np.testing.assert_allclose(tongue[:, 0].min(), -tongue[:, 0].max(), atol=1e-3)
