"""A data set shows its faces on one sheet, whether it holds pictures or not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import zarr
from PIL import Image

import elastomorph as em
from elastomorph.errors import ParameterError
from elastomorph.farm.pictures.painter import Painter
from elastomorph.farm.reading.sheets import sheet_of
from needs import extra

extra("embreex", "farm")

GREEN = [60, 230, 90]


def test_a_data_set_without_pictures_is_drawn_for_the_sheet(rig: em.Rig, tmp_path: Path) -> None:
    recipe = {"camera": {"azimuth": 0}, "background": {"red": 0, "green": 0, "blue": [0.2, 1]}}
    marks = {"middle": 45}
    faces = em.make_faces(rig, tmp_path / "faces.zarr", 40, recipe=recipe, landmarks=marks)
    sheet = sheet_of(faces, tmp_path / "sheet.png", count=3)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "sheet.png")), sheet)
    assert (sheet == GREEN).all(axis=-1).any()
    blue = 255 * faces.values[[0, 19, 39]][:, faces.columns.names.index("background.blue")]
    for own in blue:
        assert (np.abs(sheet - [0.0, 0.0, own]).max(axis=-1) <= 1).sum() > 5000


def test_a_sheet_of_no_faces_is_refused(rig: em.Rig, tmp_path: Path) -> None:
    faces = em.make_faces(rig, tmp_path / "faces.zarr", 5)
    with pytest.raises(ParameterError, match="a sheet needs a face"):
        sheet_of(faces, count=0)


def test_stored_pictures_are_those_of_the_columns_and_shown_as_they_are(
    rig: em.Rig, tmp_path: Path
) -> None:
    marks = {"middle": 45, "corner": 0}
    faces = em.make_faces(
        rig,
        tmp_path / "faces.zarr",
        20,
        recipe={"pictures": {"size": 32}, "landmarks": marks},
        landmarks=marks,
    )
    painter = Painter(rig, (32, 32), marks)
    assert {f"images/{name}" for name in painter.labels} <= set(faces.labels)
    columns = dict(zip(faces.columns.names, faces.values[7:9].T, strict=True))
    for name, own in painter.draw(faces[7:9], columns).items():
        np.testing.assert_array_equal(faces.labels[f"images/{name}"][7:9], own)
    group = zarr.open_group(tmp_path / "faces.zarr", mode="r")["images"]
    assert group["parts"].attrs["names"][:3] == ["background", "skin", "lips"]
    assert group["landmarks"].attrs["names"] == ["middle", "corner"]
    sheet = sheet_of(faces, count=2)
    # Each pixel is shown as a square of seven.
    shown = faces.labels["images/colour"][0].repeat(7, axis=0).repeat(7, axis=1)
    assert (sheet[:, : shown.shape[1] + 8] == shown[0, 0]).all(axis=-1).sum() > 49
