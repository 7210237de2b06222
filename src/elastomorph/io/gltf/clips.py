"""The animations of a file: weights of sliders over time, and turns of the head.

A channel is played as glTF says: straight between keys, in steps, or along cubic splines. Steps
become a key just before the jump, splines as many keys as a player could tell apart, so that
everything is straight between the keys that are given back.

A head turns by a rotation of the node or the bone that carries the face. A face without bones hangs
below a node ``head`` in its neck, which turns. Of files by others, the bone that VRM calls the head
is read, or else a node that is called so, such as ``mixamorig:Head``.
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
from elastomorph.io.gltf.accessors import AccessorWriter, read_floats
from elastomorph.io.gltf.container import GltfFile, entry_of, object_of, open_gltf
from elastomorph.io.gltf.nodes import world_above
from elastomorph.io.gltf.primitives import target_names
from elastomorph.io.gltf.rig_extras import described_meshes, stored_rig
from elastomorph.io.untrusted import naming_file
from elastomorph.model.bend_curve import BendCurve
from elastomorph.numbers import first_few
from elastomorph.rig.performance import HeadTurn, angles_of, head_quaternions
from elastomorph.rig.sliders import Sliders

_HEAD = "head"
_NAMED = re.compile(r"(.*[^a-z])?head", re.IGNORECASE)
_SAME = 1e-6


def turned_nodes(
    nodes: Sequence[dict[str, Any]], turn: HeadTurn
) -> tuple[list[dict[str, Any]], int]:
    """The nodes of a scene in which a face hangs in its neck, and the number of the root.

    The face stays node 0, and where it was while the neck is at rest.
    """
    face, *others = nodes
    neck = turn.pivot
    place = np.array(face.get("translation", [0.0, 0.0, 0.0])) - neck
    held = face | {"translation": place.tolist()}
    head = {"name": _HEAD, "translation": neck.tolist(), "children": [0]}
    return [held, *others, head], len(nodes)


def turn_channels(
    accessors: AccessorWriter,
    animations: list[dict[str, Any]],
    counts: list[int],
    turn: HeadTurn,
    node: int,
) -> None:
    """Add the turn of a node to animations of so many frames, at the times that they have."""
    parts = np.split(turn.angles, np.cumsum(counts)[:-1])
    for animation, angles in zip(animations, parts, strict=True):
        output = accessors.rotations(head_quaternions(angles).astype(np.float32))
        own = animation["samplers"]
        target = {"node": node, "path": "rotation"}
        animation["channels"].append({"sampler": len(own), "target": target})
        own.append({"input": own[0]["input"], "interpolation": "LINEAR", "output": output})


def head_node(file: GltfFile, turned: list[int]) -> int | None:
    """Which of the nodes that an animation turns is the head."""
    extensions = object_of(file.document.get("extensions"))
    bones = object_of(object_of(extensions.get("VRMC_vrm")).get("humanoid")).get("humanBones")
    known = object_of(object_of(bones).get("head")).get("node")
    older = object_of(object_of(extensions.get("VRM")).get("humanoid")).get("humanBones")
    for bone in older if isinstance(older, list) else []:
        if object_of(bone).get("bone") == "head":
            known = object_of(bone).get("node")
    for number in turned:
        node = file.item("nodes", number, "an animation")
        name = node.get("name")
        # A mesh that joints hold, such as "Wolf3D_Head", stays where they are when its node turns.
        named = isinstance(name, str) and _NAMED.fullmatch(name) and "skin" not in node
        if number == known or (known is None and named):
            return number
    return None


def rotations_at(channel: Channel, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 4) quaternions at (N,) times: along arcs between keys that no spline joins."""
    from scipy.spatial.transform import Rotation, Slerp

    if channel.kind in ("STEP", "CUBICSPLINE") or len(channel.times) == 1:
        return channel.at(times)
    arcs = Slerp(channel.times, Rotation.from_quat(channel.values))
    found: NDArray[np.float64] = arcs(np.clip(times, *channel.times[[0, -1]])).as_quat()
    return found


def recorded_turn(file: GltfFile, node: int, quaternions: NDArray[np.float64]) -> HeadTurn | None:
    """How a node turns the head that has (T, 4) rotations x, y, z, w in its parent, if it does.

    The angles are those by which it leaves its place at rest, as seen in the scene.
    """
    from scipy.spatial.transform import Rotation

    above, own = world_above(file, node)
    frame = Rotation.from_matrix(_rotation(above))
    rest = Rotation.from_matrix(_rotation(own))
    found = frame * Rotation.from_quat(quaternions) * rest.inv() * frame.inv()
    angles = angles_of(found.as_quat())
    angles = np.where(np.abs(angles) < _SAME, 0.0, angles)
    return HeadTurn((above @ own)[:3, 3], angles) if angles.any() else None


def _rotation(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation in a (4, 4) matrix without shear."""
    axes = matrix[:3, :3]
    lengths = np.linalg.norm(axes, axis=0)
    if not (lengths > 0).all() or np.linalg.det(axes) <= 0:
        return np.eye(3)
    turned: NDArray[np.float64] = axes / lengths
    return turned


Floats = NDArray[np.float64]

_JUMP = 1e-4
"""Seconds before a jump, where the value before it ends."""
_BETWEEN = 8
"""Keys put into each stretch of a spline."""


@dataclass(frozen=True, eq=False)
class Channel:
    """Keys, as glTF plays them.

    Attributes:
        names: What it moves: morph targets, or the parts of a quaternion.
        times: (T,) seconds, rising.
        values: (T, J), or (T, 3, J) of a spline: tangent before, value, tangent after.
        kind: LINEAR, STEP or CUBICSPLINE.
    """

    names: list[str]
    times: Floats
    values: Floats
    kind: str

    def moments(self) -> Floats:
        """(N,) times between which it is straight."""
        if self.kind == "STEP":
            return np.concatenate([self.times, self.times[1:] - _JUMP])
        if self.kind == "CUBICSPLINE":
            share = np.arange(1, _BETWEEN) / _BETWEEN
            between = self.times[:-1, None] + np.diff(self.times)[:, None] * share
            return np.concatenate([self.times, between.reshape(-1)])
        return self.times

    def at(self, when: Floats) -> Floats:
        """(N, J) weights at (N,) times."""
        last = len(self.times) - 1
        key = np.clip(np.searchsorted(self.times, when, side="right") - 1, 0, last)
        after = np.minimum(key + 1, last)
        length = np.where(after > key, self.times[after] - self.times[key], 1.0)
        share = np.clip((when - self.times[key]) / length, 0.0, 1.0)[:, None]
        if self.kind == "STEP":
            return np.asarray(self.values[key])
        if self.kind != "CUBICSPLINE":
            return np.asarray(self.values[key] * (1 - share) + self.values[after] * share)
        start, end = self.values[key, 1], self.values[after, 1]
        out, into = (length[:, None] * t for t in (self.values[key, 2], self.values[after, 0]))
        s, s2, s3 = share, share**2, share**3
        return np.asarray(
            (2 * s3 - 3 * s2 + 1) * start
            + (s3 - 2 * s2 + s) * out
            + (3 * s2 - 2 * s3) * end
            + (s3 - s2) * into
        )


def read_channel(
    file: GltfFile,
    samplers: list[Any],
    channel: dict[str, Any],
    names: list[str],
    of: str,
    width: int = 1,
) -> Channel:
    """The keys of a channel, one number a name, of so many in a row of the file."""
    number, what = channel.get("sampler"), "weights" if width == 1 else "rotations"
    if type(number) is not int or not 0 <= number < len(samplers):
        file.refuse(f"a channel of {of} has no sampler")
    sampler = samplers[number] if isinstance(samplers[number], dict) else {}
    kind = str(sampler.get("interpolation", "LINEAR"))
    times = read_floats(file, sampler.get("input"), 1, f"the times of {of}").reshape(-1)
    values = read_floats(file, sampler.get("output"), width, f"the {what} of {of}").reshape(-1)
    tangents = (3,) if kind == "CUBICSPLINE" else ()
    if not names or len(values) != len(times) * len(names) * (3 if tangents else 1):
        file.refuse(f"{of} has {len(values):,} {what} for {len(times):,} keys")
    if not (np.isfinite(times).all() and np.isfinite(values).all() and times[0] >= 0):
        file.refuse(f"{of} has times or {what} that are no finite numbers from 0")
    if (np.diff(times) <= 0).any():
        file.refuse(f"the times of {of} do not rise")
    return Channel(names, times, values.reshape(len(times), *tangents, len(names)), kind)


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
            found |= {m.target: m.fold for m in own.morphs if m.target and m.fold is not None}
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
    """(T, S) weights of sliders; of one that is a corrective too, what gives it its weight."""
    table = np.zeros((count, len(sliders.names)))
    for column, name in enumerate(sliders.names):
        if name not in tracks:
            continue
        table[:, column] = tracks[name]
        if name in sliders.correctives:
            own = sliders.correctives[name]
            given = {d: tracks.get(d, np.zeros(count)) for d in own.drivers if d != name}
            table[:, column] = own.driven_by(name, given, tracks[name])
    return table
