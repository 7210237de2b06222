"""Photographs that mapping passed over."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from spotted import cameras, centres_off, egg, finder, seen, taken

import elastomorph.capturing.cameras.cameras as module
from elastomorph.capturing.cameras.cameras import found_late
from elastomorph.capturing.cameras.exact import Shots, Sparse
from elastomorph.capturing.cameras.features import Features
from needs import extra

extra("pycolmap", "capture")

CAMERAS = cameras()
VIEWS = [seen(camera, egg(), k) for k, camera in enumerate(CAMERAS)]


@pytest.fixture
def mapped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Sparse, Shots]:
    views = {camera.name: view for camera, view in zip(CAMERAS, VIEWS, strict=True)}
    monkeypatch.setattr(module, "find_features", finder({"neutral": views}))
    finding = module._Finder(taken(CAMERAS), None, lambda text, part: None)
    return finding.rough(tmp_path), finding.shots


def without(sparse: Sparse, photograph: int) -> Sparse:
    kept = sparse.seen[:, 0] != photograph
    gone = tuple(None if k == photograph else c for k, c in enumerate(sparse.cameras))
    return replace(sparse, cameras=gone, owners=sparse.owners[kept], seen=sparse.seen[kept])


def test_a_photograph_that_was_passed_over_is_placed_by_the_points(mapped):
    sparse, shots = mapped
    assert found_late(sparse, VIEWS, VIEWS, shots) is sparse
    found = found_late(without(sparse, 5), VIEWS, VIEWS, shots)
    assert found.found == len(CAMERAS)
    assert centres_off([c for c in found.cameras if c is not None], CAMERAS) < 0.1
    camera = found.cameras[5]
    assert camera is not None
    pixels = camera.distorted(camera.project(found.seen_by(5))[0])
    where = VIEWS[5].places[found.seen[found.seen[:, 0] == 5, 1]]
    assert np.median(np.linalg.norm(pixels - where, axis=1)) < 1


def test_one_of_something_else_stays_out(mapped):
    sparse, shots = mapped
    other: list[Features] = list(VIEWS)
    other[5] = seen(CAMERAS[5], egg(9), 5)
    left = without(sparse, 5)
    assert found_late(left, VIEWS, other, shots).cameras[5] is None
