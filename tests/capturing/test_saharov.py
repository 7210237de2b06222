"""Cameras of real photographs: a statue, 32 of 1092 x 728, with cameras that others solved."""

import os
from pathlib import Path

import numpy as np
import pytest

from elastomorph.capturing.cameras.cameras import solve_pose
from elastomorph.capturing.geometry import fit_similarity
from elastomorph.capturing.photographs import examine, find_poses
from needs import extra

extra("pycolmap", "capture")

DATA = Path(os.environ.get("ELASTOMORPH_DATA", "../shared/data")) / "photos" / "saharov32"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.realdata,
    pytest.mark.timeout(2000),
    pytest.mark.skipif(not DATA.is_dir(), reason="needs the photographs of saharov32"),
    pytest.mark.photographs,
]


def reference() -> dict[str, np.ndarray]:
    """Photograph → where it was taken from, by the Bundler file."""
    names = (DATA / "ordered_filenames.txt").read_text().split()[1:]
    lines = (DATA / "cameras.out").read_text().splitlines()[2 : 2 + 5 * len(names)]
    values = np.array(" ".join(lines).split(), dtype=np.float64).reshape(len(names), 15)
    turns, shifts = values[:, 3:12].reshape(-1, 3, 3), values[:, 12:]
    return {name: -turn.T @ shift for name, turn, shift in zip(names, turns, shifts, strict=True)}


def test_real_photographs():
    (paths,) = find_poses(DATA).values()
    photographs = examine("saharov32", paths)
    # The lens of its EXIF, of photographs that were turned upright and reduced to a quarter.
    assert photographs.taken[0].focal == pytest.approx(1519, abs=1)
    assert photographs.taken[0].size == (728, 1092)
    found = solve_pose(photographs)
    assert len(found.cameras) == 32
    assert np.mean(list(found.reprojection.values())) < 0.25
    true = reference()
    goal = np.array([true[camera.name] for camera in found.cameras])
    source = np.array([camera.position for camera in found.cameras])
    off = np.linalg.norm(fit_similarity(source, goal)(source) - goal, axis=1)
    radius = np.linalg.norm(goal - goal.mean(axis=0), axis=1).mean()
    assert off.mean() < 0.009 * radius
    assert np.median(off) < 0.007 * radius
