"""Meshes whose joints hold each vertex elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import MOVED, SQUARE, HandMade, square

from elastomorph import FormatError
from elastomorph.io.gltf import read_glb


def two_joints(weights: Any, kind: str = "<f4", **fields: Any) -> HandMade:
    """A square held by a joint at rest and one that is turned by 90° about z and lifted by 2."""
    file = square()
    shown = file.document["meshes"][0]["primitives"][0]["attributes"]
    shown["JOINTS_0"] = file.array([[0, 1, 9, 9]] * 4, "u1")
    values = np.concatenate([np.asarray(weights), np.zeros((4, 2))], axis=1)
    shown["WEIGHTS_0"] = file.array(values, kind, **fields)
    half = np.sqrt(0.5)
    file.document["nodes"] = [
        {"mesh": 0, "skin": 0, "translation": [7, 7, 7]},
        {},
        {"rotation": [0, 0, half, half], "translation": [0, 2, 0]},
    ]
    file.document["scenes"][0]["nodes"] = [0, 1, 2]
    file.document["skins"] = [{"joints": [1, 2]}]
    return file


TURN = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])


def by_hand(points: Any, weights: Any, shift: float) -> Any:
    turned = points @ TURN.T + [0, shift, 0]
    share = np.asarray(weights)[:, 1:]
    return (1 - share) * points + share * turned


@pytest.mark.parametrize(
    ("kind", "scale", "fields"),
    [("<f4", 1, {}), ("u1", 255, {"normalized": True}), ("<u2", 65535, {"normalized": True})],
)
def test_each_vertex_stands_where_its_joints_hold_it(
    tmp_path: Path, kind: str, scale: int, fields: dict[str, Any]
) -> None:
    weights = np.array([[1, 0], [0, 1], [0.2, 0.8], [0.6, 0.4]])
    rig = read_glb(two_joints(weights * scale, kind, **fields).write(tmp_path / "a.glb"))
    np.testing.assert_allclose(rig.neutral.vertices, by_hand(SQUARE, weights, 2.0), atol=1e-6)
    delta = rig.morphs["target_0"].delta
    np.testing.assert_allclose(delta, by_hand(MOVED, weights, 0.0), atol=1e-6)


def test_weights_count_by_their_share_and_further_sets_of_joints_count_too(tmp_path: Path) -> None:
    file = two_joints(np.array([[2.0, 2.0]] * 4))
    shown = file.document["meshes"][0]["primitives"][0]["attributes"]
    shown["JOINTS_1"] = file.array([[1, 0, 0, 0]] * 4, "<u2")
    shown["WEIGHTS_1"] = file.array([[4.0, 0, 0, 0]] * 4)
    rig = read_glb(file.write(tmp_path / "a.glb"))
    expected = by_hand(SQUARE, np.array([[0.25, 0.75]] * 4), 2.0)
    np.testing.assert_allclose(rig.neutral.vertices, expected, atol=1e-6)


def test_vertices_that_one_joint_at_rest_holds_stay_bit_for_bit(tmp_path: Path) -> None:
    """However the joints that hold none of them are posed."""
    rig = read_glb(two_joints([[1, 0]] * 4).write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d["skins"][0].update(joints=[1, 9]), "no node of the file"),
        (lambda d: d["skins"][0].update(joints=[]), "skin 0 has no joints"),
        (lambda d: d["skins"][0].update(inverseBindMatrices=99), "names number 99 of"),
        (lambda d: d["nodes"][1].update(children=[1]), "node 1 appears twice"),
        (
            lambda d: d["meshes"][0]["primitives"][0]["attributes"].pop("WEIGHTS_0"),
            "has JOINTS_0 alone",
        ),
    ],
)
def test_a_skin_that_holds_nothing_is_one_clear_error(
    tmp_path: Path, change: Callable[[Any], object], words: str
) -> None:
    file = two_joints([[0.5, 0.5]] * 4)
    change(file.document)
    with pytest.raises(FormatError, match=words):
        read_glb(file.write(tmp_path / "a.glb"))


def test_a_vertex_of_a_joint_that_the_skin_lacks_is_refused(tmp_path: Path) -> None:
    file = two_joints([[0.5, 0.5]] * 4)
    shown = file.document["meshes"][0]["primitives"][0]["attributes"]
    shown["JOINTS_0"] = file.array([[0, 5, 9, 9]] * 4, "u1")
    with pytest.raises(FormatError, match="held by joint 5 of the 2 of skin 0"):
        read_glb(file.write(tmp_path / "a.glb"))
