"""Clips of files become weights of sliders that play the same between their keys."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import CORNERS, MOVED, SQUARE, HandMade

from elastomorph.errors import FormatError
from elastomorph.io.gltf.clips import (
    MovedWeights,
    WeightClip,
    moved_weights,
    read_weight_clips,
)
from elastomorph.io.gltf.container import open_gltf
from elastomorph.rig.laws import Corrective
from elastomorph.rig.sliders import Sliders

NAMES = ("open", "smile")
SLIDERS = Sliders(NAMES)


def animated(
    times: Any,
    weights: Any,
    kind: str = "LINEAR",
    *,
    names: tuple[str, ...] = NAMES,
    target: dict[str, Any] | None = None,
) -> HandMade:
    """A square with two targets and a clip."""
    file = HandMade()
    file.primitive(
        attributes={"POSITION": file.array(SQUARE)},
        indices=file.array(CORNERS, "<u2"),
        targets=[{"POSITION": file.array(MOVED)} for _ in names],
    )
    file.document["meshes"][0]["extras"] = {"targetNames": list(names)}
    sampler = {"input": file.array(times), "output": file.array(weights), "interpolation": kind}
    channel = {"sampler": 0, "target": target or {"node": 0, "path": "weights"}}
    file.document["animations"] = [
        {"name": "talk", "samplers": [sampler], "channels": [channel]},
    ]
    return file


def clips(file: HandMade, tmp_path: Path, sliders: Sliders = SLIDERS) -> list[WeightClip]:
    return read_weight_clips(file.write(tmp_path / "a.glb"), sliders)


def test_straight_keys_are_kept(tmp_path: Path) -> None:
    (clip,) = clips(animated([0.0, 0.5, 2.0], [0, 0, 1, 0.25, 0.5, 1]), tmp_path)
    assert clip.name == "talk"
    np.testing.assert_array_equal(clip.times, [0.0, 0.5, 2.0])
    np.testing.assert_array_equal(clip.weights, [[0, 0], [1, 0.25], [0.5, 1]])


def test_steps_jump(tmp_path: Path) -> None:
    (clip,) = clips(animated([0.0, 1.0, 2.0], [0, 0, 1, 0.5, 0, 0], "STEP"), tmp_path)
    played = np.interp([0.5, 0.999, 1.0, 1.5, 2.0], clip.times, clip.weights[:, 0])
    np.testing.assert_array_equal(played, [0, 0, 1, 1, 0])


def test_splines_are_followed(tmp_path: Path) -> None:
    """From 0 with the slope 2 to 1 with the slope 0, and of the other slider t²(3 - 2t)."""
    keys = [[[0, 0], [0, 0], [2, 0]], [[0, 0], [1, 1], [0, 0]]]
    (clip,) = clips(animated([0.0, 1.0], np.ravel(keys), "CUBICSPLINE"), tmp_path)
    t = clip.times
    assert len(t) >= 9
    np.testing.assert_allclose(clip.weights[:, 1], t**2 * (3 - 2 * t), atol=1e-6)
    expected = 2 * (t**3 - 2 * t**2 + t) + t**2 * (3 - 2 * t)
    np.testing.assert_allclose(clip.weights[:, 0], expected, atol=1e-6)


@pytest.mark.parametrize("pointer", ["/nodes/0/weights", "/meshes/0/weights"])
def test_pointers_to_weights_are_followed(tmp_path: Path, pointer: str) -> None:
    target = {
        "path": "pointer",
        "extensions": {"KHR_animation_pointer": {"pointer": pointer}},
    }
    (clip,) = clips(animated([0.0, 1.0], [0, 0, 1, 0], target=target), tmp_path)
    np.testing.assert_array_equal(clip.weights[:, 0], [0, 1])


def test_meshes_play_together_at_the_keys_of_both(tmp_path: Path) -> None:
    file = animated([0.0, 1.0], [0, 0, 1, 1])
    mesh = {**file.document["meshes"][0], "extras": {"targetNames": ["open", "tongue"]}}
    file.document["meshes"].append(mesh)
    file.document["nodes"].append({"mesh": 1})
    clip = file.document["animations"][0]
    times, weights = file.array([0.5, 1.5]), file.array([0, 0, 9, 1])
    clip["samplers"].append({"input": times, "output": weights})
    clip["channels"].append({"sampler": 1, "target": {"node": 1, "path": "weights"}})
    (found,) = clips(file, tmp_path, Sliders(("open", "smile", "tongue")))
    np.testing.assert_array_equal(found.times, [0, 0.5, 1, 1.5])
    expected = [[0, 0, 0], [0.5, 0.5, 0], [1, 1, 0.5], [1, 1, 1]]
    np.testing.assert_array_equal(found.weights, expected)


def test_a_corrective_gets_its_share_of_what_drives_it(tmp_path: Path) -> None:
    sliders = Sliders(NAMES, {"smile": Corrective(("open", "smile"))})
    (clip,) = clips(animated([0.0, 1.0], [0, 0, 0.5, 0.25]), tmp_path, sliders)
    np.testing.assert_array_equal(clip.weights, [[0, 0], [0.5, 0.5]])


def test_what_moves_no_slider_is_no_clip(tmp_path: Path) -> None:
    assert clips(animated([0.0, 1.0], [0, 0, 0, 0]), tmp_path) == []
    other = animated([0.0, 1.0], [0, 0, 1, 1], names=("left", "right"))
    assert clips(other, tmp_path) == []
    turned = animated([0.0, 1.0], [0, 0, 1, 1], target={"node": 0, "path": "rotation"})
    assert clips(turned, tmp_path) == []


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda a: a["channels"][0].update(sampler=7), "no sampler"),
        (lambda a: a["channels"][0]["target"].update(node=9), "number 9"),
        (lambda a: a["samplers"][0].update(interpolation="CUBICSPLINE"), "weights for"),
        (lambda a: a.update(channels={}), "no list"),
    ],
)
def test_damaged_clips_are_refused(tmp_path: Path, change: Any, problem: str) -> None:
    file = animated([0.0, 1.0], [0, 0, 1, 1])
    change(file.document["animations"][0])
    with pytest.raises(FormatError, match=problem):
        clips(file, tmp_path)


@pytest.mark.parametrize("times", [[1.0, 0.0], [-1.0, 0.0], [0.0, np.nan], [0.5, 0.5]])
def test_times_rise_from_zero(tmp_path: Path, times: list[float]) -> None:
    with pytest.raises(FormatError, match="times"):
        clips(animated(times, [0, 0, 1, 1]), tmp_path)


def _pointer(text: str) -> dict[str, Any]:
    extensions = {"KHR_animation_pointer": {"pointer": text}}
    return {"path": "pointer", "extensions": extensions}


@pytest.mark.parametrize(
    ("target", "expected"),
    [
        ({"path": "weights", "node": 0}, MovedWeights(0, None)),
        (_pointer("/nodes/0/weights"), MovedWeights(0, None)),
        (_pointer("/meshes/0/weights"), MovedWeights(0, None)),
        (_pointer("/meshes/0/weights/1"), MovedWeights(0, 1)),
        (_pointer("/nodes/0/weights/0"), MovedWeights(0, 0)),
        (_pointer("/nodes/0/scale"), None),
        ({"path": "rotation", "node": 0}, None),
        ({"path": "weights"}, None),
        ({}, None),
    ],
)
def test_the_weights_that_a_channel_moves(
    tmp_path: Path, target: dict[str, Any], expected: MovedWeights | None
) -> None:
    file = open_gltf(animated([0, 1], [0, 0, 1, 1]).write(tmp_path / "a.glb"))
    assert moved_weights(file, {"target": target}, "a clip") == expected


@pytest.mark.parametrize("number", [1, -1, 7, True, "0"])
def test_weights_of_what_has_none_are_refused(tmp_path: Path, number: Any) -> None:
    animation = animated([0, 1], [0, 0, 1, 1])
    animation.document["nodes"].append({"name": "empty"})
    file = open_gltf(animation.write(tmp_path / "a.glb"))
    with pytest.raises(FormatError, match=r"no mesh|names number"):
        moved_weights(file, {"target": {"path": "weights", "node": number}}, "a clip")
