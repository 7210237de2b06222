"""Labels of pictures are right to the pixel, and the same wherever they are made."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import elastomorph as em
from children import started
from elastomorph.capturing.geometry import Surface
from elastomorph.draw.materials import parts_of
from elastomorph.farm.pictures.painter import Painter
from elastomorph.farm.pictures.settings import SETTINGS
from needs import extra
from small_head import expressions, head, landmarks

extra("embreex", "farm")

SIZE = (112, 96)
FACES = 3
VALUES = {
    "head.yaw": [0.0, 25.0, -30.0],
    "head.pitch": [0.0, -8.0, 10.0],
    "head.x": [0.0, 0.05, 0.0],
    "camera.azimuth": [0.0, 10.0, -5.0],
    "camera.roll": [0.0, -5.0, 4.0],
    "camera.distance": [4.0, 2.5, 6.0],
    "camera.fill": [0.8, 0.9, 0.7],
    "light.azimuth": [30.0, -50.0, 60.0],
    "light.temperature": [6500.0, 3500.0, 9000.0],
}

Arrays = Mapping[str, NDArray[Any]]


def rig() -> em.Rig:
    return em.Rig(head(), {"grinning": expressions()["grinning"]}, method="linear")


def positions(of: em.Rig) -> NDArray[np.float32]:
    return of.batch(np.linspace(0, 1, FACES)[:, None])


@pytest.fixture(scope="module")
def painter() -> Painter:
    own = rig()
    return Painter(own, SIZE, landmarks())


@pytest.fixture(scope="module")
def poses() -> NDArray[np.float32]:
    return positions(rig())


@pytest.fixture(scope="module")
def drawn(painter: Painter, poses: NDArray[np.float32]) -> Arrays:
    return painter.draw(poses, VALUES)


def digest(drawn: Arrays) -> str:
    return hashlib.blake2b(b"".join(drawn[name].tobytes() for name in sorted(drawn))).hexdigest()


def in_pixels(drawn: Arrays, face: int, points: NDArray[Any]) -> tuple[Any, Any]:
    """(N, 2) places and (N,) depths of points of the rig, by the arrays of cameras alone."""
    for name in ("head", "camera"):
        points = points @ drawn[name][face, :, :3].T + drawn[name][face, :, 3]
    seen = points @ drawn["intrinsics"][face].T
    return seen[:, :2] / seen[:, 2:], seen[:, 2]


def surface_points(drawn: Arrays, face: int) -> tuple[NDArray[np.bool_], NDArray[Any]]:
    """(H, W) where something is, and (H, W, 3) what depth says is there, in the camera's axes."""
    depth = drawn["depth"][face].astype(float)
    y, x = np.indices(SIZE)
    rays = np.stack([x, y, np.ones(SIZE)], axis=-1) @ np.linalg.inv(drawn["intrinsics"][face]).T
    return depth > 0, rays * depth[..., None]


@pytest.mark.parametrize("face", range(FACES))
def test_depth_put_back_into_space_lies_on_the_surface(
    drawn: Arrays, poses: NDArray[np.float32], face: int
) -> None:
    there, points = surface_points(drawn, face)
    own = points[there][::23]
    for name in ("camera", "head"):
        own = (own - drawn[name][face, :, 3]) @ drawn[name][face, :, :3]
    surface = Surface(poses[face].astype(float), head().faces.triangles())
    assert 0.2 < there.mean() < 0.9
    assert surface.closest(own).distances.max() < 1e-5 * head().diameter


@pytest.mark.parametrize("face", range(FACES))
def test_normals_agree_with_depth(drawn: Arrays, face: int) -> None:
    """But for edges, and as far as polygons agree with the smooth surface they stand for."""
    there, points = surface_points(drawn, face)
    across, down = (np.gradient(points, axis=axis) for axis in (1, 0))
    flat = np.cross(down, across)
    flat /= np.maximum(np.linalg.norm(flat, axis=-1, keepdims=True), 1e-30)
    normals = drawn["normals"][face] / 127
    lengths = np.linalg.norm(normals, axis=-1)
    assert np.abs(lengths[there] - 1).max() < 0.01
    assert not lengths[~there].any()
    cosine = (flat * normals).sum(axis=-1)
    inside = there.copy()
    for axis in (0, 1):
        inside &= np.roll(there, 1, axis) & np.roll(there, -1, axis)
    assert np.median(cosine[inside]) > np.cos(np.radians(4))
    assert (cosine[inside] > np.cos(np.radians(25))).mean() > 0.9
    # Towards the camera, along the ray that sees them.
    assert ((normals * points).sum(axis=-1)[there] < 0.01 * points[there][:, 2]).all()


@pytest.mark.parametrize("face", range(FACES))
def test_landmarks_are_where_the_cameras_put_their_vertices(
    drawn: Arrays, poses: NDArray[np.float32], painter: Painter, face: int
) -> None:
    marks = landmarks()
    assert list(marks) == painter.labels["landmarks"][2]["names"]
    places, depths = in_pixels(drawn, face, poses[face][list(marks.values())])
    found = drawn["landmarks"][face]
    np.testing.assert_allclose(found[:, :2], places, atol=1e-3)
    seen = found[:, 2] == 1
    assert seen.sum() >= 8
    column, row = np.rint(found[seen, :2]).astype(int).T
    depth = drawn["depth"][face, row, column]
    on_contour = depth == 0  # half a pixel aside
    assert on_contour.sum() <= 2
    assert np.abs(depth - depths[seen])[~on_contour].max() < 0.05 * head().diameter
    assert seen[list(marks).index("nose_tip")]


def test_a_landmark_behind_the_face_is_hidden(painter: Painter, poses: NDArray[Any]) -> None:
    names = painter.labels["landmarks"][2]["names"]
    aside = painter.draw(poses[:1], {"head.yaw": [80.0]})["landmarks"][0, :, 2]
    seen = {name for name, own in zip(names, aside, strict=True) if own}
    assert {"mouth_right", "right_jaw"} <= seen
    assert not {"left_eye_outer", "left_eye_inner", "left_jaw", "left_nostril"} & seen
    away = painter.draw(poses[:1], {"camera.x": [3.0]})
    assert not away["landmarks"][0, :, 2].any()
    assert not away["depth"].any()


@pytest.mark.parametrize("face", range(FACES))
def test_parts_are_those_of_the_vertices_that_are_seen(
    drawn: Arrays, poses: NDArray[np.float32], painter: Painter, face: int
) -> None:
    """Of vertices that only one part touches, some of every part that faces the camera."""
    names = painter.labels["parts"][2]["names"]
    faces = head().faces
    of_face = np.zeros(len(faces), dtype=int)
    for name, polygons in parts_of(head()).items():
        of_face[polygons] = names.index(name)
    of_corner, vertices = of_face[faces.corner_faces], faces.indices
    least, most = np.full(len(poses[0]), 99), np.zeros(len(poses[0]), dtype=int)
    np.minimum.at(least, vertices, of_corner)
    np.maximum.at(most, vertices, of_corner)
    places, depths = in_pixels(drawn, face, poses[face])
    column, row = np.rint(places).astype(int).T
    inside = (column >= 0) & (column < SIZE[1]) & (row >= 0) & (row < SIZE[0]) & (least == most)
    column, row, own, far = (each[inside] for each in (column, row, least, depths))
    close = np.abs(drawn["depth"][face, row, column] - far) < 2e-3 * head().diameter
    right = drawn["parts"][face, row, column][close] == own[close]
    assert right.mean() > 0.97
    assert {names[part] for part in own[close][right]} >= {"skin", "lips", "sclera", "iris"}
    there = drawn["depth"][face] > 0
    np.testing.assert_array_equal(drawn["parts"][face] > 0, there)


def test_edges_of_colour_are_smooth_and_those_of_labels_are_not(drawn: Arrays) -> None:
    """A pixel whose middle sees the background may show some skin, one farther off shows none."""
    colours = drawn["colour"][0].astype(int)
    apart = np.abs(colours - colours[0, 0]).sum(axis=-1)
    there = drawn["depth"][0] > 0
    beside, near = there.copy(), there.copy()
    for shift in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        beside |= np.roll(there, shift, (0, 1))
    for shift in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        near |= np.roll(beside, shift, (0, 1))
    assert np.abs(colours[0, 0] - 0.6 * 255).max() < 1
    assert not apart[~near].any()
    mixed = apart[beside & ~there]
    assert 0.2 < (mixed > 6).mean() < 0.8
    assert set(np.unique(drawn["parts"][0][~there])) == {0}


def test_same_bytes_alone_together_and_in_another_process(
    painter: Painter, poses: NDArray[np.float32], drawn: Arrays
) -> None:
    values = {name: np.array(own) for name, own in VALUES.items()}
    alone = painter.draw(poses[1:2], {name: own[1:2] for name, own in values.items()})
    for name, own in alone.items():
        np.testing.assert_array_equal(own[0], drawn[name][1])
    code = (
        "from test_pictures_of_faces import *\n"
        "own = rig()\n"
        "painter = Painter(own, SIZE, landmarks())\n"
        "print(digest(painter.draw(positions(own), VALUES)))"
    )
    places = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with started("-c", code, stdout=subprocess.PIPE, env=places) as process:
        told = process.communicate(timeout=100)[0]
    assert told.strip() == digest(drawn)


def test_labels_say_shapes_and_types(painter: Painter, drawn: Arrays) -> None:
    assert set(painter.labels) == set(drawn)
    for name, (shape, kind, meaning) in painter.labels.items():
        assert drawn[name].shape == (FACES, *shape)
        assert drawn[name].dtype == kind
        assert json.loads(json.dumps(meaning)) == meaning
    only = Painter(rig(), SIZE, arrays=("parts", "landmarks"))
    assert set(only.draw(head().vertices[None], {})) == {"parts"}


def test_settings_are_within_their_limits() -> None:
    for name, own in SETTINGS.items():
        assert own.least <= own.low <= own.high <= own.most, name
        assert own.least <= own.rest <= own.most, name
