"""What the stage draws is where and what it should be."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from elastomorph.draw.camera import Camera, camera_for
from elastomorph.draw.pictures import COLOUR_MAP, heat_colours
from elastomorph.draw.stage import BACKGROUND, Lines, Stage, render
from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.mesh import FaceLabels, Mesh
from scenes import ball, joined, seen_at

SIZE = (160, 200)
PAPER = np.rint(np.array(BACKGROUND) * 255)
FLAT = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])


def _covered(image: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Pixels that are not background, give or take rounding."""
    return (np.abs(image.astype(float) - PAPER) > 2).any(axis=2)


def _pixel(image: NDArray[np.uint8], camera: Camera, point: list[float]) -> NDArray[np.int64]:
    ((column, row),) = seen_at(camera, np.array(point), (image.shape[1], image.shape[0]))
    return image[int(row), int(column)].astype(int)


def test_a_sphere_is_centred_and_fills_the_width_but_for_the_margin(sphere: Mesh) -> None:
    camera = Camera.framing(sphere.vertices, size=SIZE, margin=0.1)
    with Stage(sphere, camera, size=SIZE) as stage:
        image = stage.picture()
    assert image.shape == (200, 160, 3)
    assert image.dtype == np.uint8
    rows, columns = np.nonzero(_covered(image))
    assert columns.min() == pytest.approx(16, abs=1.5)
    assert columns.max() == pytest.approx(143, abs=1.5)
    assert rows.min() + rows.max() == pytest.approx(199, abs=1.5)
    # the silhouette is a disc: its area and its box agree
    assert _covered(image).sum() == pytest.approx(np.pi / 4 * 128**2, rel=0.03)


def test_the_same_scene_gives_the_same_picture(sphere: Mesh) -> None:
    with Stage(sphere, size=SIZE) as stage:
        first = stage.picture()
        stage.picture(sphere.vertices * 0.5, wireframe=True)
        np.testing.assert_array_equal(stage.picture(), first)
    with Stage(sphere, size=SIZE) as stage:
        np.testing.assert_array_equal(stage.picture(), first)


def test_a_mesh_far_from_the_origin_and_of_any_scale_looks_the_same(sphere: Mesh) -> None:
    far = sphere.with_vertices(sphere.vertices * 0.001 + [70.0, -50.0, 90.0])
    with Stage(sphere, size=SIZE) as here, Stage(far, size=SIZE) as there:
        difference = np.abs(here.picture().astype(int) - there.picture().astype(int))
    assert np.percentile(difference, 99) <= 2


def test_polygons_of_any_size_are_filled() -> None:
    """A hexagon covers 3/4 of the area of the box around it."""
    turn = np.arange(6) * np.pi / 3
    hexagon = Mesh(np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1), [list(range(6))])
    camera = Camera.framing(hexagon.vertices, size=SIZE)
    with Stage(hexagon, camera, size=SIZE) as stage:
        covered = _covered(stage.picture())
    width, height = (np.ptp(np.nonzero(covered)[axis]) + 1 for axis in (1, 0))
    assert covered.sum() == pytest.approx(0.75 * width * height, rel=0.02)


def test_the_highest_value_has_the_last_colour_of_the_map(sphere: Mesh) -> None:
    last = np.rint(np.array(matplotlib.colormaps[COLOUR_MAP](1.0)[:3]) * 255)
    colours = heat_colours(np.full(len(sphere.vertices), 7.0), 7.0)
    with Stage(sphere, size=SIZE) as stage:
        image = stage.picture(colours=colours, lit=False)
    inside = image[80:120, 60:100].reshape(-1, 3)
    np.testing.assert_array_equal(inside, np.broadcast_to(last, inside.shape))


def test_colours_belong_to_their_vertices() -> None:
    """Red, green, blue and white corners of a square stay in their corners, whoever shares it."""
    mesh = Mesh(FLAT, [[0, 1, 2, 3]])
    colours = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    camera = Camera.framing(FLAT, size=(100, 100), margin=0.05)
    with Stage(mesh, camera, size=(100, 100)) as stage:
        image = stage.picture(colours=colours, lit=False)
    for corner, colour in zip(FLAT, colours, strict=True):
        near = _pixel(image, camera, (corner * 0.97).tolist())
        np.testing.assert_allclose(near, colour * 255, atol=12)


def test_a_pose_moves_what_is_drawn(sphere: Mesh) -> None:
    camera = Camera.framing([[-2.0, -2, 0], [2, 2, 0]], size=(100, 100))
    with Stage(sphere, camera, size=(100, 100)) as stage:
        aside = _covered(stage.picture(sphere.vertices + [1.0, 0, 0]))
    (centre,) = seen_at(camera, np.array([1.0, 0, 0]), (100, 100))
    assert np.nonzero(aside)[1].mean() == pytest.approx(centre[0], abs=1)


def test_light_comes_from_above_the_left_of_the_camera(sphere: Mesh) -> None:
    with Stage(sphere, size=SIZE) as stage:
        image = stage.picture().astype(int)
    assert image[70, 50].sum() > image[130, 110].sum() + 60


def test_hidden_pieces_leave_no_trace() -> None:
    head = ball()
    mesh = joined(skin=head, EyeOcclusion=ball(0.4, (0, 0, 1.0)))
    camera = Camera.framing(head.vertices, size=SIZE)
    with Stage(mesh, camera, size=SIZE) as with_shell, Stage(head, camera, size=SIZE) as without:
        np.testing.assert_array_equal(with_shell.picture(), without.picture())


def test_parts_have_their_own_colours() -> None:
    mesh = joined(skin=ball(0.5, (-0.6, 0, 0)), lips=ball(0.5, (0.6, 0, 0)))
    camera = camera_for(mesh, size=SIZE)
    with Stage(mesh, camera, size=SIZE) as stage:
        image = stage.picture(lit=False)
    skin, lips = (_pixel(image, camera, [x, 0.0, 0.5]) for x in (-0.6, 0.6))
    assert lips[0] - lips[1] > skin[0] - skin[1] + 20  # redder


def test_a_white_eyeball_looks_at_us() -> None:
    mesh = joined(eye=ball())
    camera = camera_for(mesh, size=SIZE)
    with Stage(mesh, camera, size=SIZE) as stage:
        image = stage.picture(lit=False)
    assert _pixel(image, camera, [0.0, 0.0, 1.0]).max() < 20
    assert _pixel(image, camera, [0.8, 0.0, 0.6]).min() > 220


def test_lines_are_seen_in_front_and_hidden_behind(sphere: Mesh) -> None:
    near, far = (int((sphere.vertices[:, 2] * sign).argmax()) for sign in (1, -1))
    edges = sphere.edges
    red = np.array([[1.0, 0.0, 0.0]])
    camera = Camera.framing(sphere.vertices, size=SIZE)
    found = []
    with Stage(sphere, camera, size=SIZE) as stage:
        for pole in (near, far):
            paths = edges[(edges == pole).any(axis=1)]
            line = Lines(paths, red.repeat(len(paths), axis=0), 3.0)
            image = stage.picture(lines=[line]).astype(int)
            found.append(((image[..., 0] > 200) & (image[..., 1] < 60)).sum())
        bare = stage.picture().astype(int)
    assert found[0] > 50
    assert found[1] == 0
    assert not ((bare[..., 0] > 200) & (bare[..., 1] < 60)).any()  # lines do not stay


def test_a_wireframe_draws_the_edges_of_polygons_and_no_diagonals() -> None:
    mesh = Mesh(FLAT, [[0, 1, 2, 3]])
    camera = Camera.framing(FLAT, size=(100, 100), margin=0.1)
    with Stage(mesh, camera, size=(100, 100), supersampling=4) as stage:
        plain, wired = (stage.picture(wireframe=on).astype(int) for on in (False, True))
    changed = np.abs(plain - wired).max(axis=2) > 10
    assert changed[8:12].any()  # the upper edge, at row 10
    assert not changed[20:80, 20:80].any()


def test_what_cannot_be_drawn_is_refused(sphere: Mesh) -> None:
    with pytest.raises(MeshError, match="polygons"):
        Stage(Mesh(FLAT))
    with pytest.raises(ParameterError, match="supersampling"):
        Stage(sphere, supersampling=0)
    with pytest.raises(ParameterError, match="size"):
        Stage(sphere, Camera.framing(FLAT), size=(0, 5))
    with Stage(sphere, size=(20, 20)) as stage:
        with pytest.raises(MeshError, match="4"):
            stage.picture(FLAT)
        with pytest.raises(MeshError, match="finite"):
            stage.picture(np.full_like(sphere.vertices, np.nan))
        with pytest.raises(ParameterError, match="colours"):
            stage.picture(colours=np.full((len(sphere.vertices), 3), 2.0))


def test_labels_do_not_change_the_shading_across_their_border() -> None:
    """Lips and skin are one surface: the normals do not know where the paint changes."""
    mesh = ball()
    half = (np.arange(len(mesh.faces)) % 2).astype(np.int32)
    striped = Mesh(mesh.vertices, mesh.faces, groups=FaceLabels(("skin", "cheek"), half))
    with Stage(mesh, size=SIZE) as plain, Stage(striped, size=SIZE) as other:
        np.testing.assert_array_equal(plain.picture(), other.picture())


HEAD_SIZE = (360, 450)


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
    from small_head import head

    mesh = head()
    camera = camera_for(mesh, size=HEAD_SIZE)
    image = render(mesh, size=HEAD_SIZE, view=camera).astype(int)

    def colour(group: str) -> np.ndarray:
        """Median colour at the foremost vertices of a group."""
        assert mesh.groups is not None
        number = mesh.groups.names.index(group)
        corners = mesh.groups.of_face[mesh.faces.corner_faces] == number
        vertices = np.unique(mesh.faces.indices[corners])
        front = vertices[np.argsort(-mesh.vertices[vertices, 2])[: max(1, len(vertices) // 4)]]
        columns, rows = seen_at(camera, mesh.vertices[front], HEAD_SIZE).astype(int).T
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
    camera = camera_for(mesh, size=HEAD_SIZE)
    image = render(mesh, size=HEAD_SIZE, view=camera).astype(int)
    for eyeball in (slice(21451, 22221), slice(23021, 23791)):
        points = mesh.vertices[eyeball]
        pole = points[points[:, 2].argmax()]
        ((column, row),) = seen_at(camera, pole, HEAD_SIZE).astype(int)
        assert image[row - 1 : row + 2, column - 1 : column + 2].max() < 90
        beside = image[row, column - 22 : column + 23]
        assert beside.min(axis=1).max() > 110  # the white of the eye is bright in every colour
