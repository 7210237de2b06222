"""Writes a rig as one GLB file that every viewer of morph targets plays.

Paths and performances become weight animations. Their keys are LINEAR. CUBICSPLINE would be exact
for cubic bend curves with two keys, but Blender's importer drops the tangents, and two keys of zero
without tangents are no bend at all; a straight line between keys is played alike everywhere, and
costs a few kilobytes.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import replacing
from elastomorph.io.blend_shapes import driven_weights, require_turn
from elastomorph.io.gltf.accessors import AccessorWriter, Grid, byte_normals, within_reach
from elastomorph.io.gltf.appearance import Looks
from elastomorph.io.gltf.clips import turn_channels, turned_nodes
from elastomorph.io.gltf.container import glb_chunks, without_empty
from elastomorph.io.gltf.mesh_extras import Layout, lay_out, packed, surface_extras
from elastomorph.io.gltf.meshopt import require_meshopt
from elastomorph.io.gltf.morph_targets import (
    KeptMorph,
    MorphTargets,
    NormalField,
    normal_deltas,
    targets_of_parts,
)
from elastomorph.io.gltf.rig_extras import rig_extras
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn
from elastomorph.rig.positive import with_positive_weights
from elastomorph.rig.timing import Timing, linear

Performance = tuple[ArrayLike, ArrayLike, str]
"""Times (T,) in seconds, weights (T, J) of the sliders of a rig, and a name."""

_FINEST = 4096
_BETWEEN = 8
# A frame closer to a corner than this part of a frame is left out: the corner is the key.
_BESIDE = 1e-3


@dataclass(frozen=True, eq=False)
class Clip:
    """An animation of the morph target weights."""

    name: str
    times: NDArray[np.float32]  # (T,) seconds, rising
    weights: NDArray[np.float32]  # (T, targets)
    key_error: float  # Largest distance of a vertex from its path between keys, fraction of D


def slider_clips(
    rig: Rig, targets: MorphTargets, tolerance: float, fps: float, timing: Timing = linear
) -> list[Clip]:
    """One clip a morph, of its name, that plays its path in one second.

    The keys lie on the frames of 1/fps s, no more of them than the tolerance asks for; where even
    all frames are too few, on halves, quarters, … of frames. Moments at which two pieces of a
    bend curve meet, as at a scanned in-between, are keys too.
    """
    scale = rig.neutral.diameter or 1.0
    clips = []
    for (name, morph), kept in zip(rig.morphs.items(), targets.morphs, strict=True):
        if not kept.whole:  # a pair bend moves nothing by itself
            continue
        curves = [*kept.curves, *([] if kept.fold is None else [kept.fold])]
        moved = kept.fields(morph)
        sizes = np.array([np.linalg.norm(field, axis=1).max() / scale for field in moved])
        times, error = np.array([0.0, 1.0]), 0.0
        if curves or timing is not linear:
            breaks = np.unique([time for curve in curves for time in curve.breaks[1:-1]])
            moves = partial(_moves, timing, kept, sizes)
            times, error = _keys(moves, _moments(timing, breaks), tolerance, fps)
        weights = np.zeros((len(times), len(targets.names)), dtype=np.float32)
        _fill(weights, kept, timing.at(times))
        clips.append(Clip(name, times.astype(np.float32), weights, error))
    return clips


def recorded_clips(
    rig: Rig,
    targets: MorphTargets,
    animation: Performance | Sequence[Performance],
    turn: HeadTurn | None,
) -> list[Clip]:
    """Recorded performances, one or several, in all frames of which the head may turn."""
    # One of them is a tuple that ends with its name.
    alone = len(animation) > 0 and isinstance(animation[-1], str)
    played: Any = [animation] if alone else animation
    clips = [performance_clip(rig, targets, *each) for each in played]
    require_turn(turn, sum(len(clip.times) for clip in clips))
    return clips


def performance_clip(
    rig: Rig, targets: MorphTargets, times: ArrayLike, weights: ArrayLike, name: str
) -> Clip:
    """A recorded performance of this name, one key a frame."""
    exact, table = driven_weights(rig, times, weights)
    seconds = exact.astype(np.float32)
    if seconds[0] < 0 or not np.isfinite(seconds).all() or (np.diff(seconds) <= 0).any():
        raise ParameterError(
            "the times of an animation must be seconds from 0 that rise from row to row in single "
            "precision"
        )
    found = np.zeros((len(table), len(targets.names)), dtype=np.float32)
    for column, kept in enumerate(targets.morphs):
        _fill(found, kept, table[:, column])
    return Clip(name, seconds, found, 0.0)


def weight_animation(
    accessors: AccessorWriter, clip: Clip, moved: Sequence[tuple[int, NDArray[np.int64]]]
) -> dict[str, Any]:
    """An animation of the weights of some nodes, by the numbers of the targets of each."""
    found: dict[str, Any] = {"name": clip.name, "channels": [], "samplers": []}
    for node, numbers in moved:
        times, weights = accessors.keys(clip.times, clip.weights[:, numbers])
        target = {"node": node, "path": "weights"}
        found["channels"].append({"sampler": len(found["samplers"]), "target": target})
        sampler = {"input": times, "interpolation": "LINEAR", "output": weights}
        found["samplers"].append(sampler)
    return found


def _fill(weights: NDArray[np.float32], kept: KeptMorph, t: NDArray[np.float64]) -> None:
    rows = kept.weights(t)
    weights[:, kept.first : kept.first + len(rows)] = rows.T


def _moves(
    timing: Timing, kept: KeptMorph, sizes: NDArray[np.float64], when: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(1 + curves, T) how far Δ and each bend move a vertex at most."""
    return sizes[:, None] * kept.weights(timing.at(when))


def _moments(timing: Timing, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """The moments of a clip, to rounding, at which a timing passes some times of the path."""
    if timing is linear:
        return times
    grid = np.linspace(0.0, 1.0, _FINEST + 1)
    above = timing.at(grid) > times[:, None]
    which, cells = np.nonzero(above[:, 1:] != above[:, :-1])
    low, high = grid[cells], grid[cells + 1]
    for _ in range(40):
        middle = (low + high) / 2
        passed = (timing.at(middle) > times[which]) == above[which, cells + 1]
        low, high = np.where(passed, low, middle), np.where(passed, middle, high)
    return np.unique(high)


def _keys(
    moves: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    corners: NDArray[np.float64],
    tolerance: float,
    fps: float,
) -> tuple[NDArray[np.float64], float]:
    """Times of the keys, and the error they leave."""
    steps = max(1, round(fps))
    if len(corners) > steps:  # of so many short pieces, none stands out
        corners = corners[:0]
    while True:
        frames = np.arange(steps + 1) / steps
        if len(corners):
            apart = np.abs(frames[:, None] - corners).min(axis=1) > _BESIDE / steps
            apart[[0, -1]] = True
            frames = np.union1d(frames[apart], corners)
        places = np.arange((len(frames) - 1) * _BETWEEN + 1) / _BETWEEN
        fine = np.interp(places, np.arange(len(frames)), frames)
        stops = set(np.searchsorted(frames, corners).tolist())
        keys, error = _fewest(moves(fine), fine, stops, tolerance)
        if error <= tolerance or steps * 2 > _FINEST:
            return frames[keys], error
        steps *= 2


def _fewest(
    moves: NDArray[np.float64], fine: NDArray[np.float64], stops: set[int], tolerance: float
) -> tuple[NDArray[np.int64], float]:
    """Greedily, the longest straight piece from each key on, none of them past a stop."""
    last = (len(fine) - 1) // _BETWEEN
    keys, largest = [0], 0.0
    while keys[-1] < last:
        start = keys[-1]
        reached, error = start + 1, _gap(moves, fine, start, start + 1)
        while reached < last and reached not in stops:
            longer = _gap(moves, fine, start, reached + 1)
            if longer > tolerance:
                break
            reached, error = reached + 1, longer
        keys.append(reached)
        largest = max(largest, error)
    return np.array(keys), largest


def _gap(moves: NDArray[np.float64], fine: NDArray[np.float64], start: int, stop: int) -> float:
    """The largest Σ_k |chord - b_k|·max|D_k| between two keys."""
    inside = slice(start * _BETWEEN, stop * _BETWEEN + 1)
    piece, when = moves[:, inside], fine[inside]
    part = (when - when[0]) / (when[-1] - when[0])
    chord = piece[:, :1] * (1 - part) + piece[:, -1:] * part
    return float(np.abs(chord - piece).sum(axis=0).max())


_POINTS, _TRIANGLES = 0, 4

# The default of glTF is bare metal, which is black where nothing is reflected.
_MATERIAL = {
    "pbrMetallicRoughness": {
        "baseColorFactor": [0.8, 0.8, 0.8, 1.0],
        "metallicFactor": 0.0,
        "roughnessFactor": 0.7,
    },
    "emissiveFactor": [0.0, 0.0, 0.0],
    "alphaMode": "OPAQUE",
    "doubleSided": False,
}
# A normal that turns by less (0.06°) is lit alike; writing it would make most targets dense.
_LEAST_TURN = 1e-3
# What storing in whole steps may move a vertex, as a fraction of D.
_COMPRESSED_ERROR = 1e-4
# The largest single float is 3.4e38; differences and sums of coordinates must fit too.
_LARGEST = 1e37
# The header of a GLB file counts its bytes in 32 bits.
_LARGEST_FILE = 2**32 - 1


@dataclass(frozen=True)
class GlbReport:
    """What `write_glb` wrote. Errors are upper bounds for one slider between 0 and 1.

    Attributes:
        vertices: Vertices in the file: those of the mesh, and copies along seams of textures and
            between materials, each of which is a mesh of its own.
        triangles: Triangles that the polygons were cut into.
        targets: Morph targets, Δ and bends together.
        bends: How many of them are bends.
        dropped_bends: Names of the bends that were too small to keep.
        bytes: Size of the file.
        parts: Bytes of its parts: ``json``, ``surface`` (indices, neutral, texture coordinates),
            ``positions`` and ``normals`` of the morph targets, and ``animations``.
        dropped_error: Largest distance by which a dropped bend, or a target that a mesh does not
            have, moves a vertex, fraction of D.
        rounding_error: Largest error of storing in single precision, or in whole steps where it
            is compressed, fraction of D.
        key_error: Largest error of an animation between its keys, fraction of D.
    """

    vertices: int
    triangles: int
    targets: int
    bends: int
    dropped_bends: tuple[str, ...]
    bytes: int
    dropped_error: float
    rounding_error: float
    key_error: float
    parts: Mapping[str, int] = field(default_factory=dict)

    @property
    def largest_error(self) -> float:
        """The three errors together, fraction of D."""
        return self.dropped_error + self.rounding_error + self.key_error


def write_glb(
    path: str | Path | BinaryIO,
    rig: Rig,
    *,
    normals: Literal["delta", "none"] = "delta",
    tolerance: float = 5e-7,
    keys_tolerance: float = 1e-4,
    fps: float = 30,
    sparse: bool = True,
    clips: bool = False,
    timing: Timing = linear,
    animation: Performance | Sequence[Performance] | None = None,
    settings: Mapping[str, Any] | None = None,
    compress: bool = False,
    turn: HeadTurn | None = None,
) -> GlbReport:
    """Write a rig as a binary glTF 2.0 file.

    Δ of a morph becomes the morph target of its name, each of its bends another one
    (``jawOpen.bend1``), but for Δ itself, whose curve adds to the weight of Δ. Software that sets
    weights itself gives Δ the weight t and the bends b_k(t): their curves are in
    ``extras.elastomorph`` of the mesh. Bends with curves below 0 are stored the other way round, as
    some programs hold weights between 0 and 1.

    Each material becomes a mesh with a node of its own, with the vertices it shows and the targets
    that move them: players hold every target of a mesh for all of its vertices. `read_glb` gives
    them back as one, with the vertices in their order.

    Args:
        path: The file, replaced at once; or a binary file that is open for writing.
        rig: The rig.
        normals: ``"delta"``: morph targets turn the normals too, for half as many bytes again;
            ``"none"``: the normals stay those of the neutral.
        tolerance: Where a bend moves vertices no farther than this fraction of D, it is left out;
            so is a target of a mesh that it moves no farther.
        keys_tolerance: How far the animation of a path may be from it between keys, likewise.
        fps: Frames per second, rounded to a whole number; keys lie on frames where they can.
        sparse: Store only the vertices that a morph target moves, where that is smaller.
        clips: Write an animation a morph, of its name, that plays it from 0 to 1 in one second.
        timing: The t of a path at each moment of its animation; see `elastomorph.rig.timing`.
        animation: A recorded performance, in place of those: times (T,) in seconds from 0, weights
            (T, J) of the sliders of ``rig.names``, a name; or several.
        settings: How the rig was made, as JSON; `elastomorph.io.registry` gives it back.
        compress: Store positions in whole steps, at most 1e-4 of D away, normals in 8 bits, packed
            by meshoptimizer: a fifth of the size, for players that know these extensions.
        turn: How a node ``head`` that holds the face turns, in all frames one after another.

    Returns:
        What was written, and how far it can be from the rig.

    Raises:
        FileError: The file cannot be written.
        FormatError: Coordinates are too large for single precision, or the file for 4 GiB.
        MissingExtraError: To compress it, meshopt is needed, and not installed.
        ParameterError: An argument is out of its range.
    """
    require_glb_settings(normals, tolerance, keys_tolerance, fps)
    _require_storable(name := path if isinstance(path, str | Path) else "the GLB file", rig)
    rig = with_positive_weights(rig)
    content = _Content.of(rig, tolerance, _grid(rig) if compress else None)
    played = recorded_clips(rig, content.targets, animation or (), turn)
    if clips and not animation:
        played = slider_clips(rig, content.targets, keys_tolerance, fps, timing)
    chunks, report = content.file(played, normals == "delta", sparse, settings, turn)
    _require_countable(name, report.bytes)
    with replacing(path) if isinstance(path, str | Path) else nullcontext(path) as file:
        file.writelines(chunks)
    return report


def _grid(rig: Rig) -> Grid:
    """The steps of a compressed file; refused, before any work, where nothing can pack it."""
    require_meshopt()
    return Grid.of(rig, _COMPRESSED_ERROR)


@dataclass(frozen=True, eq=False)
class _Content:
    """What a file holds of a rig."""

    rig: Rig
    targets: MorphTargets
    layout: Layout
    held: NDArray[np.bool_]  # (P, T) the targets that each mesh has
    dropped_error: float
    grid: Grid | None

    @classmethod
    def of(cls, rig: Rig, tolerance: float, grid: Grid | None) -> _Content:
        targets, layout = MorphTargets.of(rig, tolerance, grid), lay_out(rig.neutral)
        return cls(rig, targets, layout, *targets_of_parts(rig, targets, layout, tolerance), grid)

    def file(
        self,
        clips: Sequence[Clip],
        with_normals: bool,
        sparse: bool,
        settings: Mapping[str, Any] | None,
        turn: HeadTurn | None,
    ) -> tuple[list[bytes], GlbReport]:
        """The bytes of the file, and what they hold."""
        neutral, grid = self.rig.neutral, self.grid
        accessors = AccessorWriter(compress=grid is not None)
        primitives = self._primitives(accessors, with_normals, sparse)
        meshes = self._meshes(primitives)
        names = [*(neutral.materials.names if neutral.materials is not None else ()), "unnamed"]
        shown = [names[own.label] for own in self.layout.primitives]
        nodes: list[dict[str, Any]] = [{"name": "face"} | ({} if grid is None else grid.placing())]
        if len(meshes) == 1:
            nodes[0]["mesh"] = 0
        else:
            nodes += [{"mesh": number, "name": name} for number, name in enumerate(shown)]
            nodes[0]["children"] = list(range(1, len(nodes)))
        first = len(nodes) - len(meshes)
        moved = [(n, np.flatnonzero(own)) for n, own in enumerate(self.held, first) if own.any()]
        animations = [weight_animation(accessors, clip, moved) for clip in clips] if moved else []
        root = 0
        if turn is not None and animations:
            nodes, root = turned_nodes(nodes, turn)
            turn_channels(accessors, animations, [len(clip.times) for clip in clips], turn, root)
        views, buffers, blob = accessors.finish()
        needed = [] if grid is None else ["EXT_meshopt_compression", "KHR_mesh_quantization"]
        looks = Looks(neutral.appearance)
        asset = {"generator": "elastomorph", "version": "2.0"}
        asset |= {"copyright": neutral.copyright} if neutral.copyright else {}
        document = without_empty(
            {
                "accessors": accessors.accessors,
                "animations": animations,
                "asset": asset,
                "bufferViews": views,
                "buffers": buffers,
                "extensionsRequired": needed,
                "extensionsUsed": needed,
                "meshes": meshes,
                "nodes": nodes,
                "scene": 0,
                "scenes": [{"nodes": [root]}],
            }
        )
        # What is empty says something here: a material without light has an empty extension.
        if len(neutral.faces):
            document["materials"] = [looks.material(name, _MATERIAL) for name in shown]
        blob = looks.add_to(document, blob)
        if settings is not None:
            document["meshes"][0]["extras"]["elastomorph"]["settings"] = dict(settings)
        chunks = glb_chunks(json.dumps(document, separators=(",", ":")).encode(), blob)
        size = sum(map(len, chunks))
        sizes = {"json": size - len(blob), **accessors.sizes}
        sizes |= {"images": looks.size} if looks.size else {}
        return chunks, self._report(clips, size, sizes)

    def _report(self, clips: Sequence[Clip], size: int, parts: dict[str, int]) -> GlbReport:
        """What a file of so many bytes holds."""
        targets = self.targets
        return GlbReport(
            vertices=sum(len(own.rows) for own in self.layout.primitives),
            triangles=sum(len(own.triangles) for own in self.layout.primitives),
            targets=len(targets.names),
            bends=sum(len(kept.bends) for kept in targets.morphs),
            dropped_bends=targets.dropped,
            bytes=size,
            dropped_error=self.dropped_error,
            rounding_error=max((kept.rounding_error for kept in targets.morphs), default=0.0),
            key_error=max((clip.key_error for clip in clips), default=0.0),
            parts=parts,
        )

    def _meshes(self, primitives: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
        """A mesh a material, with what the triangles do not tell."""
        targets, layout = self.targets, self.layout
        surface = surface_extras(self.rig.neutral, layout)
        meshes = []
        for number, primitive in enumerate(primitives):
            held = np.flatnonzero(self.held[number]).tolist()
            stored = rig_extras(self.rig, targets, held)
            if len(primitives) == 1:
                stored["surface"] = surface
            else:
                rows, groups = layout.primitives[number].rows, stored.pop("groups")
                stored["part"] = {"number": number, "vertices": packed(rows)}
                if number == 0:
                    count = {"parts": len(primitives), "vertices": len(layout.vertex_of)}
                    whole = {"targets": list(targets.names), "groups": groups, "surface": surface}
                    stored["whole"] = count | whole
            extras = {"targetNames": [targets.names[n] for n in held], "elastomorph": stored}
            mesh = {"extras": extras, "primitives": [primitive], "weights": [0.0] * len(held)}
            meshes.append(mesh | {"name": "face"})
        return meshes

    def _primitives(
        self, accessors: AccessorWriter, with_normals: bool, sparse: bool
    ) -> list[dict[str, Any]]:
        """One primitive a material, each with its own vertices and the morph targets it has."""
        rig, layout, grid = self.rig, self.layout, self.grid
        vertices, faces = rig.neutral.vertices, rig.neutral.faces
        corners = NormalField.of(faces)
        at_rest = corners.normals(vertices)
        placed = layout.rows(vertices) if grid is None else layout.copies(grid.positions(vertices))
        shaded = layout.rows(at_rest) if grid is None else layout.copies(byte_normals(at_rest))
        found: list[dict[str, Any]] = []
        for number, own in enumerate(layout.primitives):
            shown = {"POSITION": accessors.vertices(placed[own.rows], "surface", bounds=True)}
            primitive: dict[str, Any] = {"attributes": shown, "mode": _POINTS, "targets": []}
            if len(faces):  # markers have no surface
                shown["NORMAL"] = accessors.vertices(shaded[own.rows], "surface")
                primitive["indices"] = accessors.indices(own.local, len(own.rows))
                primitive |= {"mode": _TRIANGLES, "material": number}
            if layout.texture is not None:
                shown["TEXCOORD_0"] = accessors.vertices(layout.texture[own.rows], "surface")
            found.append(primitive)

        def add(kind: str, part: str, column: int, rows: NDArray[Any]) -> None:
            """A displacement (V, 3) of the target of this number, in the meshes that have it."""
            for own, primitive, held in zip(layout.primitives, found, self.held, strict=True):
                if held[column]:
                    moved, bounds = layout.copies(rows)[own.rows], kind == "POSITION"
                    number = accessors.vertices(moved, part, bounds=bounds, sparse=sparse)
                    if bounds:
                        primitive["targets"].append({})
                    primitive["targets"][held[:column].sum()][kind] = number

        for morph, kept in zip(rig.morphs.values(), self.targets.morphs, strict=True):
            for column, moved in enumerate(kept.fields(morph), start=kept.first):
                rows = moved.astype(np.float32) if grid is None else grid.displacements(moved)
                add("POSITION", "positions", column, rows)
            if with_normals and len(faces):
                turned = normal_deltas(corners, morph, kept.bends, at_rest, kept.fold)
                turned[np.linalg.norm(turned, axis=2) < _LEAST_TURN] = 0.0
                for column, each in enumerate(turned[not kept.whole :], start=kept.first):
                    fits = each.astype(np.float32)
                    rows = fits if grid is None else byte_normals(within_reach(each, at_rest))
                    add("NORMAL", "normals", column, rows)
        return found


def require_glb_settings(
    normals: str = "delta",
    tolerance: float = 0.0,
    keys_tolerance: float = 0.0,
    fps: float = 30.0,
    sparse: bool = True,
    clips: bool = False,
    compress: bool = False,
) -> None:
    """Check options of `write_glb`."""
    if normals not in ("delta", "none"):
        raise ParameterError(f"normals must be 'delta' or 'none', found {normals!r}")
    for name, value in (("tolerance", tolerance), ("keys_tolerance", keys_tolerance)):
        if not math.isfinite(value) or value < 0:
            raise ParameterError(f"{name} must be a finite number from 0, found {value}")
    if not 1 <= fps <= 1000:
        raise ParameterError(f"fps must be from 1 to 1000, found {fps}")


def _require_countable(path: str | Path, size: int) -> None:
    if size > _LARGEST_FILE:
        advice = "leave out normals, export fewer morphs, or compress it"
        raise FormatError(path, f"a GLB file holds less than 4 GiB; {advice}")


def _require_storable(path: str | Path, rig: Rig) -> None:
    shapes = [own for m in rig.morphs.values() for own in (m.target.vertices, m.bends)]
    largest = max(float(np.abs(own).max(initial=0.0)) for own in [rig.neutral.vertices, *shapes])
    if largest > _LARGEST:
        raise FormatError(
            path, f"a coordinate of {largest:.3g} is too large for single precision; scale the rig"
        )
    for name, morph in rig.morphs.items():
        if not math.isfinite(morph.bake_error):
            raise FormatError(path, f"the bake error of the morph {name!r} is not a finite number")
    uv = rig.neutral.uv
    if uv is not None and not (np.abs(uv.coordinates) < _LARGEST).all():
        raise FormatError(path, "a texture coordinate is not finite or too large for glTF")
