"""Writes a layer of bends: it sublayers a file, overrides its blend shapes, and may add some.

The original that it goes over is a file with its meshes, its blend shapes, and their places. What a
bend adds to a blend shape that is there: in-betweens on its points, and its exact path. The shape
itself, V₀ + Y on the points that it names, stays as it is: at weight 1 all programs show what they
showed before. An in-between at w is stored as UsdSkel adds it to the points at rest,

    Y(w) = w Y + Σ_k b_k(w) D_k

with the bends D_k in the space of the mesh. A point that bends move but the shape does not joins
its points with Y = 0; a point that the shape names twice gets the bends once.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import opened, replacing_path, same_file
from elastomorph.io.blend_shapes import different_names
from elastomorph.io.isolated import IsolatedReader
from elastomorph.io.joined_rig import Placing, RigPart
from elastomorph.io.npz.members import NpzMembers
from elastomorph.io.usd.exact import checksum, path_from_json, path_to_json, prim_names
from elastomorph.io.usd.library import (
    BENDS,
    LAYER,
    LAYER_VERSION,
    NAME,
    PATH,
    SLIDERS,
    naming_failure,
    pxr,
)
from elastomorph.io.usd.reader import (
    ADVICE,
    FoundMesh,
    FoundShape,
    found_meshes,
    members_of,
    parts_of,
    rig_of,
)
from elastomorph.io.usd.writer import (
    COARSEST,
    SUFFIXES,
    array_of_bends,
    as_float32,
    inbetween_name,
    rounded_bends,
)
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import polygon_normals
from elastomorph.rig import Rig
from elastomorph.rig.laws import Corrective

_READER = IsolatedReader("elastomorph.io.usd.layer_worker", "USD", ADVICE)


@dataclass(frozen=True, eq=False)
class Driven:
    """What drives a shape that a layer adds to a mesh."""

    law: Corrective
    drivers: tuple[str, ...]  # What UsdSkel calls the weights of its drivers
    speed: float  # How far a vertex moves per weight, at most and as a fraction of D


@dataclass(frozen=True, eq=False)
class OriginalAnimation:
    """The weights over time that meshes follow, as they are or as a layer extends them."""

    path: str  # Of its prim
    place: str  # The same, inside the variants that it depends on
    unlisted: tuple[tuple[str, str], ...]  # As of a shape
    tokens: tuple[str, ...]  # Names of J weights
    times: NDArray[np.float64]  # (T,) time codes, rising
    weights: NDArray[np.float64]  # (1 + T, J), the first where time does not count


@dataclass(frozen=True, eq=False)
class OriginalShape:
    """A blend shape of the file."""

    name: str  # Of its morph in the rig
    prim: str  # Path of its prim
    place: str  # The same, inside the variants that it depends on
    unlisted: tuple[tuple[str, str], ...]  # Prims and variant sets that a layer must name
    variants: tuple[str, ...]  # As ``set=choice``
    instance: str | None  # The instance that it lies in
    found: FoundShape
    normals: NDArray[np.float64] | None  # (N, 3) offsets of the normals, where it has any
    driven: Driven | None = None  # Where the file has no such shape, and a layer adds it

    @property
    def has_path(self) -> bool:
        """Whether it has in-betweens, or a bent path that elastomorph wrote."""
        path = path_from_json(self.found.path or "")
        return bool(len(self.found.weights)) or (path is not None and bool(path.curves))


@dataclass(frozen=True, eq=False)
class OriginalMesh:
    """A mesh of the file, and what it is of the rig."""

    path: str  # Of its prim
    mesh: Mesh  # As it is stored
    held: NDArray[np.float64] | None  # (N, 4, 3) what joints do to each point, if they differ
    part: RigPart  # Where these hold it at rest
    vertices: slice  # Of the rig
    shapes: tuple[OriginalShape, ...]
    spec: str  # Its path, inside the variants that it depends on
    unlisted: tuple[tuple[str, str], ...]  # As of a shape
    tokens: tuple[str, ...]  # What UsdSkel calls its shapes; none where none can be added
    children: tuple[str, ...]  # Names of the prims below it
    animation: str  # Path of the animation that it follows, if any
    sliders: Mapping[str, Any]  # What elastomorph stored of them

    @property
    def place(self) -> Placing:
        """From where its joints hold it to the rig."""
        return self.part.place

    def own(self, fields: NDArray[np.float64], points: NDArray[np.int64]) -> NDArray[np.float64]:
        """(K, N, 3) fields of the rig on these points, in the space of the mesh."""
        # a mesh that is scaled to a plane or a line has no inverse, but a nearest one
        found = fields
        if not self.place.is_identity:
            found = fields @ np.linalg.pinv(self.place.linear).T
        if self.held is not None:
            turns = np.linalg.pinv(self.held[points, :3])
            found = np.einsum("kni,nij->knj", found, turns)
        return np.array(found)


@dataclass(frozen=True, eq=False)
class OriginalFile:
    """The file that a layer of bends goes over."""

    path: Path
    digest: str  # SHA-256 of its content
    files: tuple[Path, ...]  # That it is composed of, itself the first
    header: str  # A layer, as text, of what a stage takes from its root layer alone
    meshes: tuple[OriginalMesh, ...]
    rig: Rig
    animations: tuple[OriginalAnimation, ...]
    tolerance: float | None  # Of the in-betweens of the layer that was read, if it says so


def read_original(path: str | Path) -> OriginalFile:
    """The original in a file, or of a layer of bends that lies over it.

    Errors are those of `elastomorph.io.usd.reader.read_usd`, and a FormatError for a layer whose
    original is gone, or that holds more than bends.
    """
    with members_of(path, (), _READER) as members:
        content = json.loads(members.array("layer", "u", (None,)).tobytes())
        with _noted(Path(content["original"])) as original:
            found = found_meshes(path, members)
            parts = parts_of(path, found, members.budget)
            rig = rig_of(path, found, parts, members.budget)
            return OriginalFile(
                original,
                content["digest"],
                tuple(Path(name) for name in content["files"]),
                content["header"],
                tuple(_meshes(path, members, found, parts, content["meshes"])),
                rig,
                tuple(_animations(members, content["animations"])),
                content["tolerance"],
            )


def _animations(members: NpzMembers, entries: list[dict[str, Any]]) -> Iterator[OriginalAnimation]:
    for i, own in enumerate(entries):
        times = members.array(f"animation_{i}_times", "f", (None,))
        weights = members.array(f"animation_{i}_weights", "f", (1 + len(times), len(own["tokens"])))
        if np.isfinite(weights).all() and np.isfinite(times).all():
            unlisted, tokens = _pairs(own["unlisted"]), tuple(own["tokens"])
            yield OriginalAnimation(own["path"], own["place"], unlisted, tokens, times, weights)


def _pairs(entries: list[list[str]]) -> tuple[tuple[str, str], ...]:
    return tuple((prim, name) for prim, name in entries)


def original_of(path: str | Path) -> tuple[Path, tuple[Path, ...]]:
    """The file that a layer of bends lies over, and all files that it is composed of."""
    with members_of(path, ("files",), _READER) as members:
        content = json.loads(members.array("layer", "u", (None,)).tobytes())
    return Path(content["original"]), tuple(Path(name) for name in content["files"])


@contextmanager
def _noted(path: Path) -> Iterator[Path]:
    """The path of a file that counts as read."""
    with opened(path):
        yield path


def _meshes(
    path: str | Path,
    members: NpzMembers,
    found: list[FoundMesh],
    parts: list[RigPart],
    entries: list[dict[str, Any]],
) -> Iterator[OriginalMesh]:
    start = 0
    for i, (one, part, entry) in enumerate(zip(found, parts, entries, strict=True)):
        count = len(part.mesh.vertices)
        shapes = []
        for k, (name, own) in enumerate(zip(part.morphs, entry["shapes"], strict=True)):
            shape = one.shape(k, count)
            normals = None
            if f"{i}_shape_{k}_normals" in members.names:
                normals = members.array(f"{i}_shape_{k}_normals", "f", (None, 3))
                if normals.shape != shape.offsets[0].shape or not np.isfinite(normals).all():
                    raise FormatError(
                        path,
                        f"the normalOffsets of {own['prim']} do not fit its offsets; the file is "
                        "damaged or was written wrongly",
                    )
                normals = normals.astype(np.float64)
            shapes.append(
                OriginalShape(
                    name,
                    own["prim"],
                    own["place"],
                    _pairs(own["unlisted"]),
                    tuple(own["variants"]),
                    own["instance"],
                    shape,
                    normals,
                )
            )
        vertices = slice(start, start + count)
        yield OriginalMesh(
            entry["path"],
            one.mesh,
            one.held,
            part,
            vertices,
            tuple(shapes),
            entry["place"],
            _pairs(entry["unlisted"]),
            tuple(entry["tokens"]),
            tuple(entry["children"]),
            entry["animation"],
            one.sliders,
        )
        start += count


@dataclass(frozen=True, eq=False)
class BentShape:
    """What a layer says of one blend shape, N points of it."""

    original: OriginalShape
    path: str  # The exact path, as JSON
    bends: NDArray[np.floating]  # (K, N, 3) as they are stored; K may be 0
    weights: NDArray[np.float32]  # (n,) of the in-betweens, rising
    offsets: NDArray[np.float32]  # (1 + n, N, 3) of the shape and its in-betweens
    normals: NDArray[np.float32] | None  # (1 + n, N, 3), where the shape has offsets of normals
    # (N,) int32, where points joined those that the shape names; otherwise those stay
    points: NDArray[np.int32] | None

    @property
    def bent(self) -> bool:
        """Whether the path of this shape is not straight."""
        return bool(len(self.bends))

    @property
    def bytes(self) -> int:
        """Of the arrays that a layer holds of it."""
        own = 1 if self.points is None and self.original.driven is None else 0
        arrays = [self.bends, self.offsets[own:], self.points]
        arrays += [] if self.normals is None else [self.normals[own:]]
        return sum(array.nbytes for array in arrays if array is not None)


def bent_shape(
    path: str | Path,
    mesh: OriginalMesh,
    shape: OriginalShape,
    morph: Morph,
    weights: NDArray[np.float64],
    extent: float,
) -> BentShape:
    """What becomes of a blend shape where its morph is bent and has in-betweens at these weights.

    Morph and ``extent`` D are those of the rig that the meshes of the file are together.
    """
    of_rig = morph.bends[:, mesh.vertices]
    peaks = np.array([curve.height for curve in morph.bend_curves])
    # a sum over no bends is 0 everywhere
    moves = peaks @ np.linalg.norm(of_rig, axis=2) > COARSEST * extent
    moved = np.flatnonzero(moves)
    if not moved.size:
        return straight_shape(path, shape, morph)
    there = shape.found.points
    joining = np.setdiff1d(moved, there).astype(np.int64)
    points = np.concatenate([there, joining])
    bends = mesh.own(of_rig[:, points], points)
    again = np.ones(len(points), dtype=bool)
    again[np.unique(points, return_index=True)[1]] = False
    bends[:, again] = 0.0
    target = np.concatenate([shape.found.offsets[0], np.zeros((len(joining), 3))])
    floats = weights.astype(np.float32)
    at = np.concatenate([[1.0], floats.astype(np.float64)])
    factors = np.stack([curve(at) for curve in morph.bend_curves], axis=1)
    exact = at[:, None, None] * target + np.tensordot(factors, bends, axes=1)
    exact[0] = target  # to the bit: -0.0 plus 0.0 is another number to a checksum
    offsets = as_float32(path, exact, "an offset")
    scale = max(mesh.place.scale, np.finfo(float).tiny)
    size = mesh.part.mesh.diameter * scale
    text = path_to_json(
        morph,
        checksum([points.astype(np.int32), offsets, floats]),
        bake_error=morph.bake_error * morph.neutral.diameter / size if size else 0.0,
    )
    stored = rounded_bends(path, bends, peaks, extent / scale)
    normals = None
    if shape.normals is not None:
        given = np.concatenate([shape.normals, np.zeros((len(joining), 3))])
        normals = as_float32(path, _normals(mesh.mesh, points, at, exact, given), "a normal")
    joined = points.astype(np.int32) if joining.size else None
    return BentShape(shape, text, stored, floats, offsets, normals, joined)


def added_shapes(
    path: str | Path,
    original: OriginalFile,
    name: str,
    law: Corrective,
    morph: Morph,
    weights: NDArray[np.float64],
    extent: float,
) -> Iterator[BentShape]:
    """A shape that the file does not have, and others drive, in each mesh that it moves.

    Morph and ``extent`` are as for `bent_shape`.
    """
    fields = np.concatenate([morph.delta[None], morph.bends])
    steps = np.linspace(0.0, 1.0, 65)
    speeds = [1.0, *(float(np.abs(curve.slope(steps)).max()) for curve in morph.bend_curves)]
    moves = np.array(speeds) @ np.linalg.norm(fields, axis=2)
    used: dict[tuple[str, tuple[str, ...]], str] = {}
    for mesh in original.meshes:
        if not mesh.tokens or moves[mesh.vertices].max() <= COARSEST * extent:
            continue
        # Weights that several meshes follow may be named by the shapes of another one.
        beside = [one for one in original.meshes if one.animation == mesh.animation]
        known = {s.name: s.found.token for one in (*beside, mesh) for s in one.shapes}
        drivers = tuple(known.get(driver, "") for driver in law.drivers)
        taken = {token for one in beside for token in one.tokens} | {*used.values(), *mesh.tokens}
        taken |= {t for own in original.animations for t in own.tokens}
        plain = prim_names([name])[0]
        token = used.setdefault((mesh.animation, drivers), different_names([plain], taken=taken)[0])
        prim = prim_names([name], mesh.children)[0]
        there = np.flatnonzero(morph.delta[mesh.vertices].any(axis=1))
        offsets = mesh.own(morph.delta[None, mesh.vertices][:, there], there)
        normals = None
        if any(shape.normals is not None for shape in mesh.shapes):
            moved = mesh.mesh.vertices.copy()
            moved[there] += offsets[0]
            turned = _vertex_normals(mesh.mesh, moved)
            normals = (turned - _vertex_normals(mesh.mesh, mesh.mesh.vertices))[there]
        nothing = np.zeros(0), np.zeros((0, 3))
        found = FoundShape(token, prim, name, None, there, offsets, *nothing)
        place = f"{mesh.spec}{'' if mesh.spec.endswith('}') else '/'}{prim}"
        driven = Driven(law, drivers, float(moves[mesh.vertices].max()) / (extent or 1.0))
        shape = OriginalShape(
            name, f"{mesh.path}/{prim}", place, mesh.unlisted, (), None, found, normals, driven
        )
        yield bent_shape(path, mesh, shape, morph, weights, extent)


def straight_shape(path: str | Path, shape: OriginalShape, morph: Morph) -> BentShape:
    """A shape that no bend moves: what is known of its morph is kept beside it all the same."""
    offsets = as_float32(path, shape.found.offsets[:1], "an offset")
    none = np.zeros(0, dtype=np.float32)
    belonging = checksum([shape.found.points.astype(np.int32), offsets, none])
    text = path_to_json(morph, belonging, curves=(), bake_error=0.0)
    normals = None
    if shape.driven is not None and shape.normals is not None:
        normals = as_float32(path, shape.normals[None], "a normal")
    return BentShape(shape, text, np.zeros((0, 0, 3)), none, offsets, normals, None)


def _normals(
    mesh: Mesh,
    points: NDArray[np.int64],
    at: NDArray[np.float64],
    offsets: NDArray[np.float64],
    given: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(1 + n, N, 3) offsets of normals: of the straight path, and what the bends turn beside."""
    found = at[:, None, None] * given
    for row, time, own in zip(found[1:], at[1:], offsets[1:], strict=True):
        pair = []
        for moved in (own, time * offsets[0]):
            vertices = mesh.vertices.copy()
            np.add.at(vertices, points, moved)
            pair.append(_vertex_normals(mesh, vertices)[points])
        row += pair[0] - pair[1]
    return found


def _vertex_normals(mesh: Mesh, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """(V, 3) unit normals, those of the polygons around a vertex by their areas."""
    normals = np.zeros_like(vertices)
    faces = mesh.faces
    np.add.at(normals, faces.indices, polygon_normals(vertices, faces)[faces.corner_faces])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(lengths > 0, lengths, 1.0)


def require_layer_path(path: str | Path) -> None:
    """Refuse a name that is none of a layer."""
    suffix = Path(path).suffix.lower()
    if suffix == ".usdz":
        raise FormatError(
            path,
            "a layer lies over a file beside it, which a package cannot name; write a .usda, or "
            "make a package of that with usdzip",
        )
    if suffix not in SUFFIXES:
        raise FormatError(path, f"expected a name that ends in {', '.join(SUFFIXES)}")


def write_layer(
    path: str | Path,
    original: OriginalFile,
    shapes: Iterable[BentShape],
    animations: Iterable[OriginalAnimation] = (),
    *,
    tolerance: float,
) -> int:
    """Write the layer over a file; its size in bytes.

    Args:
        path: The layer.
        original: What it goes over.
        shapes: What it says of blend shapes, those that it adds too.
        animations: Those of the file that it extends by weights of shapes that it adds.
        tolerance: Of in-betweens, as a fraction of D, which the layer states.

    Raises:
        FormatError: Another suffix, or a path of the original that USD cannot hold.
        FileError: The file is one that the original is composed of, or cannot be written.
    """
    require_layer_path(path)
    require_other_file(path, original.path, original.files)
    with replacing_path(path) as temporary, naming_failure(path):
        layer = pxr("Sdf").Layer.CreateAnonymous(".usda")
        layer.ImportFromString(original.header)
        asset = _asset(path, original.path)
        layer.subLayerPaths.append(asset)
        layer.documentation = f"A layer over {original.path.name}, by elastomorph."
        said = {"version": LAYER_VERSION, "original": asset, "sha256": original.digest}
        said["tolerance"] = float(tolerance)
        layer.customLayerData = {**layer.customLayerData, LAYER: said}
        with pxr("Sdf").ChangeBlock():
            for shape in shapes:
                _override(layer, shape)
            for mesh in original.meshes:
                own = [s for s in shapes if s.original.driven and _below(s.original.prim, mesh)]
                if own:
                    _bind(layer, mesh, own)
            for animation in animations:
                _extend(layer, animation)
        _list_variants(layer, (*(shape.original for shape in shapes), *animations))
        kind = "usda" if Path(path).suffix.lower() == ".usda" else "usdc"
        mode = temporary.stat().st_mode
        layer.Export(str(temporary), args={"format": kind})
        temporary.chmod(mode)
        return temporary.stat().st_size


def require_other_file(path: str | Path, original: Path, files: Iterable[Path]) -> None:
    """Refuse to write over a file that the original is composed of."""
    for own in files:
        if same_file(path, own):
            raise FileError(
                path,
                f"this file is a part of {original.name}, which bends lie over and never change; "
                "name another output",
            )


def _asset(path: str | Path, original: Path) -> str:
    """The original as the layer names it: from its own folder where there is a way."""
    try:
        way = os.path.relpath(original, Path(path).resolve().parent)
    except ValueError:  # another drive of Windows
        way = str(original)
    asset = Path(way).as_posix()
    if not asset.startswith(("../", "/")) and not Path(way).is_absolute():
        asset = f"./{asset}"
    if not asset.isprintable() or "@@@" in asset or asset.encode("utf-8", "replace") == b"":
        raise FormatError(
            path, f"USD cannot name its original, {original!r}, in a layer; rename that file first"
        )
    return asset


def _override(layer: Any, shape: BentShape) -> None:
    """What the layer says of one blend shape."""
    sdf, values = pxr("Sdf"), pxr("Vt")
    types, uniform = sdf.ValueTypeNames, sdf.VariabilityUniform
    spec = sdf.CreatePrimInLayer(layer, shape.original.place)

    def attribute(name: str, kind: Any, value: Any, *, custom: bool = False) -> Any:
        variability = sdf.VariabilityVarying if custom else uniform
        own = sdf.AttributeSpec(spec, name, kind, variability, custom)
        own.default = value
        return own

    def vectors(rows: np.ndarray[Any, Any]) -> Any:
        return values.Vec3fArray.FromNumpy(np.ascontiguousarray(rows))

    attribute(PATH, types.String, shape.path, custom=True)
    points, added = shape.points, shape.original.driven is not None
    if added:
        spec.specifier, spec.typeName = sdf.SpecifierDef, "BlendShape"
        attribute(NAME, types.String, shape.original.name, custom=True)
        points = shape.original.found.points.astype(np.int32) if points is None else points
    if not (shape.bent or added):
        return
    if shape.bent:
        attribute(BENDS, *array_of_bends(shape.bends), custom=True)
    for i, weight in enumerate(shape.weights.tolist(), start=1):
        name = f"inbetweens:{inbetween_name(weight)}"
        own = attribute(name, types.Point3fArray, vectors(shape.offsets[i]))
        own.SetInfo("weight", weight)
        if shape.normals is not None:
            rows = vectors(shape.normals[i])
            attribute(f"{name}:normalOffsets", types.Vector3fArray, rows)
    if points is not None:
        attribute("pointIndices", types.IntArray, values.IntArray.FromNumpy(points))
        attribute("offsets", types.Vector3fArray, vectors(shape.offsets[0]))
        if shape.normals is not None:
            attribute("normalOffsets", types.Vector3fArray, vectors(shape.normals[0]))


def _below(prim: str, mesh: OriginalMesh) -> bool:
    return prim.rpartition("/")[0] == mesh.path


def _bind(layer: Any, mesh: OriginalMesh, added: Sequence[BentShape]) -> None:
    """Add shapes to those of a mesh, and say what drives them."""
    sdf = pxr("Sdf")
    spec = sdf.CreatePrimInLayer(layer, mesh.spec)
    names = sdf.AttributeSpec(
        spec, "skel:blendShapes", sdf.ValueTypeNames.TokenArray, sdf.VariabilityUniform
    )
    tokens = [*mesh.tokens, *(shape.original.found.token for shape in added)]
    names.default = pxr("Vt").TokenArray(tokens)
    targets = sdf.RelationshipSpec(spec, "skel:blendShapeTargets", False)
    targets.targetPathList.appendedItems = [sdf.Path(shape.original.prim) for shape in added]
    known = mesh.sliders.get("correctives")
    laws = {s.original.name: s.original.driven.law.entry() for s in added if s.original.driven}
    said = {"version": 1, **mesh.sliders}
    said["correctives"] = {**(known if isinstance(known, dict) else {}), **laws}
    sliders = sdf.AttributeSpec(
        spec, SLIDERS, sdf.ValueTypeNames.String, sdf.VariabilityVarying, True
    )
    sliders.default = json.dumps(said)


def _extend(layer: Any, animation: OriginalAnimation) -> None:
    """Write all weights of an animation anew."""
    sdf, array = pxr("Sdf"), pxr("Vt").FloatArray
    spec = sdf.CreatePrimInLayer(layer, animation.place)
    types, kinds = sdf.ValueTypeNames, (sdf.VariabilityUniform, sdf.VariabilityVarying)
    names = sdf.AttributeSpec(spec, "blendShapes", types.TokenArray, kinds[0])
    names.default = pxr("Vt").TokenArray(animation.tokens)
    weights = sdf.AttributeSpec(spec, "blendShapeWeights", types.FloatArray, kinds[1])
    rest, *rows = map(array.FromNumpy, animation.weights.astype(np.float32))
    weights.default = rest
    for time, row in zip(animation.times.tolist(), rows, strict=True):
        layer.SetTimeSample(weights.path, time, row)


def _list_variants(layer: Any, named: Iterable[OriginalShape | OriginalAnimation]) -> None:
    """Name variant sets only where no layer below does: their order is that of their strength."""
    unlisted: dict[str, list[str]] = {}
    for own in named:
        for prim, name in own.unlisted:
            if name not in unlisted.setdefault(prim, []):
                unlisted[prim].append(name)

    def visit(place: Any) -> None:
        if place.IsPrimPath() or place.IsPrimVariantSelectionPath():
            spec = layer.GetPrimAtPath(place)
            if spec is None or not spec.HasInfo("variantSetNames"):
                return
            spec.variantSetNameList.ClearEdits()
            for name in unlisted.get(str(place.StripAllVariantSelections()), []):
                spec.variantSetNameList.prependedItems.append(name)

    layer.Traverse(pxr("Sdf").Path.absoluteRootPath, visit)
