"""The animations of a file that move morph targets, as weights of sliders over time.

A channel is played as glTF says: straight between keys, in steps, or along cubic splines. Steps
become a key just before the jump, splines as many keys as a player could tell apart, so that
everything is straight between the keys that are given back.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError, warn
from elastomorph.io.atomic import is_file
from elastomorph.io.blend_shapes import different_names
from elastomorph.io.gltf.channels import Channel, read_channel
from elastomorph.io.gltf.container import GltfFile, open_gltf
from elastomorph.io.gltf.lenient import entry_of, object_of
from elastomorph.io.gltf.primitives import target_names
from elastomorph.io.gltf.rig_extras import described_meshes, stored_rig
from elastomorph.io.gltf.turning import head_node, recorded_turn, rotations_at
from elastomorph.io.untrusted import naming_file
from elastomorph.model.bend_curve import BendCurve
from elastomorph.numbers import first_few
from elastomorph.rig.performance import HeadTurn
from elastomorph.rig.sliders import Sliders

__all__ = [
    "SCENES",
    "MovedWeights",
    "WeightClip",
    "chosen_clip",
    "moved_weights",
    "named_clip",
    "read_weight_clips",
    "weight_clips",
]

Floats = NDArray[np.float64]

POINTER = "KHR_animation_pointer"
_WEIGHTS = re.compile(r"/(nodes|meshes)/(\d{1,9})/weights(?:/(\d{1,9}))?")
_FARTHEST, _HALVINGS = 8.0, 60
_NO_TURN = 1e-3  # of a number in a quaternion, whose length is 1
_TIMES = 5  # keys from all channels, and the jumps and splines between them


SCENES = (".glb", ".gltf", ".vrm")
"""Suffixes of files whose animations may be takes."""


@dataclass(frozen=True, eq=False)
class WeightClip:
    """An animation: seconds (T,) from 0 that rise, and weights (T, S) of the sliders asked for.

    With them how the head turns at these times, if it does.
    """

    name: str
    times: Floats
    weights: Floats
    turn: HeadTurn | None = None


@dataclass(frozen=True)
class MovedWeights:
    """What a channel moves: all weights of a mesh, by its number, or one of them."""

    mesh: int
    weight: int | None


def named_clip(path: str | Path, clip: str | None) -> tuple[str | Path, str | None]:
    """The file and the name of the animation that ``take.glb#NAME`` says."""
    file, mark, name = str(path).rpartition("#")
    says = mark and name and clip is None and Path(file).suffix.lower() in SCENES
    return (file, name) if says and not is_file(path) else (path, clip)


def chosen_clip(
    path: str | Path, clips: Sequence[WeightClip], name: str | None, sliders: Sliders
) -> WeightClip:
    """The animation of a name; without one that named like the file, or the first that is a take.

    Those named like a slider play that from 0 to 1.
    """
    named = [clip for clip in clips if name in (None, clip.name)]
    takes = [clip for clip in clips if clip.name not in sliders.names]
    if name is None:
        named = [clip for clip in clips if clip.name == Path(path).stem][:1] or takes or [*clips]
    if len(named) > 1 and name is None and takes:
        others = first_few((clip.name for clip in named[1:]), 8)
        warn(f"{path}: the take {named[0].name!r} is read; {path}#NAME names another: {others}")
        return named[0]
    if len(named) == 1:
        return named[0]
    shown = ", ".join(clip.name for clip in clips[:8]) + (", …" if len(clips) > 8 else "")
    if named:
        raise ParameterError(f"{path} holds {len(clips)} clips, say which one is meant: {shown}")
    raise ParameterError(f"{path} has no clip {name!r}; it has {shown}")


def read_weight_clips(path: str | Path, sliders: Sliders) -> list[WeightClip]:
    """The animations of a file that move some of the sliders of its rig, or its head with them.

    Raises:
        FileError: The file cannot be read.
        FormatError: An animation is damaged.
    """
    return weight_clips(open_gltf(path), sliders)


def weight_clips(file: GltfFile, sliders: Sliders) -> list[WeightClip]:
    """As `read_weight_clips`, of a file that is open."""
    found = []
    with naming_file(file.path), np.errstate(all="ignore"):
        folds = _folds(file)
        for number, animation in enumerate(file.items("animations")):
            if not isinstance(animation, dict):
                file.refuse(f"animation {number} is no object")
            of = f"animation {number}"
            channels = list(_channels(file, animation, of))
            turned = _turned(file, animation, of) if channels else None
            tracks, times = _tracks(file, channels, turned)
            tracks = {
                target: _unfolded(track, folds[target]) if target in folds else track
                for target, track in tracks.items()
            }
            weights = _weights(sliders, tracks, len(times))
            turn = _turn(file, turned, times, of)
            if weights.any() or turn is not None:
                name = animation.get("name")
                shown = name if isinstance(name, str) and name else f"clip {number + 1}"
                found.append(WeightClip(shown, times, weights, turn))
    return found


def _channels(file: GltfFile, animation: dict[str, Any], of: str) -> Iterator[Channel]:
    samplers = file.list_in(animation, "samplers", of)
    for channel in file.list_in(animation, "channels", of):
        moved = moved_weights(file, channel, of) if isinstance(channel, dict) else None
        if moved is None or moved.weight is not None:
            continue
        given = _given_names(file, file.item("meshes", moved.mesh, "a node"))
        yield read_channel(file, samplers, channel, different_names(given), of)


def _given_names(file: GltfFile, mesh: dict[str, Any]) -> list[str]:
    primitives = [object_of(own) for own in file.list_in(mesh, "primitives", "a mesh")]
    counts = [len(file.list_in(p, "targets", "a mesh")) for p in primitives]
    return target_names([mesh, *primitives], max(counts, default=0))


def _turned(file: GltfFile, animation: dict[str, Any], of: str) -> tuple[int, Channel] | None:
    """The node of the head and its rotations, where an animation turns it."""
    channels: dict[int, dict[str, Any]] = {}
    for channel in file.list_in(animation, "channels", of):
        target = object_of(object_of(channel).get("target"))
        if target.get("path") == "rotation" and type(target.get("node")) is int:
            channels.setdefault(target["node"], channel)
    node = head_node(file, list(channels))
    if node is None:
        return None
    samplers = file.list_in(animation, "samplers", of)
    channel = read_channel(file, samplers, channels[node], list("xyzw"), of, 4)
    _require_turns(file, channel.at(channel.times), of)
    return node, channel


def _turn(
    file: GltfFile, turned: tuple[int, Channel] | None, times: Floats, of: str
) -> HeadTurn | None:
    """How the head turns at (T,) times, where it leaves its place."""
    if turned is None:
        return None
    node, channel = turned
    quaternions = rotations_at(channel, times)
    _require_turns(file, quaternions, of)  # splines of keys that turn may pass through none
    return recorded_turn(file, node, quaternions)


def _require_turns(file: GltfFile, quaternions: Floats, of: str) -> None:
    if not (np.abs(quaternions).max(axis=1) > _NO_TURN).all():
        file.refuse(f"the rotations of {of} are no quaternions")


def moved_weights(file: GltfFile, channel: dict[str, Any], of: str) -> MovedWeights | None:
    """The weights that a channel of an animation moves, None where it moves something else."""
    target = file.object_in(channel, "target", of)
    path, node, weight = target.get("path"), target.get("node"), None
    if path == "pointer":
        extensions = file.object_in(target, "extensions", of)
        pointer = file.object_in(extensions, POINTER, of).get("pointer")
        found = _WEIGHTS.fullmatch(pointer) if isinstance(pointer, str) else None
        if found is None:
            return None
        weight = None if found[3] is None else int(found[3])
        if found[1] == "meshes":
            file.item("meshes", int(found[2]), of)
            return MovedWeights(int(found[2]), weight)
        node = int(found[2])
    elif path != "weights" or "node" not in target:
        return None
    mesh = file.item("nodes", node, f"a channel of {of}").get("mesh")
    if mesh is None:
        file.refuse(
            f"{of} moves weights of node {node}, which has no mesh; take out that channel, "
            "or export the animation again"
        )
    file.item("meshes", mesh, "a node")
    return MovedWeights(mesh, weight)


def _tracks(
    file: GltfFile, channels: list[Channel], turned: tuple[int, Channel] | None
) -> tuple[dict[str, Floats], Floats]:
    """The weight of each morph target by name, (T,), at times (T,) that all of them share.

    Of meshes that share targets, the first that is moved counts.
    """
    if not channels:
        return {}, np.zeros(0)
    others = () if turned is None else (turned[1],)
    together = np.concatenate([channel.moments() for channel in (*channels, *others)])
    times = np.unique(np.maximum(together, 0.0).astype(np.float32)).astype(np.float64)
    file.budget.spend(8 * _TIMES * len(times) * sum(len(c.names) for c in channels))
    tracks: dict[str, Floats] = {}
    for channel in channels:
        weights = channel.at(times)
        for column, name in enumerate(channel.names):
            tracks.setdefault(name, weights[:, column])
    return tracks, times


def _folds(file: GltfFile) -> dict[str, BendCurve]:
    """What is added to the weights of morph targets that play a bend, by the name of each."""
    found: dict[str, BendCurve] = {}
    for number, stored in described_meshes(file).items():
        given = _given_names(file, entry_of(file, "meshes", number))
        with suppress(ValueError):  # whoever reads the rig is told
            own = stored_rig(stored, different_names(given), file.budget, given)
            found |= {m.target: m.fold for m in own.morphs if m.fold is not None}
    return found


def _unfolded(weights: Floats, fold: BendCurve) -> Floats:
    """(T,) the t at which targets have (T,) weights t + fold(t), by bisection."""
    low = np.where(weights < 0, -_FARTHEST, 0.0)
    high = np.where(weights > 1, _FARTHEST, 1.0)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        below = middle + fold(middle) < weights
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    # To the last bit, so that what is at rest counts as such.
    return np.where(weights == 0, 0.0, (low + high) / 2)


def _weights(sliders: Sliders, tracks: dict[str, Floats], count: int) -> Floats:
    """(T, S) weights of sliders; that of a corrective is its share of what drives it."""
    table = np.zeros((count, len(sliders.names)))
    for column, name in enumerate(sliders.names):
        if name not in tracks:
            continue
        table[:, column] = tracks[name]
        others = [d for d in sliders.correctives.get(name, ()) if d != name]
        for driver in others:
            weight = tracks.get(driver, np.zeros(count))
            steady = np.abs(weight) > 1e-6
            table[:, column] = np.where(
                steady, table[:, column] / np.where(steady, weight, 1.0), 0.0
            )
    return table
