"""Combinations of weights, and files of many faces."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.io.npz.mesh import write_face_array
from elastomorph.io.sequences import write_face_files
from elastomorph.rig import Rig
from elastomorph.rig.sliders import spread_rows, weight_combinations


def test_the_paper_has_7775() -> None:
    rows = weight_combinations(5)
    assert rows.shape == (6**5 - 1, 5)
    assert rows.any(axis=1).all()
    assert len(np.unique(rows, axis=0)) == len(rows)
    np.testing.assert_allclose(np.unique(rows), [0, 0.2, 0.4, 0.6, 0.8, 1.0])


def test_small_cases_in_order() -> None:
    expected = list(itertools.product((0, 0.5, 1), repeat=2))[1:]
    np.testing.assert_array_equal(weight_combinations(2, 3), expected)
    with pytest.raises(em.ParameterError, match="fewer expressions"):
        weight_combinations(20)
    with pytest.raises(em.ParameterError, match="at least 1"):
        weight_combinations(0)


def test_spread_rows_hold_both_ends() -> None:
    rows = spread_rows(7775, 50)
    assert (rows[0], rows[-1], len(rows)) == (0, 7774, 50)
    assert spread_rows(3, 50).tolist() == [0, 1, 2]


def test_faces_are_written_block_by_block(small: Rig, tmp_path: Path) -> None:
    rows = weight_combinations(3, 3)
    whole = small.batch(rows, 0.5)
    shape = (len(rows), 10, 3)
    write_face_array(tmp_path / "f.npy", small.stream(rows, 0.5, block=4), shape)
    np.testing.assert_allclose(np.load(tmp_path / "f.npy"), whole, atol=2e-6)
    write_face_array(
        tmp_path / "f.npz", small.stream(rows, 0.5, block=5), shape, beside={"weights": rows}
    )
    with np.load(tmp_path / "f.npz") as archive:
        np.testing.assert_allclose(archive["vertices"], whole, atol=2e-6)
        np.testing.assert_array_equal(archive["weights"], rows)


def test_too_few_faces_leave_no_file(small: Rig, tmp_path: Path) -> None:
    for name in ("f.npy", "f.npz"):
        with pytest.raises(em.FormatError, match="were expected"):
            write_face_array(tmp_path / name, small.stream(np.zeros((2, 3)), 0.5), (3, 10, 3))
    with pytest.raises(em.FormatError, match=r"\.npy or \.npz"):
        write_face_array(tmp_path / "f.obj", [], (0, 10, 3))
    assert not list(tmp_path.iterdir())


def test_faces_as_files(small: Rig, tmp_path: Path) -> None:
    rows = weight_combinations(3, 2)
    pattern = tmp_path / "face.##.ply"
    assert write_face_files(pattern, small.neutral, small.stream(rows, 0.5, block=3)) == 7
    for number, row in enumerate(rows, start=1):
        face = em.read(tmp_path / f"face.{number:02d}.ply")
        expected = small.blend(dict(zip("abc", row.tolist(), strict=True)), 0.5)
        np.testing.assert_allclose(face.vertices, expected, atol=1e-5)
    with pytest.raises(em.FileError, match="does not exist"):
        write_face_files(tmp_path / "no" / "face.##.ply", small.neutral, [])
