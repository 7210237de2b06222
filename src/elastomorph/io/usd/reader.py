"""A rig from USD: our own files as they were, any other as straight pieces between in-betweens.

What the worker found in a file is all checked. UsdSkel plays V₀ + Π(t), straight from in-between to
in-between: with offsets Y_i at weights w_i,

    V(t) = V₀ + tΔ + Σ_i h_i(t) (Y_i - w_i Δ)        h_i(w_j) = δ_ij, linear between the weights

which is a path with one bend an in-between. Beyond 0 and 1 both go straight on.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, MissingExtraError, warn
from elastomorph.io.atomic import opened
from elastomorph.io.blend_shapes import different_names, hats
from elastomorph.io.choices import wanted_names
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.io.joined_rig import RigPart, joined_rig, placings, turned_corners
from elastomorph.io.npz.members import NpzMembers
from elastomorph.io.untrusted import MemoryBudget, naming_file
from elastomorph.io.usd.exact import checksum, path_from_json, prim_names
from elastomorph.io.usd.library import ROOT, STILL
from elastomorph.io.usd.writer import SUFFIXES
from elastomorph.model.mesh import FaceLabels, Finish, Material, Mesh, Source, Texture, UVMap
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons
from elastomorph.rig import Rig
from elastomorph.rig.laws import Corrective

# Right, up and front of a face, as rows: programs that call z up look along y.
_AXES = {"Y": np.eye(3), "Z": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])}
_OBJECTS_OF_MESH = 11  # so many arrays the worker wrote of it


@dataclass(frozen=True, eq=False)
class FoundShape:
    """One blend shape as it stands in the file."""

    token: str  # Its name to UsdSkel
    prim_name: str  # That of its prim
    name: str | None  # The name that elastomorph gave it, if any
    path: str | None  # JSON of its exact path, if any
    points: NDArray[np.int64]  # (N,) int64 points it moves
    offsets: NDArray[np.float64]  # (1 + n, N, 3) float64, of the shape and its in-betweens
    weights: NDArray[np.float64]  # (n,) of the in-betweens, in any order; NaN for none
    bends: NDArray[np.float64]  # (M, 3) float64 rows of exact bends, if any


def found_meshes(path: str | Path, members: NpzMembers) -> list[FoundMesh]:
    """The meshes of a file, in its order."""
    scene = json.loads(members.array("scene", "u", (None,)).tobytes())
    members.budget.add_size(scene["size_of_others"])
    members.budget.spend_objects(_OBJECTS_OF_MESH * len(scene["meshes"]))
    axes = _AXES.get(scene["up"], _AXES["Y"])
    looks = _appearance(scene["looks"], members)
    return [
        FoundMesh(path, members, f"{i}_", own, axes, looks) for i, own in enumerate(scene["meshes"])
    ]


def _appearance(stored: dict[str, Any], members: NpzMembers) -> dict[str, Material] | None:
    """The looks of materials by name; None where all are plain greys, which say nothing."""
    found: dict[str, Material] = {}
    for name, look in stored.items():
        texture: Texture | None = None
        if shown := look.pop("texture", None):
            number, problem = shown.pop("image"), "it is no file below the folder of the stage"
            content = b""
            if number is not None:
                problem = ""
                content = members.array(f"image_{number}", "u", (None,)).tobytes()
            lists: dict[str, Any] = {
                key: tuple(v) if isinstance(v, list) else v for key, v in shown.items()
            }
            texture = Texture(image=content, problem=problem, **lists)
        # Which side polygons show is said of meshes, and few stages say it.
        own = {**look, "colour": tuple(look["colour"]), "finish": Finish(*look["finish"])}
        found[name] = Material(texture=texture, double_sided=True, **own)
    return None if all(material.plain for material in found.values()) else found


class FoundMesh:
    """A mesh and its blend shapes."""

    def __init__(
        self,
        path: str | Path,
        members: NpzMembers,
        prefix: str,
        entry: dict[str, Any],
        axes: NDArray[np.float64],
        looks: dict[str, Material] | None,
    ) -> None:
        self._path = path
        self._looks = looks
        self._members = members
        self._prefix = prefix
        self._entry = entry
        self.name: str = entry["name"]
        self.axes = axes  # (3, 3) right, up and front of the file, as rows
        self.settings: str | None = entry["settings"]  # as JSON, where elastomorph stored them
        self.shape_count = len(entry["shapes"])
        self._shapes: dict[int, FoundShape] = {}

    @cached_property
    def matrix(self) -> NDArray[np.float64]:
        """(4, 3) from points to the world: what x, y and z become, and the origin."""
        return self._array("matrix", (4, 3))

    @cached_property
    def held(self) -> NDArray[np.float64] | None:
        """(N, 4, 3) what joints do to each point before that, None where it is nothing."""
        if not self._has("held"):
            return None
        return self._array("held", (None, 4, 3))

    @cached_property
    def sliders(self) -> dict[str, Any]:
        """What elastomorph stored of the sliders; empty where it did not."""
        try:
            found = json.loads(self._entry["sliders"] or "")
        except (ValueError, RecursionError):
            return {}
        return found if isinstance(found, dict) and found.get("version") == 1 else {}

    @cached_property
    def mesh(self) -> Mesh:
        """The neutral, as it is stored."""
        points = self._array("points", (None, 3))
        counts = self._indices("counts", 0, None)
        indices = self._indices("indices", 0, len(points) - 1)
        if int(counts.sum()) != len(indices):
            raise FormatError(
                self._path,
                f"its polygons have {int(counts.sum()):,} corners (faceVertexCounts), but "
                f"faceVertexIndices has {len(indices):,}; the file is damaged",
            )
        library = self.sliders.get("materialLibrary")
        with naming_file(self._path):
            offsets = np.concatenate([[0], np.cumsum(counts)])
            left = self._entry["left_handed"]
            order = turned_corners(offsets) if left else np.arange(len(indices))
            faces = Polygons(indices[order], offsets)
            return Mesh(
                self._exact_points(points),
                faces,
                uv=self._texture(indices, order, len(points)),
                materials=self._labels(len(faces), material=True),
                groups=self._labels(len(faces), material=False),
                material_library=library if isinstance(library, str) else None,
                # a converter of glTF splits vertices where texture coordinates end
                source=Source(str(self._path), split=True),
                appearance=self._looks,
                copyright=self._entry["copyright"] or "",
            )

    def shape(self, i: int, vertices: int) -> FoundShape:
        """One blend shape."""
        if i not in self._shapes:
            self._shapes[i] = self._shape(i, vertices)
        return self._shapes[i]

    def _shape(self, i: int, vertices: int) -> FoundShape:
        found, prefix = self._entry["shapes"][i], f"shape_{i}"
        main = self._array(f"{prefix}_offsets", (None, 3))
        points = np.arange(vertices)
        if self._has(f"{prefix}_points"):
            named = self._indices(f"{prefix}_points", 0, vertices - 1)
            points = named if named.size else points
        if not len(main) and len(points) == vertices:
            main = np.zeros((vertices, 3))  # an empty shape moves nothing
        between = range(len(found["inbetweens"]))
        rows = [main, *(self._array(f"{prefix}_inbetween_{k}", (None, 3)) for k in between)]
        for row in rows:
            if len(row) != len(points):
                raise FormatError(
                    self._path,
                    f"the blend shape '{found['token']}' moves {len(points):,} points, but has "
                    f"{len(row):,} offsets; the file is damaged or was written wrongly",
                )
        weights = found["inbetweens"]
        return FoundShape(
            found["token"],
            found["prim"],
            found["name"],
            found["path"],
            points,
            np.stack(rows),
            np.array([np.nan if w is None else w for w in weights], dtype=np.float64),
            self._array(f"{prefix}_bends", (None, 3)),
        )

    def _has(self, name: str) -> bool:
        return f"{self._prefix}{name}" in self._members.names

    def _array(self, name: str, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
        """An array of finite numbers, empty where there is none."""
        if not self._has(name):
            return np.zeros([length or 0 for length in shape])
        found = self._members.array(f"{self._prefix}{name}", "f", shape)
        if not np.isfinite(found).all():
            raise FormatError(self._path, f"{_said(name)} are not all finite numbers")
        return found.astype(np.float64)

    def _indices(self, name: str, lowest: int, highest: int | None) -> NDArray[np.int64]:
        """A list of whole numbers, empty where there is none."""
        if not self._has(name):
            return np.zeros(0, dtype=np.int64)
        found = self._members.array(f"{self._prefix}{name}", "iu", (None,)).astype(np.int64)
        least, most = (int(found.min()), int(found.max())) if found.size else (lowest, lowest - 1)
        if least < lowest or (highest is not None and most > highest):
            raise FormatError(
                self._path,
                f"{_said(name)} go from {least:,} to {most:,}, expected {lowest:,} to "
                f"{'any' if highest is None else f'{highest:,}'}",
            )
        return found

    def _exact_points(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        if not self._has("exact_points"):
            return points
        exact = self._array("exact_points", (None, 3))
        same = exact.shape == points.shape and self.sliders.get("checksum") == checksum(
            [points.astype(np.float32)]
        )
        return exact if same else points

    def _texture(
        self, indices: NDArray[np.int64], order: NDArray[np.int64], vertices: int
    ) -> UVMap | None:
        found = self._entry["texture"]
        if found is None:
            return None
        uv = self._members.array(f"{self._prefix}uv", "f", (None, None))
        coordinates = uv.astype(np.float64)
        if coordinates.shape[1] not in (2, 3) or not np.isfinite(coordinates).all():
            return None
        corner = found["kind"] == "faceVarying"
        count, of = (len(indices), "corners") if corner else (vertices, "points")
        own = np.arange(count)
        if self._has("uv_indices"):
            own = self._indices("uv_indices", -1, len(coordinates) - 1)
        if len(own) != count:
            raise FormatError(
                self._path, f"there are {len(own):,} texture coordinates for {count:,} {of}"
            )
        if own.size and int(own.max()) >= len(coordinates):
            raise FormatError(
                self._path, f"there are only {len(coordinates):,} texture coordinates"
            )
        corners = (own if corner else own[indices])[order]
        bare = found["unauthored"]
        if bare >= 0:
            corners = np.where(corners == bare, -1, corners)
            if bare == len(coordinates) - 1:
                coordinates = coordinates[:-1]
        return UVMap(coordinates, corners.astype(np.int32))

    def _labels(self, faces: int, *, material: bool) -> FaceLabels | None:
        subsets = [
            (i, subset["name"])
            for i, subset in enumerate(self._entry["subsets"])
            if subset["material"] == material
        ]
        whole = self._entry["material"] if material else None
        if not subsets and whole is None:
            return None
        names = list(dict.fromkeys(name for _, name in subsets))
        of_face = np.full(faces, -1, dtype=np.int32)
        if whole is not None:
            names += [whole] if whole not in names else []
            of_face[:] = names.index(whole)
        for i, name in subsets:
            of_face[self._indices(f"subset_{i}", 0, faces - 1)] = names.index(name)
        return FaceLabels(tuple(names), of_face)


def _said(name: str) -> str:
    return f"the values of '{name.replace('_', ' ')}'"


_SUFFIXES = (*SUFFIXES, ".usdz")
ADVICE = "write it again from the program it was made with, or as one file (usdcat --flatten)"
_READER = IsolatedReader("elastomorph.io.usd.worker", "USD", ADVICE)
_CLOSE = 1e-6  # UsdSkel passes over in-betweens nearer than this to 0 and 1


def read_usd(
    path: str | Path,
    *,
    mesh: str | Sequence[str] | None = None,
    still: bool = False,
    root: str | Path | None = None,
) -> Rig:
    """The rig in a USD file.

    A file of `write_usd`, or a layer of bends, comes back with its curved paths. Of any other, each
    in-between becomes a bend whose curve is a hat, so that the path is exactly the one UsdSkel
    plays. All meshes that are rendered become one, in the order of the stage; blend shapes of the
    same name in several of them are one morph, and a mesh without any is part of the neutral.
    Positions are those of the mesh with most blend shapes, turned upright, the others where they
    stand beside it, skinned ones where their joints hold them at rest, point by point; polygons of
    a left-handed mesh are turned around. USD reads the file in a process of its own, as it ends the
    whole program on some damaged files.

    Args:
        path: A .usd, .usda, .usdc or .usdz file. References, payloads and sublayers are followed
            within ``root``, or its package, only; the file under a layer of `elastomorph.bend`
            wherever it is.
        mesh: Name or path of the mesh to read, or of several; with or without blend shapes.
        still: Read meshes without any blend shapes too, as a rig without morphs.
        root: The folder in which all files must lie; the common parent of those named relative to
            each other by default, unless that is a home, a folder on top of the disk or the like.

    Raises:
        MissingExtraError: usd-core is not installed.
        FileError: The file is missing or cannot be read.
        FormatError: It is not USD or damaged, no mesh has blend shapes or there is none of a name,
            or it is composed of files outside the root.
        ParameterError: An empty list of names.
    """
    options = [STILL] * still + ([] if root is None else [f"{ROOT}{Path(root).absolute()}"])
    with members_of(path, [*options, *wanted_names(mesh)]) as members:
        found = found_meshes(path, members)
        return rig_of(path, found, parts_of(path, found, members.budget), members.budget)


def read_usd_settings(path: str | Path, *, mesh: str | Sequence[str] | None = None) -> str | None:
    """The settings that `write_usd` kept in a file, as JSON; None where there are none.

    Arguments and errors are those of `read_usd`.
    """
    with members_of(path, [STILL, *wanted_names(mesh)]) as members:
        found = [own.settings for own in found_meshes(path, members)]
        return next((text for text in found if text is not None), None)


@contextmanager
def members_of(
    path: str | Path, wanted: Sequence[str], reader: IsolatedReader = _READER
) -> Iterator[NpzMembers]:
    """The content of a file, as a worker found it."""
    if Path(path).suffix.lower() not in _SUFFIXES:
        raise FormatError(path, f"expected a name that ends in {', '.join(_SUFFIXES)}")
    with opened(path):  # a file that is not there is no matter of what is installed
        pass
    if find_spec("pxr") is None:
        raise MissingExtraError("usd-core", "usd")
    with extracted(reader, path, *wanted) as members:
        yield members


def rig_of(
    path: str | Path, found: list[FoundMesh], parts: list[RigPart], budget: MemoryBudget
) -> Rig:
    """The rig that the meshes of a file are together."""
    with naming_file(path):
        neutral, morphs = joined_rig(parts, str(path))
    groups = {n: own for mesh in found for n, own in _lists(mesh.sliders.get("groups")).items()}
    with naming_file(path):
        correctives = {
            n: own for mesh in found for n, own in _laws(mesh.sliders.get("correctives")).items()
        }
    entries = sum(len(own.drivers) for own in correctives.values()) + sum(map(len, groups.values()))
    budget.spend_lookups(entries, len(morphs))
    known = set(morphs)
    named = [*({n, *own.drivers} for n, own in correctives.items()), *map(set, groups.values())]
    if any(own - known for own in named):
        warn(f"{path}: blend shapes that correctives or groups name are gone; both are left out")
        correctives, groups = {}, {}
    with naming_file(path):
        return Rig(neutral, morphs, correctives=correctives, groups=groups)


def parts_of(path: str | Path, found: list[FoundMesh], budget: MemoryBudget) -> list[RigPart]:
    """The meshes with their morphs, in the order of their blend shapes, each where it goes."""
    meshes = [one.mesh for one in found]
    shapes = [
        [one.shape(i, len(mesh.vertices)) for i in range(one.shape_count)]
        for one, mesh in zip(found, meshes, strict=True)
    ]
    vertices = sum(len(mesh.vertices) for mesh in meshes)
    # displacement fields that the morph of a shape will have, at most
    fields = sum(
        2 + max(len(shape.bends) // max(len(shape.points), 1), len(shape.weights))
        for own in shapes
        for shape in own
    )
    copies = 1 + (len(meshes) > 1) + any(one.held is not None for one in found)
    budget.spend_fields(vertices, fields, copies=copies)
    main = max(range(len(meshes)), key=lambda number: len(shapes[number]))
    with naming_file(path):
        places = placings(found[main].axes, found, main)
    parts = []
    for one, mesh, own, place in zip(found, meshes, shapes, places, strict=True):
        by_name = zip(_names(own), own, strict=True)
        morphs = {name: _morph(path, mesh, name, shape) for name, shape in by_name}
        part = RigPart(one.name, mesh, morphs, place)
        with naming_file(path):
            parts.append(part if one.held is None else _at_rest(part, one.held))
    return parts


def _at_rest(part: RigPart, held: NDArray[np.float64]) -> RigPart:
    """A mesh whose points have different joints, (N, 4, 3) each, where these hold them at rest."""

    def turned(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.einsum("...ni,nij->...nj", vectors, held[:, :3]))

    neutral = part.mesh.with_vertices(turned(part.mesh.vertices) + held[:, 3])
    morphs = {
        name: replace(
            morph,
            neutral=neutral,
            target=neutral.with_vertices(neutral.vertices + turned(morph.delta)),
            bends=turned(morph.bends),
        )
        for name, morph in part.morphs.items()
    }
    return replace(part, mesh=neutral, morphs=morphs)


def _names(shapes: Iterable[FoundShape]) -> list[str]:
    """Our own names where the prims still have the names made from them; all different.

    UsdSkel wants one weight a name: exporters number the names of further meshes (``jawOpen2``) and
    leave those of the prims, which then tell what moves together.
    """
    names = []
    for shape in shapes:
        name, plain = shape.name, prim_names([shape.name or ""])[0]
        rest = shape.token.removeprefix(plain)
        made_from_it = shape.token.startswith(plain) and rest[:1] in ("", "_")
        number = shape.token[len(shape.prim_name) :]
        numbered = shape.token.startswith(shape.prim_name) and number.isdecimal()
        token = shape.prim_name if numbered else shape.token
        names.append(token if name is None or not made_from_it else name)
    return different_names(names, first=1)


def _laws(content: Any) -> dict[str, Corrective]:
    """Correctives: lists of drivers, or what `Corrective.entry` gives."""
    products = _lists(content)
    entries = content.items() if isinstance(content, Mapping) else ()
    laws = {str(name): own for name, own in entries if isinstance(own, Mapping)}
    return {name: Corrective.of(own) for name, own in (products | laws).items()}


def _lists(content: Any) -> dict[str, list[str]]:
    if not isinstance(content, Mapping):
        return {}
    return {
        str(name): [str(n) for n in own] for name, own in content.items() if isinstance(own, list)
    }


def _morph(path: str | Path, neutral: Mesh, name: str, shape: FoundShape) -> Morph:
    """The morph of a blend shape."""
    delta = _spread(neutral, shape.points, shape.offsets[0])
    with naming_file(path):
        target = neutral.with_vertices(neutral.vertices + delta)
        if shape.path is not None:
            exact = _exact(neutral, target, shape)
            if exact is not None:
                return exact
            warn(
                f"{path}: the blend shape '{name}' was changed since elastomorph wrote it; its "
                "in-betweens are read instead of its curved path"
            )
        kept = _inner(path, name, shape)
        weights = shape.weights[kept]
        bends = np.zeros((len(kept), *delta.shape))
        for bend, weight, row in zip(bends, weights, kept, strict=True):
            bend[:] = _spread(neutral, shape.points, shape.offsets[1 + row]) - weight * delta
        method = "inbetweens" if kept else "linear"
        return Morph(neutral, target, bends, hats(weights), method=method, bare=not kept)


def _exact(neutral: Mesh, target: Mesh, shape: FoundShape) -> Morph | None:
    """The morph that elastomorph stored, unless the shapes are no longer those it belongs to."""
    stored = path_from_json(shape.path or "")
    order = np.argsort(shape.weights)
    shapes = shape.offsets[np.concatenate([[0], 1 + order])]
    floats = (shapes.astype(np.float32), shape.weights[order].astype(np.float32))
    if stored is None or stored.checksum != checksum([shape.points.astype(np.int32), *floats]):
        return None
    if len(shape.bends) != len(stored.curves) * len(shape.points):
        return None
    bends = np.zeros((len(stored.curves), *neutral.vertices.shape))
    bends[:, shape.points] = shape.bends.reshape(len(bends), len(shape.points), 3)
    return Morph(neutral, target, bends, stored.curves, **stored.more)


def _inner(path: str | Path, name: str, shape: FoundShape) -> list[int]:
    """The in-betweens at weights between 0 and 1, in the order of these."""
    kept: list[int] = []
    for row in np.argsort(shape.weights, kind="stable").tolist():
        weight = shape.weights[row]
        if not _CLOSE < weight < 1 - _CLOSE:
            warn(
                f"{path}: the blend shape '{name}' has an in-between at the weight {weight:g}, "
                "which is not between 0 and 1; it is left out"
            )
        elif kept and weight - shape.weights[kept[-1]] <= _CLOSE:
            if not np.array_equal(shape.offsets[1 + row], shape.offsets[1 + kept[-1]]):
                raise FormatError(
                    path,
                    f"the blend shape '{name}' has two different in-betweens at the weight "
                    f"{weight:g}; remove one of them",
                )
        else:
            kept.append(row)
    return kept


def _spread(
    neutral: Mesh, points: NDArray[np.int64], offsets: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(V, 3) from offsets of some points; a point named twice moves by both, as in UsdSkel."""
    field = np.zeros(neutral.vertices.shape)
    np.add.at(field, points, offsets)
    return field
