"""Cameras stand around the head where they were, in their colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.capturing.geometry.camera import Camera
from elastomorph.draw.cameras_picture import cameras_picture
from elastomorph.samples import head
from needs import extra

extra("vtkmodules", "demo")


def around(turns: list[float]) -> list[Camera]:
    """Cameras on a circle of 60 about the head, looking at its middle."""
    found = []
    for number, turn in enumerate(turns):
        c, s = np.cos(turn), np.sin(turn)
        rotation = np.array([[c, 0, -s], [0, -1, 0], [-s, 0, -c]])
        centre = np.array([299.5, 399.5])
        translation = np.array([0.0, -3.0, 60.0])
        found.append(Camera(str(number), (600, 800), 1500.0, centre, 0.0, rotation, translation))
    return found


def test_each_camera_is_at_its_place(tmp_path: Path) -> None:
    """Looked at from the front, cameras to the subject's left are to the right."""
    colours = np.array([[1.0, 0, 0], [0, 0.8, 0], [0, 0, 1.0]])
    file = tmp_path / "a.png"
    cameras = around([-1.2, 0.0, 1.2])
    picture = cameras_picture(head(), cameras, file, colours=colours, view="front", size=(500, 260))
    assert picture.shape == (260, 500, 3)
    assert file.stat().st_size > 1000
    values = picture.astype(int)
    middles = []
    for channel in range(3):
        others = np.delete(values, channel, axis=-1).max(axis=-1)
        mine = (values[..., channel] > 90) & (others < 0.35 * values[..., channel])
        assert mine.sum() > 30
        middles.append(np.nonzero(mine)[1].mean())
    assert middles == sorted(middles)
    assert middles[1] == pytest.approx(250, abs=8)


def test_the_head_is_painted_by_its_vertices() -> None:
    mesh = head()
    shades = np.where(mesh.vertices[:, :1] > 0, [[0.9, 0.1, 0.1]], [[0.1, 0.1, 0.9]])
    picture = cameras_picture(mesh, around([0.5]), shades=shades, view="front", size=(400, 400))
    values = picture.astype(int)
    red = (values[..., 0] > values[..., 2] + 60).nonzero()[1]
    blue = (values[..., 2] > values[..., 0] + 60).nonzero()[1]
    assert len(red) > 200
    assert len(blue) > 200
    assert red.mean() > blue.mean()


def test_mistakes() -> None:
    with pytest.raises(em.ParameterError, match="no cameras"):
        cameras_picture(head(), [])
    with pytest.raises(em.ParameterError, match=r"colours of cameras must be \(2, 3\)"):
        cameras_picture(head(), around([0, 1]), colours=np.zeros((3, 3)))
    with pytest.raises(em.ParameterError, match=r"colours of vertices must be \(5308, 3\)"):
        cameras_picture(head(), around([0, 1]), shades=np.zeros((3, 3)))
