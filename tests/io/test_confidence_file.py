"""Confidences of poses come back as they were written; what is none is refused by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io.npz.confidence import confidence_beside, read_confidence, write_confidence


def test_what_is_written_is_read(tmp_path: Path) -> None:
    poses = {"p00": np.linspace(0, 1, 7), "smile 1": np.full(7, 0.3)}
    write_confidence(tmp_path / "confidence.npz", poses)
    found = read_confidence(tmp_path / "confidence.npz", 7)
    assert list(found) == ["p00", "smile 1"]
    for name, values in poses.items():
        np.testing.assert_array_equal(found[name], values.astype(np.float32))
        assert found[name].dtype == np.float32


def test_that_of_numpy_is_read_too(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "a.npz", p00=np.ones(3, np.float64))
    assert read_confidence(tmp_path / "a.npz")["p00"].tolist() == [1, 1, 1]


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"p00": np.ones(6, np.float32)}, r"'p00' has the shape \(6,\), expected \(7,\)"),
        ({"p00": np.ones((7, 1), np.float32)}, r"has the shape \(7, 1\)"),
        ({"p00": np.ones(7, np.int64)}, "has the type int64"),
        ({"p00": np.float32([1, 1, 1.5, 1, 1, 1, 1])}, "from 0 to 1, found 1.5 for vertex 2"),
        ({"p00": np.float32([1, 1, 1, 1, -0.1, 1, 1])}, "found -0.1 for vertex 4"),
        ({"p00": np.float32([np.nan] * 7)}, "found nan for vertex 0"),
        ({}, "it holds no array"),
    ],
)
def test_other_arrays_are_refused(tmp_path: Path, arrays: dict[str, Any], said: str) -> None:
    path = tmp_path / "confidence.npz"
    np.savez(path, **arrays)
    with pytest.raises(FormatError, match=said) as caught:
        read_confidence(path, 7)
    assert str(path) in str(caught.value)


def test_poses_of_different_lengths_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", a=np.ones(3, np.float32), b=np.ones(4, np.float32))
    with pytest.raises(FormatError, match=r"'b' has the shape \(4,\), expected \(3,\)"):
        read_confidence(tmp_path / "a.npz")


@pytest.mark.parametrize(
    "poses", [{}, {"a": [1.0], "b": [1.0, 0.5]}, {"a": [2.0]}, {"a": [[1.0]]}, {"a": ["x"]}]
)
def test_nothing_else_is_written(tmp_path: Path, poses: Any) -> None:
    with pytest.raises(ParameterError):
        write_confidence(tmp_path / "a.npz", poses)
    assert not list(tmp_path.iterdir())


def test_a_file_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "a.npz").write_text("no archive")
    with pytest.raises(FormatError, match="not an intact archive"):
        read_confidence(tmp_path / "a.npz")
    with pytest.raises(FileError):
        read_confidence(tmp_path / "b.npz")


@pytest.mark.parametrize("pattern", ["", "scan.####.obj", "scan.*.obj"])
def test_it_lies_beside_the_poses(tmp_path: Path, pattern: str) -> None:
    assert confidence_beside(tmp_path / pattern) is None
    write_confidence(tmp_path / "confidence.npz", {"a": [1.0]})
    assert confidence_beside(tmp_path / pattern) == tmp_path / "confidence.npz"


def test_an_archive_has_none_beside_it(tmp_path: Path) -> None:
    write_confidence(tmp_path / "confidence.npz", {"a": [1.0]})
    np.savez(tmp_path / "take.npz", frames=np.zeros((2, 1, 3)))
    assert confidence_beside(tmp_path / "take.npz") is None


def test_a_folder_of_poses_is_a_motion_and_a_rig_with_it(tmp_path: Path) -> None:
    """It is no mesh, though its suffix is that of an archive of one."""
    square = em.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    for number, name in enumerate(("neutral_0", "smile_1")):
        moved = square.with_vertices(square.vertices * [1, 1 + number, 1])
        em.write(tmp_path / f"{name}.obj", moved)
    write_confidence(tmp_path / "confidence.npz", {"neutral_0": np.ones(4), "smile_1": np.ones(4)})
    assert em.read_sequence(tmp_path).names == ("neutral_0.obj", "smile_1.obj")
    assert list(em.read_rig(tmp_path).morphs) == ["smile_1"]
