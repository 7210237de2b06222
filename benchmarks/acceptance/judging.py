"""Everything that is asked of a bent character, as sentences about what is not so."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import elastomorph as em
from acceptance.clips import key_times, played
from acceptance.expected import Face
from acceptance.gltf_file import GltfFile
from acceptance.posing import Floats, Pose, Scene
from acceptance.runtime import bent_weights
from acceptance.tools import new_issues, unpacked
from acceptance.untouched import differences, same

ENDS = 1e-6  # of D: what single precision leaves of a face whose bends weigh nothing
BETWEEN = (0.2, 0.5, 0.85)


@dataclass
class Verdict:
    """What was found of one character."""

    source: Path
    problems: list[str] = field(default_factory=list)
    targets: tuple[int, int] = (0, 0)  # of the mesh that has most of them, before and after
    bent: int = 0  # sliders with a bend
    bytes: tuple[int, int] = (0, 0)
    seconds: float = 0.0  # of bending
    ends: float = 0.0  # largest deviation at 0 and 1, fraction of D
    between: float = 0.0  # largest deviation from ``auto`` between
    straight: float = 0.0  # largest distance of ``auto`` from the straight line
    clips: float = 0.0  # largest deviation of clips between keys
    unsteady: int = 0  # comparisons with a path that numbers a hundred-millionth off change as much


class Pair:
    """A character and what bending made of it, both posed from their files."""

    def __init__(self, source: Path, bent: Path, folder: Path) -> None:
        self.source, self.bent, self.folder = source, bent, folder
        self.before, self.after = GltfFile.read(source), GltfFile.read(bent)
        self.old = Scene(unpacked(source, folder))
        self.new = Scene(unpacked(bent, folder))

    @cached_property
    def face(self) -> Face:
        """The face of the original."""
        return Face.of(self.old)

    @property
    def extent(self) -> float:
        """D."""
        return self.face.extent or 1.0

    @cached_property
    def names(self) -> dict[int, list[str]]:
        """Names of the targets by node of the original."""
        return {n: self.old.names(self.old.file.nodes[n]["mesh"]) for n in self.old.faces}

    def sliders(self, weights: Mapping[str, float]) -> tuple[Pose, Pose]:
        """Both posed by sliders: straight, and bent as a runtime does it."""
        straight, bent = Pose(), Pose()
        for node, names in self.names.items():
            own = {name: weights.get(name, 0.0) for name in names}
            straight.weights[node] = np.array(list(own.values()))
            bent.weights[node] = self.runtime(node, straight.weights[node])
        return straight, bent

    def runtime(self, node: int, weights: Floats) -> Floats:
        """The weights of the bent mesh of a node, from those of its sliders."""
        mesh = self.new.file.meshes[self.new.file.nodes[node]["mesh"]]
        names = self.new.names(self.new.file.nodes[node]["mesh"])
        stored = (mesh.get("extras") or {}).get("elastomorph")
        sliders = dict(zip(self.names[node], map(float, weights), strict=True))
        return bent_weights(stored, names, sliders)

    def apart(self, one: dict[Any, Floats], other: dict[Any, Floats]) -> float:
        """The farthest that a vertex is from where it is in another pose, fraction of D."""
        assert list(one) == list(other)
        farthest = (np.linalg.norm(one[key] - other[key], axis=1).max() for key in one)
        return float(max(farthest)) / self.extent


def judge(
    source: Path,
    folder: Path,
    *,
    keys_tolerance: float = 1e-4,
    validator: bool = True,
) -> Verdict:
    """Bend a character and look at all that is promised of it.

    Args:
        source: The character.
        folder: Receives what is written.
        keys_tolerance: Of `elastomorph.bend`.
        validator: Whether to ask the Khronos validator.
    """
    found = Verdict(source)
    bent = folder / f"{source.stem}.bent{source.suffix}"
    content = source.read_bytes()
    given: dict[str, Any] = {"keys_tolerance": keys_tolerance}
    planned = em.bend(source, None, **given)
    if [own for own in folder.iterdir() if own != source]:
        found.problems.append("a dry run has written a file")
    start = time.perf_counter()
    report = em.bend(source, bent, **given)
    found.seconds = time.perf_counter() - start
    if source.read_bytes() != content:
        found.problems.append("the source has changed")
    pair = Pair(source, bent, folder)
    found.bytes = (_size(source), _size(bent))
    counts = [[scene.count(n) for n in scene.faces] for scene in (pair.old, pair.new)]
    found.targets = (max(counts[0]), max(counts[1]))
    found.problems += differences(pair.before, pair.after, (pair.old.file, pair.new.file))
    if validator:
        found.problems += new_issues(source, bent)
    found.problems += [*_ends(pair, found), *_between(pair, found, report)]
    found.problems += [*_defaults(pair), *_clips(pair, found, keys_tolerance), *_expressions(pair)]
    found.problems += [*_undone(pair), *_again(pair, given)]
    found.problems += _as_planned(planned, report, found)
    return found


def _ends(pair: Pair, found: Verdict) -> Iterator[str]:
    """Sliders at 0 and 1, alone and all: the original."""
    every = list(pair.face.targets)
    poses: list[dict[str, float]] = [{}, dict.fromkeys(every, 1.0), *({n: 1.0} for n in every)]
    for weights in poses:
        straight, bent = pair.sliders(weights)
        apart = pair.apart(pair.old.posed(straight), pair.new.posed(bent))
        found.ends = max(found.ends, apart)
        if not apart <= ENDS:
            yield f"with {[*weights][:3]} at 1 vertices are {apart:.1e} of D away"


def _between(pair: Pair, found: Verdict, report: Any) -> Iterator[str]:
    """Between, each slider alone follows ``auto``."""
    face = pair.face.in_numbers_of(em.read_rig(pair.source))
    paths = face.paths(list(face.targets))
    shaken = face.shaken()
    others: dict[str, em.Morph] = {}

    def unsteady(name: str, t: float) -> float:
        """How far the path is from that of the same face in other numbers."""
        if name not in others:
            others[name] = shaken.paths([name])[name]
        return 2 * _largest(shaken.at(others[name], t) - face.at(paths[name], t)) / pair.extent

    stated = {own.name: own.error for own in report.bent}
    for name, path in paths.items():
        found.bent += len(path.bends) > 0
        # Both are baked: each is as far from the path as it states.
        bake = path.bake_error * path.neutral.diameter / pair.extent
        allowed = stated.get(name, 1e-5) + bake + report.storage_error
        for t in BETWEEN:
            straight, bent = pair.sliders({name: t})
            posed = pair.new.posed(bent)
            aim = face.at(path, t)
            line = pair.old.posed(straight)
            for key, place in face.places.items():
                away = _largest(posed[key] - aim[place]) / pair.extent
                found.between = max(found.between, away)
                gained = _largest(line[key] - aim[place]) / pair.extent
                found.straight = max(found.straight, gained)
                steady = away <= allowed + ENDS
                found.unsteady += not steady
                if not steady and not away <= allowed + ENDS + unsteady(name, t):
                    yield f"{name} at {t} is {away:.1e} of D from auto (straight: {gained:.1e})"


def _defaults(pair: Pair) -> Iterator[str]:
    """Default weights of a file are extended as a runtime extends them."""
    for node in pair.old.faces:
        straight = pair.old.weights(node, Pose())
        expected = pair.runtime(node, straight)
        if not np.allclose(pair.new.weights(node, Pose()), expected, atol=1e-6):
            yield f"the default weights of node {node} are not those of its sliders"


def _clips(pair: Pair, found: Verdict, tolerance: float) -> Iterator[str]:
    """Clips show what sliders would show that they move: exactly at keys, nearly between."""
    for clip, animation in enumerate(pair.old.file.animations):
        name = animation.get("name", clip)
        keys = key_times(pair.old.file, clip)
        for t in (*keys, *_between_keys(keys)):
            straight, bent = played(pair.old, clip, t), played(pair.new, clip, t)
            weights = {n: pair.old.weights(n, straight) for n in pair.old.faces}
            aim = Pose({n: pair.runtime(n, w) for n, w in weights.items()}, {}, bent.transforms)
            shown = pair.new.posed(bent)
            apart = pair.apart(shown, pair.new.posed(aim))
            at_key = t in keys
            found.clips = max(found.clips, 0.0 if at_key else apart)
            if not apart <= (ENDS if at_key else tolerance + ENDS):
                yield f"clip {name!r} is {apart:.1e} of D away at {t:.4g} s (key: {at_key})"
            if all(np.isin(own, (0, 1)).all() for own in weights.values()):
                apart = pair.apart(shown, pair.old.posed(straight))
                if not apart <= ENDS:
                    yield f"clip {name!r} is {apart:.1e} of D from the original at {t:.4g} s"


def _between_keys(keys: Floats) -> Iterator[float]:
    for before, after in pairwise(keys):
        for part in (0.13, 0.5, 0.77):
            yield float(before + part * (after - before))


def _expressions(pair: Pair) -> Iterator[str]:
    """A player of VRM, which knows expressions only, shows what it showed."""
    before, after = _binds(pair.before.document), _binds(pair.after.document)
    if before != after:
        yield "the expressions of VRM have changed"
    for name, binds in before.items():
        for strength in (0.0, 0.4, 1.0):
            old, new = Pose(), Pose()
            for scene, pose in ((pair.old, old), (pair.new, new)):
                for node in scene.faces:
                    pose.weights[node] = np.zeros(scene.count(node))
                    mesh = scene.file.nodes[node]["mesh"]
                    for (kind, number), index, weight in binds:
                        if number == (node if kind == "node" else mesh):
                            pose.weights[node][index] += strength * weight
            apart = pair.apart(pair.old.posed(old), pair.new.posed(new))
            if not apart <= ENDS:
                yield f"the expression {name!r} at {strength} is {apart:.1e} of D away"


def _binds(document: dict[str, Any]) -> dict[str, list[tuple[tuple[str, int], int, float]]]:
    """Targets by expression: of a node or mesh, its number and its weight."""
    extensions = document.get("extensions", {})
    found = {}
    groups = extensions.get("VRM", {}).get("blendShapeMaster", {}).get("blendShapeGroups", [])
    for number, group in enumerate(groups):
        found[f"{number} {group.get('name')}"] = [
            (("mesh", own["mesh"]), own["index"], own["weight"] / 100) for own in group["binds"]
        ]
    expressions = extensions.get("VRMC_vrm", {}).get("expressions", {})
    for kind in ("preset", "custom"):
        for name, own in expressions.get(kind, {}).items():
            found[name] = [
                (("node", bind["node"]), bind["index"], bind["weight"])
                for bind in own.get("morphTargetBinds", [])
            ]
    return found


def _undone(pair: Pair) -> Iterator[str]:
    """What `unbend` gives back is the original: JSON equal as data, buffers byte for byte."""
    back = pair.folder / f"{pair.source.stem}.back{pair.source.suffix}"
    em.unbend(pair.bent, back)
    file = GltfFile.read(back)
    before, after = (_without_places(own.document) for own in (pair.before, file))
    if not same(before, after):
        yield f"unbent, {_where(before, after)} is not as it was"
    if pair.before.contents != file.contents:
        yield "unbent, the bytes of a buffer are not as they were"
    if pair.before.chunk is not None and pair.before.chunk != file.chunk:
        yield "unbent, the binary chunk is not as it was"


def _without_places(document: dict[str, Any]) -> dict[str, Any]:
    """A document without the names of other files, which may not be those of another document."""
    buffers = [
        {**own, "uri": "a file"} if not own.get("uri", "data:").startswith("data:") else own
        for own in document.get("buffers", [])
    ]
    return {**document, "buffers": buffers} if "buffers" in document else document


def _where(one: Any, other: Any, at: str = "the document") -> str:
    """The place of the first difference of two pieces of JSON."""
    if isinstance(one, dict) and isinstance(other, dict):
        if list(one) != list(other):
            return f"{at}, with the keys {list(other)} for {list(one)},"
        pairs = [(key, one[key], other[key]) for key in one]
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        pairs = [(number, a, b) for number, (a, b) in enumerate(zip(one, other, strict=True))]
    else:
        return f"{at}, {str(other)[:60]} for {str(one)[:60]},"
    return next(_where(a, b, f"{at}/{key}") for key, a, b in pairs if not same(a, b))


def _again(pair: Pair, given: dict[str, Any]) -> Iterator[str]:
    """Bending what is bent gives what bending the original gives."""
    again = pair.folder / "again" / pair.bent.name  # what it names is named after it
    again.parent.mkdir()
    em.bend(pair.bent, again, **given)
    file = GltfFile.read(again)
    before, after = (_without_places(own.document) for own in (pair.after, file))
    if not same(before, after):
        yield f"bent again, {_where(before, after)} is not as it was"
    if file.contents != pair.after.contents:
        yield "bent again, the bytes of a buffer are others"


def _as_planned(planned: Any, report: Any, found: Verdict) -> Iterator[str]:
    """A dry run says what is then written, and the report what is there."""
    if planned.output is not None or replace(planned, output=report.output) != report:
        yield "a dry run reports another result than writing does"
    if report.targets != found.targets[1] or report.targets_before != found.targets[0]:
        yield f"the report says {report.targets} targets, and there are {found.targets[1]}"
    if abs(report.bytes - found.bytes[1]) > 0.02 * found.bytes[1]:
        yield f"the report says {report.bytes:,} bytes, and there are {found.bytes[1]:,}"


def _size(path: Path) -> int:
    """Bytes of a file and of the buffers beside it."""
    file = GltfFile.read(path)
    beside = (own.get("uri", "data:") for own in file.buffers)
    outside = sum(
        len(content)
        for uri, content in zip(beside, file.contents, strict=True)
        if not uri.startswith("data:")
    )
    return path.stat().st_size + outside


def _largest(vectors: Floats) -> float:
    return float(np.linalg.norm(vectors, axis=1).max(initial=0.0))
