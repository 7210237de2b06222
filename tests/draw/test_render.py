"""One call draws one mesh; the faces people know look like faces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from elastomorph.draw.framing import camera_for
from elastomorph.draw.render import render
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from scenes import seen_at

SIZE = (360, 450)


def test_render_writes_what_it_returns(sphere: Mesh, tmp_path: Path) -> None:
    image = render(sphere, tmp_path / "sphere.png", size=(60, 50), view="three-quarter")
    assert image.shape == (50, 60, 3)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "sphere.png")), image)


def test_nothing_is_written_where_drawing_fails(sphere: Mesh, tmp_path: Path) -> None:
    with pytest.raises(ParameterError):
        render(sphere, tmp_path / "sphere.png", scalars=[1.0, 2.0], size=(20, 20))
    with pytest.raises(ParameterError):
        render(sphere, tmp_path / "sphere.png", view="behind")
    assert not list(tmp_path.iterdir())


def test_the_range_of_a_heat_map_is_fixed(sphere: Mesh) -> None:
    """Half the error on twice the range is half the colour scale: the picture does not change."""
    height = sphere.vertices[:, 1] + 1
    full = render(sphere, scalars=height, highest=2.0, size=(60, 60))
    np.testing.assert_array_equal(
        render(sphere, scalars=height / 2, highest=1.0, size=(60, 60)), full
    )
    other = render(sphere, scalars=height / 2, highest=2.0, size=(60, 60))
    assert np.abs(other.astype(int) - full).max() > 50


def test_the_built_in_head_has_eyes_lips_and_skin() -> None:
    from elastomorph.samples import head

    mesh = head()
    camera = camera_for(mesh, size=SIZE)
    image = render(mesh, size=SIZE, view=camera).astype(int)

    def colour(group: str) -> np.ndarray:
        """Median colour at the foremost vertices of a group."""
        assert mesh.groups is not None
        number = mesh.groups.names.index(group)
        corners = mesh.groups.of_face[mesh.faces.corner_faces] == number
        vertices = np.unique(mesh.faces.indices[corners])
        front = vertices[np.argsort(-mesh.vertices[vertices, 2])[: max(1, len(vertices) // 4)]]
        columns, rows = seen_at(camera, mesh.vertices[front], SIZE).astype(int).T
        return np.median(image[rows, columns], axis=0)

    skin, lips = colour("skin"), colour("lips")
    assert lips[0] - lips[1] > skin[0] - skin[1] + 15
    for side in "LR":
        assert colour(f"pupil_{side}").max() < 80


@pytest.mark.realdata
def test_the_production_head_looks_at_us_through_open_eyes(data_dir: Path) -> None:
    """Its irises lie behind white shells and wet cards, which must not hide them."""
    from elastomorph.io import read

    mesh = read(data_dir / "ict-facekit" / "generic_neutral_mesh.obj")
    camera = camera_for(mesh, size=SIZE)
    image = render(mesh, size=SIZE, view=camera).astype(int)
    for eyeball in (slice(21451, 22221), slice(23021, 23791)):
        points = mesh.vertices[eyeball]
        pole = points[points[:, 2].argmax()]
        ((column, row),) = seen_at(camera, pole, SIZE).astype(int)
        assert image[row - 1 : row + 2, column - 1 : column + 2].max() < 90
        beside = image[row, column - 22 : column + 23]
        assert beside.min(axis=1).max() > 110  # the white of the eye is bright in every colour
