"""Whether a bent character plays in a program as it should: skinned, by sliders and by clips."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import elastomorph as em
from acceptance.clips import key_times, played
from acceptance.expected import Face
from acceptance.judging import Pair
from acceptance.players import Request, as_shown, has_pointers, plain, seen, shown
from acceptance.posing import Floats, Pose, Scene

BETWEEN = (0.2, 0.5, 0.85)
_KEYS = 12  # of a clip, at most: as many moments at keys, and as many between
# A program whose own picture of the original is farther from the specification, as a fraction of
# D, does not play the clip in any file.
UNPLAYED = 1e-4


@dataclass
class Played:
    """What a program shows of a bent character; distances are fractions of D, the largest found.

    Attributes:
        poses: How many poses by sliders were looked at.
        moments: How many moments of clips.
        posed: From what the specification says of the bent file.
        original: What it shows of the original, from what the specification says of that.
        ends: With sliders at 0 and 1, from what the program shows of the original.
        between: With one slider between its ends, from the path of ``auto``.
        straight: The same of the original, whose paths are straight.
        keys: Of clips at their keys, from where the sliders of the original's clip lead.
        clips: The same between keys.
        off_straight: Of clips, from what the program shows of the original.
        unplayed: Clips, of which the program does not play all meshes as specified in the original
            either: those meshes are not looked at.
    """

    poses: int = 0
    moments: int = 0
    posed: float = 0.0
    original: float = 0.0
    ends: float = 0.0
    between: float = 0.0
    straight: float = 0.0
    keys: float = 0.0
    clips: float = 0.0
    off_straight: float = 0.0
    unplayed: list[str] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class _Case:
    """One thing to be shown, by the original and by the bent file."""

    kind: str  # "ends", "alone", "mixed", "key" or "between"
    straight: Request
    bent: Request
    slider: tuple[str, float] = ("", 0.0)  # of "alone"


def play(pair: Pair, player: str, folder: Path) -> Played:
    """Show a bent character and its original in a program, and measure."""
    pointers = player != "Blender"  # which stops at the weights of one target
    clips = pair.old.file.animations
    closed = [n for n, own in enumerate(clips) if not pointers and has_pointers(own)]
    cases = [*_poses(pair), *(own for own in _clips(pair) if own.bent.clip not in closed)]
    before = plain(pair.old.file, folder / f"{pair.source.stem}.1.glb", pointers=pointers)
    after = plain(pair.new.file, folder / f"{pair.source.stem}.2.glb", pointers=pointers)
    old = shown(player, before, [own.straight for own in cases], folder)
    new = shown(player, after, [own.bent for own in cases], folder)
    for scene, found_nodes in ((pair.old, old[0]), (pair.new, new[0])):
        assert sorted(found_nodes) == sorted(scene.faces), f"{player} shows other meshes"
    unplayed = _unplayed(pair, player, cases, old)
    named = dict.fromkeys([*closed, *sorted({clip for clip, _ in unplayed})])
    found = Played(unplayed=[clips[n].get("name", f"{n}") for n in named])
    face = pair.face.in_numbers_of(em.read_rig(pair.source))
    paths = face.paths(_bent(pair))
    for case, original, bent in zip(cases, old, new, strict=True):
        original, bent = (
            {node: rows for node, rows in own.items() if (case.bent.clip, node) not in unplayed}
            for own in (original, bent)
        )
        if case.bent.clip is None:
            found.poses += 1
        else:
            found.moments += 1
        specified = as_shown(pair.new, player, _pose(pair.new, case.bent))
        found.posed = max(found.posed, _apart(bent, specified) / pair.extent)
        specified = as_shown(pair.old, player, _pose(pair.old, case.straight))
        found.original = max(found.original, _apart(original, specified) / pair.extent)
        if case.kind == "ends":
            found.ends = max(found.ends, _apart(bent, original) / pair.extent)
        if case.kind == "alone":
            name, t = case.slider
            aim = _on_path(pair, player, face, face.at(paths[name], t))
            found.between = max(found.between, _apart(bent, aim) / pair.extent)
            found.straight = max(found.straight, _apart(original, aim) / pair.extent)
        if case.kind in ("key", "between"):
            aim = as_shown(pair.new, player, _led(pair, case))
            apart = _apart(bent, aim) / pair.extent
            found.off_straight = max(found.off_straight, _apart(bent, original) / pair.extent)
            if case.kind == "key":
                found.keys = max(found.keys, apart)
            else:
                found.clips = max(found.clips, apart)
    return found


def _poses(pair: Pair) -> Iterator[_Case]:
    """Sliders alone and together: at the ends, between, and mixed."""
    names = list(pair.face.targets)
    yield _by_sliders(pair, "ends", {})
    yield _by_sliders(pair, "ends", dict.fromkeys(names, 1.0))
    for name in _bent(pair):
        yield _by_sliders(pair, "ends", {name: 1.0})
        for t in BETWEEN:
            yield _by_sliders(pair, "alone", {name: t})
    random = np.random.default_rng(3)
    for _ in range(4):
        yield _by_sliders(pair, "mixed", dict(zip(names, random.random(len(names)), strict=True)))


def _bent(pair: Pair) -> list[str]:
    """The targets that have bends or a fold."""
    found: dict[str, None] = {}
    for mesh in pair.new.file.meshes:
        stored = (mesh.get("extras") or {}).get("elastomorph") or {"morphs": []}
        for own in stored["morphs"]:
            if own.get("bends") or own.get("fold"):
                found[own["target"]] = None
    return list(found)


def _by_sliders(pair: Pair, kind: str, weights: Mapping[str, float]) -> _Case:
    straight, bent = pair.sliders(weights)
    slider = next(iter(weights.items())) if kind == "alone" else ("", 0.0)
    return _Case(kind, Request(straight.weights), Request(bent.weights), slider)


def _clips(pair: Pair) -> Iterator[_Case]:
    """Every clip of weights, at keys and between them, over the weights that the file states."""
    straight = {node: pair.old.weights(node, Pose()) for node in pair.old.faces}
    bent = {node: pair.runtime(node, own) for node, own in straight.items()}
    for clip, animation in enumerate(pair.old.file.animations):
        if not any(_moves_weights(own["target"]) for own in animation["channels"]):
            continue
        keys = key_times(pair.old.file, clip)
        between = np.array([a + 0.37 * (b - a) for a, b in pairwise(keys)])
        for kind, times in (("key", keys), ("between", between)):
            for t in times[:: max(1, -(-len(times) // _KEYS))]:
                yield _Case(kind, Request(straight, clip, t), Request(bent, clip, t))


def _moves_weights(target: Mapping[str, Any]) -> bool:
    pointer = (target.get("extensions") or {}).get("KHR_animation_pointer", {}).get("pointer", "")
    return target["path"] == "weights" or "/weights" in pointer


def _pose(scene: Scene, request: Request) -> Pose:
    """The pose of a request: what its clip moves, else its weights."""
    if request.clip is None:
        return Pose(dict(request.weights))
    pose = played(scene, request.clip, request.time)
    for node, own in request.weights.items():
        if scene.file.nodes[node]["mesh"] not in pose.of_mesh:
            pose.weights.setdefault(node, own)
    return pose


def _led(pair: Pair, case: _Case) -> Pose:
    """The bent file posed as the original's clip moves the sliders."""
    pose = _pose(pair.old, case.straight)
    weights = {n: pair.runtime(n, pair.old.weights(n, pose)) for n in pair.old.faces}
    return Pose(weights, {}, pose.transforms)


def _unplayed(
    pair: Pair, player: str, cases: list[_Case], old: list[dict[int, Floats]]
) -> set[tuple[int, int]]:
    """Clip and node of what the program shows elsewhere than is specified."""
    found = set()
    for case, original in zip(cases, old, strict=True):
        clip = case.straight.clip
        if clip is not None:
            specified = as_shown(pair.old, player, _pose(pair.old, case.straight))
            for node, rows in specified.items():
                if _apart(original, {node: rows}) > UNPLAYED * pair.extent:
                    found.add((clip, node))
    return found


def _on_path(pair: Pair, player: str, face: Face, rows: Floats) -> dict[int, Floats]:
    found: dict[int, list[Floats]] = {}
    for (node, primitive), place in face.places.items():
        found.setdefault(node, []).append(seen(pair.old, player, node, primitive, rows[place]))
    return {node: np.concatenate(own) for node, own in found.items()}


def _apart(one: Mapping[int, Floats], other: Mapping[int, Floats]) -> float:
    """The largest distance between the vertices of the nodes that both have."""
    nodes = [node for node in other if node in one]
    wrong = [node for node in nodes if one[node].shape != other[node].shape]
    assert not wrong, f"nodes {wrong} have other vertices"
    apart = (float(np.linalg.norm(one[n] - other[n], axis=1).max()) for n in nodes)
    return max(apart, default=0.0)
