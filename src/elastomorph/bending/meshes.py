"""The meshes of a document with the bends they get: targets, names, default weights, curves.

New targets follow all others, so that whatever names a target by its number, such as an expression
of VRM, means the same as before.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.bending.additions import Additions
from elastomorph.bending.encoding import Encoding
from elastomorph.bending.face import FaceMesh
from elastomorph.bending.keys import Columns
from elastomorph.bending.plan import BentMorph
from elastomorph.bending.spaces import MeshSpace
from elastomorph.io.blend_shapes import curve_to_json
from elastomorph.io.choices import choice_to_json
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.rig_extras import FOLDS, INDICES, WITHOUT_FOLDS
from elastomorph.model.morph import Morph

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
        self._bends: list[tuple[int, Any, float]] = []
        self._folds: dict[int, tuple[Any, float]] = {}
        self.number = mesh.number
        self._spaces = spaces_of(file, mesh, self._entry)
        name = self._entry.get("name")
        self.title = name if isinstance(name, str) and name else f"mesh {mesh.number}"
        self.names: list[str] = []  # of the targets that were added
        self._stored: dict[str, dict[str, Any]] = {}  # what is said of each morph that bends
        # How far the numbers of all bends of a target together are from them, fraction of D.
        self.error = 0.0

    def add(self, bent: BentMorph, bends: Fields, normals: Fields | None) -> None:
        """The bends (K, V, 3) of a morph of the face, and what they add to its normals."""
        if bent.name not in self._targets:
            return
        column = self._mesh.names.index(self._targets[bent.name])
        peaks = np.array([curve.height for curve in bent.morph.bend_curves])
        curves: list[dict[str, Any]] = []
        own = bends[:, self._mesh.rig_vertices]
        lengths = np.linalg.norm(own, axis=2)
        rounded = 0.0
        for k in np.flatnonzero(lengths.any(axis=1)).tolist():
            name = self._new_name(f"{self._mesh.names[column]}.bend{k + 1}")
            self.names.append(name)
            curve = bent.morph.bend_curves[k]
            self._bends.append((column, curve, float(lengths[k].max()) / self._extent))
            curves.append({"target": name, "curve": curve_to_json(curve)})
            turned = None if normals is None else normals[k][self._mesh.rig_vertices]
            rounded += self._add_target(column, own[k], turned, float(peaks[k]))
        self.error = max(self.error, rounded)
        entry: dict[str, Any] = {"method": bent.morph.method, "bends": curves}
        if bent.fold is not None:
            delta = np.linalg.norm(bent.morph.delta, axis=1).max(initial=0.0) / self._extent
            self._folds[column] = (bent.fold, float(delta))
            entry["fold"] = curve_to_json(bent.fold)
        if bent.morph.limit_law.coefficients.any():
            entry["limit_law"] = curve_to_json(bent.morph.limit_law)
        entry["bake_error"] = bent.error * self._extent / (self._mesh.diameter or 1.0)
        self._stored[bent.name] = entry

    @property
    def columns(self) -> Columns | None:
        """How its weights are extended; None where nothing was added."""
        if not self._bends and not self._folds:
            return None
        return Columns(len(self._mesh.names), tuple(self._bends), self._folds)

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
                encoding = Encoding.of(self._file, example.get(kind))
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
        columns = self.columns
        if columns is None:
            return None
        extras = self._entry.setdefault("extras", {})
        self._extend_names(extras)
        given = extras["targetNames"]
        morphs = [self._described(n, own, paths) for n, own in enumerate(given[: columns.count])]
        version = FOLDS if columns.folds else WITHOUT_FOLDS
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
            "version": INDICES if any("index" in own for own in morphs) else version,
            "morphs": morphs,
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
