"""The meshes of a document with the bends they get: targets, names, default weights, curves.

New targets follow all others, so that whatever names a target by its number, such as an expression
of VRM, means the same as before. Displacements are stored as the numbers that the targets of the
file have.

Paths are made in the scene; from there back to the space of a mesh, with the linear part L of a
vertex's place, a displacement d of the scene is L⁻¹d in the mesh. A normal n of the mesh is shown
as L⁻ᵀn, and so what is added to it in the scene is Lᵀd there.

Bends add to the normals of vertices where the targets of the file turn them too. A player lights a
face by n₀ + t·δ + Σ_k b_k(t)·d_k, with the normals n₀ of the mesh and δ of the target, both of
which stay as their author made them. The d_k are fitted to how much more than δ the surface turns
on its path. Vertices at the same place with the same normal are one here, so that a texture seam
does not show and a hard edge does.

What is added to a document: accessors, the views they are in, and the bytes of these.

Everything goes behind what there is, so that every number in the document still holds; only where
keys of a clip are of no more use, `fill_gaps` puts some of it in their place.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.bending.face import Face, FaceMesh
from elastomorph.bending.keys import Columns, Driven
from elastomorph.bending.plan import BentMorph
from elastomorph.errors import warn
from elastomorph.io.blend_shapes import curve_to_json
from elastomorph.io.choices import choice_to_json
from elastomorph.io.gltf import meshopt
from elastomorph.io.gltf.accessors import COMPONENT_TYPES, TYPES, padded, read_floats
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.morph_targets import NormalField, normal_deltas
from elastomorph.io.gltf.primitives import Attributes
from elastomorph.io.gltf.rig_extras import corrective_entries, least_version
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons
from elastomorph.rig.laws import Corrective

_ARRAY_BUFFER = 34962


@dataclass(frozen=True)
class Packing:
    """How the views of a file that meshoptimizer packed are packed.

    Attributes:
        extension: The name of the extension.
        fallback: Number of the buffer, without bytes, that views have their decoded place in.
        length: Its length.
        asked: Whether it is only what is added that is packed, as the user asks.
    """

    extension: str
    fallback: int
    length: int
    asked: bool = False

    @classmethod
    def of(cls, file: GltfFile, accessors: Iterable[Any]) -> Packing | None:
        """That of the first of some accessors that is packed, None where none is."""
        for number in accessors:
            view = file.item("accessors", number, "a morph target").get("bufferView")
            if view is None:
                continue
            entry = file.item("bufferViews", view, "a morph target")
            extensions = file.object_in(entry, "extensions", "a buffer view")
            for name in meshopt.EXTENSIONS:
                buffer = file.item("buffers", entry.get("buffer"), "a buffer view")
                own = file.object_in(buffer, "extensions", "a buffer").get(name)
                bare = isinstance(own, dict) and own.get("fallback") is True and "uri" not in buffer
                if name in extensions and bare:
                    length = file.whole_in(buffer, "byteLength", "a buffer")
                    return cls(name, entry["buffer"], length)
        return None


class Additions:
    """Collects what bends add to a document.

    Args:
        accessors: How many accessors the document has.
        views: How many buffer views.
        packing: How its targets are packed, if they are.
    """

    def __init__(self, accessors: int, views: int, packing: Packing | None = None) -> None:
        self._first_accessor, self._first_view = accessors, views
        self._packing = packing
        self.fallback_length = 0 if packing is None else packing.length
        self.accessors: list[dict[str, Any]] = []
        self._views: list[dict[str, Any]] = []
        self._contents: list[bytearray] = []
        self._shared: dict[tuple[Any, ...], int] = {}
        self._known: dict[bytes, int] = {}

    @property
    def packs(self) -> bool:
        """Whether what is added is packed because the user asks, so that it may be rounded."""
        return self._packing is not None and self._packing.asked

    @property
    def size(self) -> int:
        """Bytes of all that was added so far."""
        return sum(map(len, self._contents))

    def displacements(
        self, rows: NDArray[Any], *, normalized: bool = False, bounds: bool = False
    ) -> int:
        """The number of an accessor of (N, 3) displacements, sparse where that is smaller.

        Sparse fractions are stored in single precision: glTF-Transform, through which many files
        go, empties sparse arrays of normalized whole numbers.
        """
        moved = np.flatnonzero(rows.any(axis=1))
        moved = moved.astype(np.uint16 if len(rows) <= 0x10000 else np.uint32)
        dense = (rows.itemsize * 3 + -(rows.itemsize * 3) % 4) * len(rows)
        fractions = normalized and len(moved) > 0
        sparse = (moved.itemsize + (4 if fractions else rows.itemsize) * 3) * len(moved)
        use = f"{rows.dtype.str} {rows.shape} {normalized} {bounds}".encode()
        key = hashlib.blake2b(use + rows.tobytes(), digest_size=16).digest()
        if key not in self._known:
            # A packed file gets whole views, as its own are: zeros take next to nothing.
            like_others = self._packing is not None and not self.packs
            whole = sparse >= dense or (like_others and len(moved) > 0)
            if fractions and not whole:
                rows = (rows / np.iinfo(rows.dtype).max).astype(np.float32)
                normalized = False
            accessor = self._dense(rows) if whole else self._sparse(rows, moved)
            accessor |= {"normalized": True} if normalized else {}
            if bounds:
                low, high = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
                accessor |= {"min": low, "max": high}
            self._known[key] = self._add(accessor)
        return self._known[key]

    def keys(self, values: NDArray[Any], beside: Any, *, bounds: bool = False) -> int:
        """The number of an accessor of (N,) numbers: key times, which have bounds, or weights.

        The largest of whole numbers stands for 1.

        They share a view with others in whose place keys of the same view were.
        """
        place = self._append(("keys", values.itemsize, bounds, beside), values.tobytes())
        accessor = place | self._kind(values.reshape(-1, 1))
        accessor |= {"normalized": True} if values.dtype.kind != "f" else {}
        if bounds:
            accessor |= {"min": [float(values.min())], "max": [float(values.max())]}
        return self._add(accessor)

    def _dense(self, rows: NDArray[Any]) -> dict[str, Any]:
        content = padded(rows)
        stride = content.shape[1]
        view = {"byteStride": stride, "target": _ARRAY_BUFFER}
        return self._append(("dense", stride), content.tobytes(), view) | self._kind(rows)

    def _sparse(self, rows: NDArray[Any], moved: NDArray[Any]) -> dict[str, Any]:
        if not len(moved):
            return self._kind(rows)
        places = self._append(("places", moved.itemsize), moved.tobytes())
        values = self._append(("values", rows.itemsize), rows[moved].tobytes())
        component = {"componentType": COMPONENT_TYPES[moved.dtype.str]}
        sparse = {"count": len(moved), "indices": places | component, "values": values}
        return self._kind(rows) | {"sparse": sparse}

    def _kind(self, rows: NDArray[Any]) -> dict[str, Any]:
        kind = {"componentType": COMPONENT_TYPES[rows.dtype.str], "count": len(rows)}
        return kind | {"type": TYPES[rows.shape[1]]}

    def _append(
        self, use: tuple[Any, ...], content: bytes, view: dict[str, Any] | None = None
    ) -> dict[str, Any]:
        """Where bytes are, in a view that others of the same use share."""
        if use not in self._shared:
            self._shared[use] = len(self._views)
            self._views.append(view or {})
            self._contents.append(bytearray())
        number = self._shared[use]
        held = self._contents[number]
        held += bytes(-len(held) % 4)
        offset = len(held)
        held += content
        return {"bufferView": self._first_view + number, "byteOffset": offset}

    def _add(self, accessor: dict[str, Any]) -> int:
        self.accessors.append(accessor)
        return self._first_accessor + len(self.accessors) - 1

    def placed(self, buffer: int, start: int) -> tuple[list[dict[str, Any]], bytes]:
        """The buffer views, and their bytes, which follow ``start`` others in a buffer."""
        views, blob = [], bytearray(-start % 4)
        for use, own, content in zip(self._shared, self._views, self._contents, strict=True):
            stored = bytes(content)
            offset = start + len(blob)
            place: dict[str, Any] = {"buffer": buffer, "byteOffset": offset}
            place["byteLength"] = len(stored)
            # Rows are packed as they are read: whole elements, of which meshoptimizer takes fours.
            stride = own.get("byteStride", use[1] * (3 if use[0] == "values" else 1))
            mode = "INDICES" if use[0] == "places" else "ATTRIBUTES"
            if self._packing is not None and (mode == "INDICES" or stride % 4 == 0):
                stored += bytes(-len(stored) % stride)
                place = self._unpacked(len(stored))
                stored, packing = meshopt.packed_view(stored, stride, mode)
                packed = {"buffer": buffer, "byteOffset": offset, "byteLength": len(stored)}
                place["extensions"] = {self._packing.extension: packed | packing}
            views.append(place | own)
            blob += stored + bytes(-len(stored) % 4)
        return views, bytes(blob)

    def _unpacked(self, length: int) -> dict[str, Any]:
        """The place of decoded bytes in the buffer that has none."""
        packing = self._packing
        assert packing is not None
        offset = self.fallback_length + -self.fallback_length % 4
        self.fallback_length = offset + length
        return {"buffer": packing.fallback, "byteOffset": offset, "byteLength": length}


def data_uri(content: bytes) -> str:
    """Bytes as a text that stands for a file."""
    return "data:application/octet-stream;base64," + base64.b64encode(content).decode()


Field = NDArray[np.float64]

_LEAST_VOLUME = 1e-12  # of a unit cube: what is flatter than this came out of rounding


@dataclass(frozen=True, eq=False)
class MeshSpace:
    """The vertices of a primitive, as the file stores them.

    Attributes:
        file: The file.
        block: The vertices where the scene shows them.
        attributes: Numbers of the accessors of the primitive.
        of: What messages call the mesh.
    """

    file: GltfFile
    block: Attributes
    attributes: dict[str, Any]
    of: str

    @property
    def rows(self) -> slice:
        """Which of the vertices of the mesh these are."""
        return slice(self.block.start, self.block.start + len(self.block.vertices))

    def require_place(self) -> None:
        """Refuse a mesh that moves, but is flattened to a plane, a line or a point."""
        if self.block.displacements and self.block.placement.linear.ndim == 2:
            self._require_solid(self.block.placement.linear)

    def displacements(self, field: Field) -> Field:
        """(N, 3) displacements in the mesh."""
        linear = self.block.placement.linear
        if linear.ndim == 3:
            moved = np.flatnonzero(field.any(axis=1))
            self._require_solid(linear[moved])
            found = np.zeros_like(field)
            found[moved] = np.linalg.solve(linear[moved], field[moved, :, None])[..., 0]
            return found
        if self._is_unit:
            return field
        self._require_solid(linear)
        return np.asarray(np.linalg.solve(linear, field.T).T)

    def normals(self, field: Field) -> Field:
        """(N, 3) of the mesh, from what is added to unit normals in the scene."""
        if self._is_unit:
            return field
        linear = self.block.placement.linear
        pattern = "ji,nj->ni" if linear.ndim == 2 else "nji,nj->ni"
        turned = np.einsum(pattern, linear, field)
        # Lᵀn of the unit normal n in the scene has this length, where the mesh has a unit normal.
        length = np.linalg.norm(np.einsum(pattern, linear, self.scene_normals), axis=1)
        return np.asarray(turned / np.where(length > 0, length, 1.0)[:, None])

    def tangents(self, normals: Field) -> Field:
        """(N, 3) what is added to tangents where this is added to the normals of the mesh.

        To first order in the turn: t stays perpendicular to n for -(t·d) n, and keeps its
        direction within the surface.
        """
        tangents, at_rest = self._attribute("TANGENT", 4), self._attribute("NORMAL", 3)
        if tangents is None or at_rest is None:
            return np.zeros_like(normals)
        along = np.einsum("ni,ni->n", tangents[:, :3], normals)
        return np.asarray(-along[:, None] * at_rest)

    @cached_property
    def scene_normals(self) -> Field:
        """(N, 3) unit normals where the scene shows them; zero where the file has none."""
        found = self._attribute("NORMAL", 3)
        if found is None:
            return np.zeros_like(self.block.vertices)
        if not self._is_unit:
            linear = self.block.placement.linear
            # The cofactors are |L| L⁻ᵀ, and never fail.
            rows = np.swapaxes(linear, -1, -2)
            cofactors = np.stack(
                [np.cross(rows[..., (i + 1) % 3, :], rows[..., (i + 2) % 3, :]) for i in range(3)],
                axis=-1,
            )
            pattern = "ij,nj->ni" if linear.ndim == 2 else "nij,nj->ni"
            found = np.einsum(pattern, cofactors, found)
        length = np.linalg.norm(found, axis=1, keepdims=True)
        return np.asarray(found / np.where(length > 0, length, 1.0))

    @property
    def _is_unit(self) -> bool:
        return np.array_equal(self.block.placement.linear, np.eye(3))

    def _attribute(self, name: str, width: int) -> Field | None:
        if name not in self.attributes:
            return None
        what = f"the {name.lower()}s of {self.of}"
        count = len(self.block.vertices)
        return read_floats(self.file, self.attributes[name], width, what, count=count)

    def _require_solid(self, linear: Field) -> None:
        """Refuse vertices whose place says nothing of where they were."""
        volume = np.abs(np.linalg.det(linear))
        largest = np.abs(linear).max(axis=(-2, -1), initial=0.0)
        if (volume <= _LEAST_VOLUME * largest**3).any():
            self.file.refuse(
                f"{self.of} is flattened where the scene shows it at rest (a node or a joint has "
                "a scale of 0), so its bends cannot be taken back to it; give it a scale"
            )


_WHOLE = {5120: "|i1", 5122: "<i2"}
_FINER = {"|i1": "<i2"}
_ROUNDED = 1e-4  # of the largest number of a bend that is rounded


@dataclass(frozen=True)
class Encoding:
    """The type of the components of an accessor, and whether single precision is rounded."""

    dtype: str
    normalized: bool
    rounded: bool = False

    @classmethod
    def of(cls, file: GltfFile, accessor: Any, *, rounded: bool = False) -> Encoding:
        """That of an accessor of the file; single precision where there is none."""
        entry = {} if accessor is None else file.item("accessors", accessor, "a morph target")
        code = entry.get("componentType")
        dtype = _WHOLE.get(code, "<f4") if type(code) is int else "<f4"
        return cls(dtype, dtype != "<f4" and entry.get("normalized") is True, rounded)

    @property
    def finer(self) -> Encoding:
        """The next with more bits, for what these hold too roughly; itself where there is none."""
        return Encoding(_FINER.get(self.dtype, self.dtype), self.normalized, self.rounded)

    def encoded(
        self, values: NDArray[np.float64], *, directions: bool = False
    ) -> tuple[NDArray[Any], bool, NDArray[np.float64]]:
        """(N, 3) the numbers stored, whether they are normalized, and (N, 3) how far they are off.

        What does not fit into whole numbers is stored in single precision; of what turns directions
        such as normals, the few vectors that are too long are shortened.
        """
        kind = np.dtype(self.dtype)
        if kind.kind == "i":
            limits = np.iinfo(kind)
            unit = 1.0 / limits.max if self.normalized else 1.0
            if directions and self.normalized:
                values = values / np.maximum(1.0, np.abs(values).max(axis=1, keepdims=True))
            steps = np.round(values / unit)
            if np.abs(steps).max(initial=0.0) <= limits.max:
                return steps.astype(kind), self.normalized, steps * unit - values
        if self.rounded and values.any():
            # Multiples of a power of two leave bytes of zeros, which pack well.
            step = 2.0 ** np.floor(np.log2(_ROUNDED * np.abs(values).max()))
            rows = (np.round(values / step) * step).astype(np.float32)
        else:
            rows = values.astype(np.float32)
        return rows, False, rows - values


Fields = NDArray[np.float64]

_KINDS = ("NORMAL", "TANGENT")


def spaces_of(file: GltfFile, mesh: FaceMesh, entry: dict[str, Any]) -> dict[int, MeshSpace]:
    """The vertices of each primitive that was read, the same for those that share them."""
    known: dict[tuple[Any, ...], MeshSpace] = {}
    found = {}
    for number, block in mesh.block_of.items():
        attributes = entry["primitives"][number]["attributes"]
        key = (block, *(repr(attributes.get(kind)) for kind in _KINDS))
        if key not in known:
            known[key] = MeshSpace(file, mesh.blocks[block], attributes, f"mesh {mesh.number}")
            known[key].require_place()
        found[number] = known[key]
    return found


_SEEN = 1e-3  # as a fraction of D: what moves less in one mesh alone is not seen


class MeshEdit:
    """A mesh of a document that bends are added to.

    Args:
        file: The file.
        mesh: The mesh, as it was read.
        document: The document that is changed.
        additions: What is added to it.
        extent: D, in the unit of the scene.
        tolerance: How far rounding may move a vertex before more bits are used, fraction of D.
    """

    def __init__(
        self,
        file: GltfFile,
        mesh: FaceMesh,
        document: dict[str, Any],
        additions: Additions,
        extent: float,
        tolerance: float,
    ) -> None:
        self._file, self._mesh, self._additions = file, mesh, additions
        self._entry: dict[str, Any] = document["meshes"][mesh.number]
        self._document = document
        self._extent, self._tolerance = extent or 1.0, tolerance
        self._targets = {morph: target for target, morph in mesh.morph_of.items()}
        self._bends: list[tuple[int | Driven, BendCurve | None, float]] = []
        self._folds: dict[int, tuple[Any, float]] = {}
        self.number = mesh.number
        self._spaces = spaces_of(file, mesh, self._entry)
        name = self._entry.get("name")
        self.title = name if isinstance(name, str) and name else f"mesh {mesh.number}"
        self.names: list[str] = []  # of the targets that were added
        self._stored: dict[str, dict[str, Any]] = {}  # what is said of each morph that bends
        self._driven: dict[str, tuple[dict[str, Any], Corrective]] = {}  # and of what is driven
        # How far the numbers of all bends of a target together are from them, fraction of D.
        self.error = 0.0

    def add(self, bent: BentMorph, bends: Fields, normals: Fields | None) -> None:
        """The bends (K, V, 3) of a morph of the face, and what they add to its normals."""
        names = (bent.name,) if bent.law is None else bent.law.drivers
        missing = {*names} - self._targets.keys()
        if missing:
            moves = np.linalg.norm(bends[:, self._mesh.rig_vertices], axis=2).max(initial=0.0)
            if bent.law is not None and moves > _SEEN * self._extent:
                warn(
                    f"{self._file.path}: {self.title!r} has no target {min(missing)!r}, so that "
                    f"{bent.name!r} does not move it; give it one that moves nothing"
                )
            return
        columns = [self._mesh.names.index(self._targets[name]) for name in names]
        column, title = columns[0], self._mesh.names[columns[0]]
        driver: int | Driven = column
        if bent.law is not None:
            driver, title = Driven(tuple(columns), bent.law), bent.name
        added = bent.added
        peaks = [1.0 if curve is None else curve.height for curve in added]
        curves: list[dict[str, Any]] = []
        shape: dict[str, Any] = {}
        own = bends[:, self._mesh.rig_vertices]
        lengths = np.linalg.norm(own, axis=2)
        rounded = 0.0
        for k in np.flatnonzero(lengths.any(axis=1)).tolist():
            curve, bend = added[k], k + len(bent.morph.bends) - len(added)
            name = self._new_name(title if curve is None else f"{title}.bend{bend + 1}")
            self.names.append(name)
            self._bends.append((driver, curve, float(lengths[k].max()) / self._extent))
            if curve is None:
                shape = {"target": name}
            else:
                curves.append({"target": name, "curve": curve_to_json(curve)})
            turned = None if normals is None else normals[k][self._mesh.rig_vertices]
            rounded += self._add_target(column, own[k], turned, float(peaks[k]))
        self.error = max(self.error, rounded)
        entry: dict[str, Any] = {**shape, "method": bent.morph.method, "bends": curves}
        if bent.fold is not None:
            delta = np.linalg.norm(bent.morph.delta, axis=1).max(initial=0.0) / self._extent
            self._folds[column] = (bent.fold, float(delta))
            entry["fold"] = curve_to_json(bent.fold)
        if bent.morph.limit_law.coefficients.any():
            entry["limit_law"] = curve_to_json(bent.morph.limit_law)
        entry["bake_error"] = bent.error * self._extent / (self._mesh.diameter or 1.0)
        if bent.law is None:
            self._stored[bent.name] = entry
        elif shape or curves:
            self._driven[bent.name] = entry, bent.law

    def _add_target(self, column: int, bend: Fields, normals: Fields | None, peak: float) -> float:
        """One further target in every primitive; those that share vertices share accessors.

        Returned is how far its numbers are from it, as a fraction of D.
        """
        known: dict[tuple[Any, ...], int] = {}
        farthest = 0.0
        for number, primitive in enumerate(self._entry["primitives"]):
            example = primitive["targets"][column]
            kinds = dict.fromkeys(["POSITION", *(kind for kind in _KINDS if kind in example)])
            target: dict[str, Any] = {}
            for kind in kinds:
                encoding = Encoding.of(self._file, example.get(kind), rounded=self._additions.packs)
                space = self._spaces.get(number)
                key = (kind, encoding, space or number)
                if key not in known:
                    values = self._values(kind, number, bend, normals)
                    if kind == "POSITION":
                        known[key], away = self._moves(encoding, values, space, peak)
                        farthest = max(farthest, away)
                    else:
                        rows, normalized, _ = encoding.encoded(values, directions=True)
                        known[key] = self._additions.displacements(rows, normalized=normalized)
                target[kind] = known[key]
            primitive["targets"].append(target)
        return farthest

    def _moves(
        self, encoding: Encoding, values: Fields, space: MeshSpace | None, peak: float
    ) -> tuple[int, float]:
        """The accessor of (N, 3) displacements, and how far it is from them, fraction of D."""
        while True:
            rows, normalized, away = encoding.encoded(values)
            error = 0.0
            if space is not None:
                lengths = np.linalg.norm(space.block.placement.offsets(away), axis=1)
                error = peak * float(lengths.max()) / self._extent
            if error <= self._tolerance or encoding.finer == encoding:
                break
            encoding = encoding.finer
        number = self._additions.displacements(rows, normalized=normalized, bounds=True)
        return number, error

    def _values(self, kind: str, primitive: int, bend: Fields, normals: Fields | None) -> Fields:
        """(N, 3) of a bend in the space of the mesh."""
        space = self._spaces.get(primitive)
        if space is None:  # lines, of which nothing is read
            positions = self._entry["primitives"][primitive]["attributes"]["POSITION"]
            count = self._file.item("accessors", positions, "a primitive")["count"]
            return np.zeros((count, 3))
        if kind == "POSITION":
            return space.displacements(bend[space.rows])
        if normals is None or kind not in ("NORMAL", "TANGENT"):
            return np.zeros((len(space.block.vertices), 3))
        turned = space.normals(normals[space.rows])
        return turned if kind == "NORMAL" else space.tangents(turned)

    def _new_name(self, name: str) -> str:
        taken = {*self._mesh.names, *self.names}
        while name in taken:
            name += "_"
        return name

    def finish(self, paths: Mapping[str, Morph]) -> Columns | None:
        """Write names, default weights and curves; how the weights of the mesh are extended."""
        if not self._bends and not self._folds:
            return None
        names, morph_of = self._mesh.names, self._mesh.morph_of
        known = self._mesh.bends
        lengths = (
            known[name]
            if name in known
            else float(np.linalg.norm(paths[morph_of[name]].delta, axis=1).max())
            for name in names
        )
        sizes = tuple(own / self._extent for own in lengths)
        columns = Columns(len(names), tuple(self._bends), self._folds, sizes)
        extras = self._entry.setdefault("extras", {})
        self._extend_names(extras)
        given = extras["targetNames"]
        morphs: list[dict[str, Any]] = list(self._mesh.stored.get("morphs", []))
        if not self._mesh.bent:
            names_given = enumerate(given[: columns.count])
            morphs = [self._described(n, own, paths) for n, own in names_given]
        morphs += [
            {"name": name, "choice": choice_to_json(paths[name].choice), **entry}
            for name, (entry, _) in self._driven.items()
        ]
        driven = {name: law for name, (_, law) in self._driven.items()}
        correctives = [*self._mesh.stored.get("correctives", []), *corrective_entries(driven)]
        nodes = (n for n in self._document.get("nodes", []) if isinstance(n, dict))
        for holder in (self._entry, *(n for n in nodes if n.get("mesh") == self._mesh.number)):
            if "weights" in holder:
                given = self._weights(holder["weights"])
                holder["weights"] = [*given, *columns.weights(given).tolist()[len(given) :]]
                for place in columns.folds:
                    holder["weights"][place] = float(columns.weights(given)[place])
            if holder is not self._entry and isinstance(holder.get("extras"), dict):
                holder["extras"].pop("elastomorph", None)  # programs read it over that of the mesh
        extras["elastomorph"] = {
            **self._mesh.stored,
            "version": least_version(morphs, correctives),
            "morphs": morphs,
            **({"correctives": correctives} if correctives else {}),
        }
        return columns

    def _described(self, number: int, given: str, paths: Mapping[str, Morph]) -> dict[str, Any]:
        """What is said of a target, by the name that the file gives it and others may have."""
        target = self._mesh.names[number]
        name = self._mesh.morph_of.get(target, target)
        entry: dict[str, Any] = {"name": name, "target": given}
        if self._entry["extras"]["targetNames"].count(given) > 1:
            entry["index"] = number
        own = self._stored.get(name)
        if own is None:
            return entry | {"method": "linear", "bake_error": 0.0, "choice": None, "bends": []}
        return entry | {"choice": choice_to_json(paths[name].choice)} | own

    def _weights(self, given: Any) -> list[float]:
        count = len(self._mesh.names)
        numbers = isinstance(given, list) and all(
            isinstance(own, int | float) and not isinstance(own, bool) for own in given
        )
        if not numbers or len(given) != count:
            self._file.refuse(
                f"default weights of mesh {self._mesh.number} are not {count} numbers, one for "
                "each morph target"
            )
        return list(given)

    def _extend_names(self, extras: dict[str, Any]) -> None:
        """Names of the new targets, wherever the others have a list of them.

        Older programs name each target within it, where glTF allows no names: new ones are named
        in the list of the mesh alone.
        """
        count = len(self._mesh.names)
        lists = [extras]
        for primitive in self._entry["primitives"]:
            own = primitive.get("extras")
            if isinstance(own, dict):
                lists.append(own)
        holding = [own for own in lists if isinstance(own.get("targetNames"), list)]
        for own in holding:
            given = own["targetNames"] + [None] * count
            pairs = zip(given, self._mesh.names, strict=False)
            named = [name if isinstance(name, str) else known for name, known in pairs]
            own["targetNames"] = [*named, *self.names]
        if not any(own is extras for own in holding):
            extras["targetNames"] = [*self._mesh.names, *self.names]


_LIKE = 1e-3  # a normal that is turned by less (0.06°) is lit alike


@dataclass(frozen=True, eq=False)
class NormalBends:
    """The surface that normals are computed of.

    Attributes:
        mesh: Its vertices are one for each place and normal.
        of_vertex: (V,) which of them each vertex of the face is, -1 where nothing moves.
        first: (S,) a vertex of the face that each of them is.
        corners: What normals are summed over.
        at_rest: (S, 3) unit normals of the neutral.
    """

    mesh: Mesh
    of_vertex: NDArray[np.int64]
    first: NDArray[np.int64]
    corners: NormalField
    at_rest: Fields

    @classmethod
    def of(cls, face: Face, spaces: Sequence[tuple[NDArray[np.int64], MeshSpace]]) -> NormalBends:
        """That of a face, from its vertices in each of some primitives."""
        neutral, place = face.rig.neutral, face.welding.place
        normals = np.zeros_like(neutral.vertices)
        for vertices, space in spaces:
            normals[vertices[space.rows]] = space.scene_normals
        rows = np.column_stack([place, np.round(normals / _LIKE)])
        moving = np.flatnonzero(place >= 0)
        _, first, label = np.unique(rows[moving], axis=0, return_index=True, return_inverse=True)
        of_vertex = np.full(len(place), -1, dtype=np.int64)
        of_vertex[moving] = label.reshape(-1)
        triangles = of_vertex[neutral.faces.triangles()]
        twice = np.roll(triangles, 1, axis=1) == triangles
        solid = triangles[(triangles >= 0).all(axis=1) & ~twice.any(axis=1)]
        mesh = Mesh(neutral.vertices[moving[first]], Polygons.of(solid.astype(np.int32)))
        corners = NormalField.of(mesh.faces)
        return cls(mesh, of_vertex, moving[first], corners, corners.normals(mesh.vertices))

    def bends(self, bent: BentMorph, target: Fields, bends: Fields) -> Fields:
        """(K, V, 3) what is added to normals by what is added to a morph to a target (V, 3)."""
        count, curves = len(bends), bent.morph.bend_curves
        first = int(bent.shape is None)  # a shape has normals of its own
        end = self.mesh.with_vertices(target[self.first])
        fields = bends[1 - first :, self.first]
        if bent.fold is not None:  # its part is played by the normals of the target itself
            fields = np.concatenate([fields, (end.vertices - self.mesh.vertices)[None]])
            curves = (*curves, bent.fold)
        path = replace(bent.morph, neutral=self.mesh, target=end, bends=fields, bend_curves=curves)
        every = normal_deltas(self.corners, path, range(len(curves)), self.at_rest)
        added = every[first : first + count]
        peaks = np.array([1.0 if curve is None else curve.height for curve in bent.added])
        added[np.linalg.norm(added, axis=2) * peaks[:, None] < _LIKE] = 0.0
        padded = np.concatenate([added, np.zeros_like(added[:, :1])], axis=1)
        return np.asarray(padded[:, self.of_vertex])
