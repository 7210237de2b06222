"""Clips, by Appendix C of the specification of glTF 2.0, and the pointers of an extension."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acceptance.gltf_file import GltfFile
from acceptance.posing import Pose, Scene

Floats = NDArray[np.float64]


def key_times(file: GltfFile, clip: int) -> Floats:
    """All times at which anything in a clip has a key."""
    animation = file.animations[clip]
    inputs = {animation["samplers"][own["sampler"]]["input"] for own in animation["channels"]}
    return np.unique(np.concatenate([file.array(number)[:, 0] for number in sorted(inputs)]))


def sampled(file: GltfFile, sampler: dict[str, Any], width: int, turns: bool, t: float) -> Floats:
    """(width,) the value of a sampler at a time; before the first and after the last key, theirs.

    Args:
        file: The document.
        sampler: As the animation has it.
        width: Numbers in a value.
        turns: Whether values are quaternions, between which the way is along the sphere.
        t: Seconds.
    """
    times = file.array(sampler["input"])[:, 0]
    kind = sampler.get("interpolation", "LINEAR")
    values = file.array(sampler["output"]).reshape(len(times), -1)
    cubic = kind == "CUBICSPLINE"
    keys = values.reshape(len(times), 3, width) if cubic else values.reshape(len(times), width)
    k = int(np.searchsorted(times, t, side="right")) - 1
    if k < 0 or k >= len(times) - 1:
        end = keys[0 if k < 0 else -1]
        return np.asarray(end[1] if cubic else end)
    step = times[k + 1] - times[k]
    u = (t - times[k]) / step
    if kind == "STEP":
        return np.asarray(keys[k])
    if cubic:
        found = (
            (2 * u**3 - 3 * u**2 + 1) * keys[k, 1]
            + step * (u**3 - 2 * u**2 + u) * keys[k, 2]
            + (-2 * u**3 + 3 * u**2) * keys[k + 1, 1]
            + step * (u**3 - u**2) * keys[k + 1, 0]
        )
        return np.asarray(found / np.linalg.norm(found) if turns else found)
    if turns:
        return _along_the_sphere(keys[k], keys[k + 1], u)
    return np.asarray((1 - u) * keys[k] + u * keys[k + 1])


def _along_the_sphere(start: Floats, end: Floats, u: float) -> Floats:
    cosine = float(start @ end)
    if cosine < 0:
        end, cosine = -end, -cosine
    angle = np.arccos(min(cosine, 1.0))
    if angle < 1e-8:
        return np.asarray((1 - u) * start + u * end)
    return np.asarray((np.sin((1 - u) * angle) * start + np.sin(u * angle) * end) / np.sin(angle))


def played(scene: Scene, clip: int, t: float) -> Pose:
    """The pose of a clip at a time, on the scene as the file has it."""
    file, pose = scene.file, Pose()
    animation = file.animations[clip]
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        target = channel["target"]
        for node, path, index in _targets(file, target):
            _apply(scene, pose, sampler, t, node, path, index)
    return pose


def _targets(file: GltfFile, target: dict[str, Any]) -> Iterator[tuple[int | str, str, int | None]]:
    """Node (or ``"mesh N"``), path and number of a weight that a channel moves."""
    if target["path"] != "pointer":
        if "node" in target:
            yield target["node"], target["path"], None
        return
    pointer = target["extensions"]["KHR_animation_pointer"]["pointer"]
    words = pointer.strip("/").split("/")
    if words[0] == "nodes" and words[2] in ("weights", "translation", "rotation", "scale"):
        yield int(words[1]), words[2], int(words[3]) if len(words) > 3 else None
    if words[0] == "meshes" and words[2] == "weights":
        yield f"mesh {words[1]}", "weights", int(words[3]) if len(words) > 3 else None


def _apply(
    scene: Scene,
    pose: Pose,
    sampler: dict[str, Any],
    t: float,
    node: int | str,
    path: str,
    index: int | None,
) -> None:
    file = scene.file
    if path != "weights":
        assert isinstance(node, int)
        turns = path == "rotation"
        value = sampled(file, sampler, 4 if turns else 3, turns, t)
        pose.transforms[node, path] = value
        return
    if isinstance(node, str):
        mesh = int(node.removeprefix("mesh "))
        count = max(len(p.get("targets", [])) for p in file.meshes[mesh]["primitives"])
        known = pose.of_mesh.get(mesh, np.array(file.meshes[mesh].get("weights", [0.0] * count)))
        pose.of_mesh[mesh] = _with(
            known, index, sampled(file, sampler, _width(index, count), False, t)
        )
        return
    if "mesh" not in file.nodes[node]:
        return
    count = scene.count(node)
    known = scene.weights(node, pose)
    pose.weights[node] = _with(known, index, sampled(file, sampler, _width(index, count), False, t))


def _width(index: int | None, count: int) -> int:
    return count if index is None else 1


def _with(known: Floats, index: int | None, value: Floats) -> Floats:
    if index is None:
        return value
    found = np.array(known, float)
    found[index] = value[0]
    return found
