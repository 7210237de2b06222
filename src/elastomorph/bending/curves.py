"""The curves of a bent character apart from its file: given back to another, or kept beside it.

Pipelines that pack or convert a bent file keep its targets, but often not the extras that say which
of them are bends and what these follow. A file of curves has the extras of each mesh, which engines
without access to extras read from beside the character::

    {"version": 1, "meshes": [{"mesh": 0, "names": ["face"],
                               "targetNames": […], "elastomorph": {…}}]}
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from elastomorph.bending.files import Character, require_output, write_character
from elastomorph.bending.plan import farthest
from elastomorph.bending.report import BendReport, BentTarget
from elastomorph.bending.undo import is_bent
from elastomorph.errors import FormatError
from elastomorph.io.atomic import read_bytes, replacing
from elastomorph.io.blend_shapes import different_names
from elastomorph.io.gltf.container import GltfFile, object_of, open_gltf
from elastomorph.io.gltf.mesh_extras import is_part
from elastomorph.io.gltf.nodes import placed_meshes
from elastomorph.io.gltf.primitives import Primitives, target_count
from elastomorph.io.gltf.reader import read_meshes, require_known_extensions, rig_of
from elastomorph.io.gltf.rig_extras import (
    described_meshes,
    least_version,
    numbered,
    stored_rig,
)
from elastomorph.io.untrusted import MemoryBudget, naming_file
from elastomorph.rig.build import extent_of

_VERSION = 1
# Displacements of one target that went through a pipeline differ by its rounding; those of two
# targets by more than half of themselves, but of mirror images by all.
_SAME_SHAPE = 0.25
# As a fraction of the size of a mesh: vertices farther from those of the other are not compared.
_SAME_PLACE = 0.01
_COMPARED = 3000  # vertices


@dataclass(frozen=True, eq=False)
class _Mesh:
    """A mesh with targets, of a file or of a file of curves."""

    number: int
    names: Collection[str]
    given: Sequence[str]  # Names of its targets
    stored: Mapping[str, Any] | None  # What it says of its paths
    read: Primitives | None = None  # None in a file of curves
    size: float = 1.0  # Diameter of its surface

    @cached_property
    def alone(self) -> dict[str, int]:
        """Numbers of the targets whose names no other of the mesh has."""
        return {n: i for i, n in enumerate(self.given) if self.given.count(n) == 1}

    @property
    def nameless(self) -> bool:
        """Whether its targets have lost their names."""
        return list(self.given) == [f"target_{number}" for number in range(len(self.given))]


def give_back(
    path: str | Path,
    output: str | Path | None,
    source: str | Path,
    curves: str | Path | None,
    say: Callable[[str], None],
) -> BendReport:
    """Give a file the curves of the bent character that a pipeline has made it from."""
    say(f"reading {source}")
    known = _meshes_of_curves(source) if Path(source).suffix.lower() == ".json" else None
    known = _meshes(open_gltf(source)) if known is None else known
    if not any(own.stored for own in known):
        raise FormatError(source, "it has no curves; name a file that 'elastomorph bend' wrote")
    say(f"reading {path}")
    file = open_gltf(path)
    character = Character(file)
    if output is not None:
        require_output(character, output)
    document = copy.deepcopy(file.document)
    if is_bent(file):
        _drop_record(file, document)
    matched = {"name": 0, "index": 0, "shape": 0}
    given = 0
    for mesh in _meshes(file):
        own = _closest(mesh, known)
        if own.stored is not None:
            pairs, how = _pairs(own, mesh)
            for kind, count in how.items():
                matched[kind] += count
            given += _describe(document, file, own, mesh, pairs)
    if not given:
        file.refuse(f"none of its morph targets is one that bends in {source}")
    result = GltfFile(file.path, document, file.chunk, file.size, file.rest)
    report = _report(result, output, matched)
    if output is not None:
        say(f"writing {output}")
        write_character(character, output, document, file.chunk, {})
    if curves is not None:
        write_curves(result, curves)
    return report


def write_curves(file: GltfFile, path: str | Path) -> None:
    """Write the curves of a bent character beside it."""
    entries = [
        {
            "mesh": own.number,
            "names": list(dict.fromkeys(own.names)),
            "targetNames": list(own.given),
            "elastomorph": own.stored,
        }
        for own in _meshes(file)
        if own.stored is not None
    ]
    content = {"version": _VERSION, "meshes": entries}
    with replacing(path) as out:
        out.write(json.dumps(content, separators=(",", ":"), ensure_ascii=False).encode())


def _meshes(file: GltfFile) -> list[_Mesh]:
    """The meshes of a file that have targets, each once, with the names of all its nodes."""
    require_known_extensions(file)
    with naming_file(file.path), np.errstate(all="ignore"):
        described = described_meshes(file)
        placed = [
            own
            for own in placed_meshes(file)
            if target_count(file, own) or is_part(described.get(own.number))
        ]
        if not placed:
            file.refuse("none of its meshes has morph targets")
        names: dict[int, list[str]] = {}
        for one in placed:
            names.setdefault(one.number, []).extend(one.names)
        first = {number: next(one for one in placed if one.number == number) for number in names}
        found = []
        for own in read_meshes(file, list(first.values())):
            for sheet in own.sheets:
                number, shown = sheet.placed.number, sheet.primitives
                stored = described.get(number) if own.stored.described else None
                size = own.part.mesh.diameter or 1.0
                found.append(_Mesh(number, names[number], shown.given, _paths(stored), shown, size))
        return sorted((own for own in found if own.given), key=lambda own: own.number)


def _paths(stored: Any) -> dict[str, Any] | None:
    """What a mesh says of its paths, without what it says of the vertices of its surface."""
    if stored is None:
        return None
    whole = stored.get("whole", {})
    groups = {"groups": whole["groups"]} if "groups" in whole else {}
    return {k: v for k, v in stored.items() if k not in ("surface", "part", "whole")} | groups


def _meshes_of_curves(path: str | Path) -> list[_Mesh]:
    content = read_bytes(path)
    try:
        held = json.loads(content)
        if held["version"] != _VERSION:
            raise ValueError("it has another version than 1")
        found = []
        for own in held["meshes"]:
            given = own["targetNames"]
            budget = MemoryBudget(path, len(content))
            stored_rig(own["elastomorph"], different_names(given), budget, given)
            found.append(_Mesh(own["mesh"], own["names"], given, own["elastomorph"]))
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError) as problem:
        said = f"this is no file of curves that 'elastomorph bend' wrote: {problem}"
        raise FormatError(path, said) from None
    return found


def _drop_record(file: GltfFile, document: dict[str, Any]) -> None:
    """Leave out what undoes bends, which is of the file that a pipeline has changed."""
    try:
        Character.of(file)
    except FormatError:
        pass
    else:
        file.refuse("nothing has changed it since it was bent, so that it has all its curves")
    del document["extras"]["elastomorph"]
    if not document["extras"]:
        del document["extras"]


def _closest(mesh: _Mesh, known: Sequence[_Mesh]) -> _Mesh:
    """The mesh that another is most likely made from."""

    def likeness(own: _Mesh) -> tuple[float, ...]:
        names = len(mesh.alone.keys() & own.alone.keys())
        near = -_place_of(own, mesh)[1]
        return (names, len({*mesh.names} & {*own.names}), len(mesh.given) == len(own.given), near)

    return max(known, key=likeness)


def _place_of(own: _Mesh, mesh: _Mesh) -> tuple[NDArray[np.intp], float]:
    """The nearest vertex of one mesh to each of those compared of another, and how far they are.

    That is a median, as a fraction of the diameter; infinite where there are no vertices.
    """
    if own.read is None or mesh.read is None:
        return np.zeros(0, dtype=np.intp), np.inf
    distances, places = cKDTree(own.read.vertices()).query(_compared(mesh.read))
    return np.asarray(places), float(np.median(distances)) / own.size


def _compared(read: Primitives) -> NDArray[np.float64]:
    vertices = read.vertices()
    return vertices[:: max(1, len(vertices) // _COMPARED)]


def _pairs(own: _Mesh, mesh: _Mesh) -> tuple[dict[int, int], dict[str, int]]:
    """For targets of one mesh, the numbers of the same in another; how many by what.

    By their names where these are unique, then by their numbers where the shapes there agree (or
    there are none to be compared), and then by shape alone.
    """
    pairs = {number: mesh.alone[n] for n, number in own.alone.items() if n in mesh.alone}
    how = {"name": len(pairs)}
    away = _differences(own, mesh)
    same_count = len(own.given) == len(mesh.given)
    for number in range(min(len(own.given), len(mesh.given))):
        free = number not in pairs and number not in pairs.values()
        alike = same_count if away is None else away[number, number] <= _SAME_SHAPE
        if free and alike and (mesh.nameless or own.given[number] == mesh.given[number]):
            pairs[number] = number
    how["index"] = len(pairs) - how["name"]
    left = [number for number in range(len(own.given)) if number not in pairs]
    free_ones = [number for number in range(len(mesh.given)) if number not in pairs.values()]
    if away is not None and left and free_ones:
        costs = away[np.ix_(left, free_ones)]
        for i, j in zip(*linear_sum_assignment(costs), strict=True):
            if costs[i, j] <= _SAME_SHAPE:
                pairs[left[i]] = free_ones[j]
    how["shape"] = len(pairs) - how["name"] - how["index"]
    return pairs, how


def _differences(own: _Mesh, mesh: _Mesh) -> NDArray[np.float64] | None:
    """(S, T) how far each target is from each of another mesh, as a fraction of the larger.

    None where the meshes are not at one place.
    """
    places, apart = _place_of(own, mesh)
    if apart > _SAME_PLACE or own.read is None or mesh.read is None:
        return None
    step = max(1, mesh.read.count // _COMPARED)
    ours = [own.read.displacement(name)[places] for name in own.read.targets]
    theirs = [mesh.read.displacement(name)[::step] for name in mesh.read.targets]
    sizes = [[np.linalg.norm(one) for one in some] for some in (ours, theirs)]
    larger = np.maximum.outer(sizes[0], sizes[1])
    lengths = np.array([[np.linalg.norm(one - other) for other in theirs] for one in ours])
    away: NDArray[np.float64] = np.where(larger > 0, lengths / np.where(larger > 0, larger, 1), 0.0)
    return away


def _describe(
    document: dict[str, Any], file: GltfFile, own: _Mesh, mesh: _Mesh, pairs: Mapping[int, int]
) -> int:
    """Write what one mesh says of its paths to another; how many bend."""
    entry = document["meshes"][mesh.number]
    extras = entry["extras"] = dict(object_of(entry.get("extras")))
    names = list(mesh.given)
    for number, place in pairs.items() if mesh.nameless else ():
        names[place] = own.given[number]
    extras["targetNames"] = names

    def placed(stored: Mapping[str, Any]) -> dict[str, Any]:
        if "target" not in stored:  # a pair bend
            return dict(stored)
        place = pairs[numbered(stored, own.given)]
        told = {k: v for k, v in stored.items() if k != "index"} | {"target": names[place]}
        return told | ({"index": place} if names.count(names[place]) > 1 else {})

    assert own.stored is not None
    morphs: list[dict[str, Any]] = []
    for stored in own.stored.get("morphs", []):
        if "target" in stored and numbered(stored, own.given) not in pairs:
            continue
        bends = stored.get("bends", [])
        kept = [placed(bend) for bend in bends if not _lost(bend, own, mesh, file, pairs)]
        morphs.append(placed(stored) | {"bends": kept})
    known = {morph["name"] for morph in morphs}
    more = {k: v for k, v in own.stored.items() if k not in ("morphs", "version")}
    for kind, inner in (("correctives", "drivers"), ("groups", "members")):
        if kind in more:
            of = [[one["name"]] if kind == "correctives" else [] for one in more[kind]]
            lists = zip(more[kind], of, strict=True)
            more[kind] = [one for one, n in lists if known.issuperset([*one.get(inner, []), *n])]
    extras["elastomorph"] = {
        "version": least_version(morphs, more.get("correctives", [])),
        "morphs": morphs,
        **more,
    }
    for node in map(object_of, document.get("nodes", [])):
        if node.get("mesh") == mesh.number:
            object_of(node.get("extras")).pop("elastomorph", None)
    return sum(bool(morph["bends"] or "fold" in morph) for morph in morphs)


def _lost(
    bend: Mapping[str, Any], own: _Mesh, mesh: _Mesh, file: GltfFile, pairs: Mapping[int, int]
) -> bool:
    """Whether a bend is in no target; refused unless it moves nothing."""
    number = numbered(bend, own.given)
    read = own.read
    still = read is not None and not read.displacement(read.targets[number]).any()
    if number not in pairs and not still:
        file.refuse(
            f"mesh {mesh.number} has no morph target for the bend {own.given[number]!r}, neither "
            "by name nor by number nor by shape; keep all targets in the program that made it, or "
            "bend the original again"
        )
    return number not in pairs


def _report(file: GltfFile, output: str | Path | None, matched: dict[str, int]) -> BendReport:
    with naming_file(file.path), np.errstate(all="ignore"):
        placed = placed_meshes(file)
        rig = rig_of(file, read_meshes(file, placed))
    extent = extent_of(rig)
    scale = extent or 1.0
    bent = []
    for name, morph in rig.morphs.items():
        if len(morph.bends):
            gain = farthest(morph.bend_curves, morph.bends) / scale
            error = morph.bake_error * rig.neutral.diameter / scale
            count = len(morph.bends)
            bent.append(BentTarget(name, gain, error, morph.method, count, 0, 0, folded=False))
    names = {own.name for own in bent}
    most = max(target_count(file, one) for one in placed)
    return BendReport(
        path=Path(file.path),
        output=None if output is None else Path(output),
        extent=extent,
        bent=tuple(bent),
        straight=tuple(name for name in rig.morphs if name not in names),
        left_out=(),
        targets_before=most,
        targets=most,
        meshes=(),
        clips=0,
        added_keys=0,
        bytes_before=file.size,
        bytes=file.size,
        storage_error=0.0,
        key_error=0.0,
        was_bent=False,
        matched=matched,
    )
