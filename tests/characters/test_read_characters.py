"""`read_rig` places every vertex of a character where the specification places it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from acceptance.expected import Face
from acceptance.gltf_file import GltfFile
from acceptance.posing import Scene
from character_makers import RECIPES, TARGETS, make


@pytest.mark.parametrize("name", [name for name in RECIPES if name != "twice"])
def test_a_rig_stands_where_its_nodes_and_joints_hold_it(name: str, tmp_path: Path) -> None:
    """Skins at rest, posed since they were bound, in other units, quantised: one formula for all.

    Primitives that share their vertices are one surface to the reader and several to the formula.
    """
    path = make(name, tmp_path)
    rig = em.read_rig(path)
    face = Face.of(Scene(GltfFile.read(path)))
    assert set(rig.morphs) == set(TARGETS) == set(face.targets)
    ours = np.unique(np.round(face.neutral / (1e-6 * face.extent)), axis=0)
    body = 8
    assert len(rig.neutral.vertices) <= len(face.neutral) + body
    assert len(rig.neutral.vertices) >= len(ours)
    for target in TARGETS:
        theirs = np.concatenate([rig.neutral.vertices, rig.morphs[target].target.vertices], axis=1)
        expected = np.concatenate([face.neutral, face.targets[target]], axis=1)
        assert _farthest(expected, theirs) < 3e-6 * face.extent


def _farthest(points: np.ndarray, among: np.ndarray) -> float:
    from scipy.spatial import cKDTree

    return float(cKDTree(among).query(points)[0].max())
