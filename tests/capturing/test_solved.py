"""Solved poses and their file."""

from pathlib import Path

import numpy as np
import pytest

from elastomorph.capturing.cameras.solved import SolvedPose, load_solved, save_solved
from elastomorph.capturing.geometry.camera import Camera
from elastomorph.errors import FileError, FormatError

RANDOM = np.random.default_rng(2)


def a_pose() -> SolvedPose:
    cameras = tuple(
        Camera(
            f"{k}.jpg",
            (300, 400),
            520.0 + k,
            RANDOM.normal(size=2),
            -0.04,
            RANDOM.normal(size=(3, 3)),
            RANDOM.normal(size=3),
        )
        for k in range(3)
    )
    return SolvedPose(
        cameras,
        RANDOM.normal(size=(7, 3)),
        RANDOM.normal(size=(7, 128)).astype(np.float32),
        {"0.jpg": 0.25, "1.jpg": 0.5},
        {"9.jpg": "blurred"},
        {"0.jpg": "X1, 50 mm"},
        ("something",),
    )


def test_a_solved_pose_is_read_as_it_was_written(tmp_path):
    pose = a_pose()
    save_solved(tmp_path / "a.npz", pose)
    found = load_solved(tmp_path / "a.npz")
    for one, other in zip(found.cameras, pose.cameras, strict=True):
        assert (one.name, one.size, one.focal) == (other.name, other.size, other.focal)
        for name in ("centre", "rotation", "translation", "radial"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(found.points, pose.points)
    np.testing.assert_array_equal(found.descriptors, pose.descriptors)
    for name in ("reprojection", "rejected", "lenses", "remarks"):
        assert getattr(found, name) == getattr(pose, name)
    assert found.camera("1.jpg").focal == 521.0
    assert found.camera("9.jpg") is None


@pytest.mark.parametrize("part", [0.0, 0.3, 0.999])
def test_what_is_cut_off_is_refused(tmp_path, part):
    path = tmp_path / "a.npz"
    save_solved(path, a_pose())
    content = path.read_bytes()
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(FormatError, match="delete it"):
        load_solved(path)


def test_other_files_are_refused(tmp_path: Path):
    path = tmp_path / "a.npz"
    np.savez(path, words=np.array("{}"), points=np.zeros((2, 3)))
    with pytest.raises(FormatError, match="delete it"):
        load_solved(path)
    with pytest.raises(FileError):
        load_solved(tmp_path / "none.npz")
