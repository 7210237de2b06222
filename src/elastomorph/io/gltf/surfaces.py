"""Reads the primitives of the meshes that a scene shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.accessors import AccessorReader
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.scene import PlacedMesh
from elastomorph.io.gltf.scene_surface import Piece, SceneSurface, Sheet

__all__ = ["read_surfaces", "shape_count"]

_POINTS, _TRIANGLES, _STRIP, _FAN = 0, 4, 5, 6
_DRACO = "KHR_draco_mesh_compression"


def read_surfaces(file: GltfFile, placed: Sequence[PlacedMesh]) -> list[SceneSurface | None]:
    """Read meshes of a scene; None for one that shows nothing of a surface.

    Triangles, strips and fans are read. Points are only where there is nothing else, as the
    markers of a capture; lines are passed over.

    Raises:
        FormatError: Something does not exist, does not fit, or is compressed.
    """
    modes = {
        primitive.get("mode", _TRIANGLES)
        for mesh in file.items("meshes")
        if isinstance(mesh, dict)
        for primitive in file.list_in(mesh, "primitives", "a mesh")
        if isinstance(primitive, dict) and isinstance(primitive.get("mode", _TRIANGLES), int)
    }
    wanted = (_TRIANGLES, _STRIP, _FAN) if modes & {_TRIANGLES, _STRIP, _FAN} else (_POINTS,)
    reader = _SurfaceReader(file, wanted)
    found = [reader.read(mesh) for mesh in placed]
    surfaces = [surface for surface in found if surface.sheets]
    if not surfaces:
        file.refuse("it shows no triangles; expected a mesh with morph targets")
    names = dict.fromkeys(name for surface in surfaces for name in surface.targets)
    # A morph has a displacement and a target for every vertex, however few of them it moves.
    copies = 2 if len(surfaces) == 1 else 3
    vertices = sum(surface.count for surface in surfaces)
    file.budget.spend_fields(vertices, len(names), copies=copies)
    if len(surfaces) > 1:  # joining copies them
        file.budget.spend_fields(vertices, 2)
    return [surface if surface.sheets else None for surface in found]


def shape_count(file: GltfFile, placed: PlacedMesh) -> int:
    """Number of morph targets of a mesh."""
    mesh = file.item("meshes", placed.number, "a node")
    of = f"mesh {placed.number}"
    primitives = file.list_in(mesh, "primitives", of)
    counts = [len(file.list_in(p, "targets", of)) for p in primitives if isinstance(p, dict)]
    return max(counts, default=0)


class _SurfaceReader:
    def __init__(self, file: GltfFile, modes: tuple[int, ...]) -> None:
        self._file = file
        self._modes = modes
        self._accessors = AccessorReader(file)

    def read(self, placed: PlacedMesh) -> SceneSurface:
        """A mesh with all its primitives."""
        file = self._file
        mesh = file.item("meshes", placed.number, "a node")
        of = f"mesh {placed.number}"
        primitives = [
            primitive
            for primitive in file.list_in(mesh, "primitives", of)
            if isinstance(primitive, dict) and primitive.get("mode", _TRIANGLES) in self._modes
        ]
        counts = [len(file.list_in(each, "targets", of)) for each in primitives]
        file.budget.spend_objects(sum(counts) + len(counts))
        names = target_names([mesh, *primitives], max(counts, default=0))
        surface = SceneSurface(names)
        sheets: dict[tuple[Any, ...], Sheet] = {}
        mirrors = np.linalg.det(placed.linear) < 0
        for primitive in primitives:
            attributes = file.object_in(primitive, "attributes", of)
            targets = [
                target.get("POSITION") if isinstance(target, dict) else None
                for target in file.list_in(primitive, "targets", of)
            ]
            named = (attributes.get("POSITION"), attributes.get("TEXCOORD_0"), *targets)
            # What is no number is refused when it is read.
            key = tuple(value if isinstance(value, int) else None for value in named)
            if key not in sheets:
                self._refuse_compressed(primitive, attributes, of)
                named_targets = dict(zip(names, targets, strict=False))
                sheets[key] = self._sheet(attributes, named_targets, placed, surface.count)
                surface.sheets.append(sheets[key])
            triangles = self._triangles(primitive, sheets[key], of)
            if mirrors:
                triangles = triangles[:, [0, 2, 1]]
            surface.pieces.append(Piece(triangles, self._material(primitive, of)))
        return surface

    def _sheet(
        self,
        attributes: dict[str, Any],
        targets: dict[str, Any],
        placed: PlacedMesh,
        start: int,
    ) -> Sheet:
        read, of = self._accessors.floats, f"mesh {placed.number}"
        if "POSITION" not in attributes:
            self._file.refuse(f"a primitive of {of} has no positions")
        vertices = read(attributes["POSITION"], 3, f"the positions of {of}")
        texture = None
        if "TEXCOORD_0" in attributes:
            what = f"the texture coordinates of {of}"
            texture = read(attributes["TEXCOORD_0"], 2, what, count=len(vertices))
        displacements = {}
        for name, number in targets.items():
            if number is not None:
                moved = read(
                    number, 3, f"the morph target {name[:60]!r} of {of}", count=len(vertices)
                )
                if moved.any():
                    displacements[name] = turned(moved, placed.linear)
        return Sheet(
            start,
            turned(vertices, placed.linear) + placed.offset,
            texture,
            displacements,
        )

    def _triangles(self, primitive: dict[str, Any], sheet: Sheet, of: str) -> NDArray[np.int32]:
        file, mode = self._file, primitive.get("mode", _TRIANGLES)
        if mode == _POINTS:
            return np.zeros((0, 3), dtype=np.int32)
        if "indices" in primitive:
            corners = self._accessors.indices(primitive["indices"], f"the triangles of {of}")
            if corners.max() >= len(sheet.vertices):
                file.refuse(
                    f"a triangle of {of} names vertex {corners.max():,} of {len(sheet.vertices):,}"
                )
        else:
            corners = np.arange(len(sheet.vertices), dtype=np.int64)
        if len(corners) < 3 or (mode == _TRIANGLES and len(corners) % 3):
            file.refuse(f"{of} has {len(corners):,} corners, which do not make whole triangles")
        self._file.budget.spend(len(corners) * (12 if mode == _TRIANGLES else 36))
        if mode == _TRIANGLES:
            triangles = corners.reshape(-1, 3)
        elif mode == _FAN:
            first = np.full(len(corners) - 2, corners[0])
            triangles = np.stack([first, corners[1:-1], corners[2:]], axis=1)
        else:
            triangles = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
            triangles[1::2] = triangles[1::2, [1, 0, 2]]
            same = triangles == np.roll(triangles, 1, axis=1)
            triangles = triangles[~same.any(axis=1)]  # strips are joined by triangles without area
        return (triangles + sheet.start).astype(np.int32)

    def _material(self, primitive: dict[str, Any], of: str) -> str | None:
        if "material" not in primitive:
            return None
        name = self._file.item("materials", primitive["material"], of).get("name")
        return name if isinstance(name, str) else f"material {primitive['material']}"

    def _refuse_compressed(
        self, primitive: dict[str, Any], attributes: dict[str, Any], of: str
    ) -> None:
        if _DRACO in self._file.object_in(primitive, "extensions", of) and "bufferView" not in (
            self._file.item("accessors", attributes.get("POSITION"), of)
        ):
            self._file.refuse(
                "it is compressed with Draco, which is not read. Export it again without "
                "compression"
            )


def target_names(holders: Sequence[dict[str, Any]], count: int) -> list[str]:
    """The names of the morph targets of a mesh; ``target_0``, ``target_1`` where they have none.

    Most programs name them in the extras of the mesh, some in those of each primitive, and older
    ones in those of each target.

    Args:
        holders: The mesh and its primitives.
        count: Number of targets.
    """
    lists: list[Any] = [_extras(holder).get("targetNames") for holder in holders]
    lists += [
        [_extras(target).get("name") for target in holder["targets"]]
        for holder in holders
        if isinstance(holder.get("targets"), list)
    ]
    given: list[Any] = next((names for names in lists if _has_names(names)), [])
    names: dict[str, None] = {}
    again: dict[str, int] = {}
    for number in range(count):
        found = given[number] if number < len(given) else None
        plain = name = found if isinstance(found, str) else f"target_{number}"
        while name in names:
            again[plain] = again.get(plain, 1) + 1
            name = f"{plain}_{again[plain]}"
        names[name] = None
    return list(names)


def _extras(holder: Any) -> dict[str, Any]:
    extras = holder.get("extras") if isinstance(holder, dict) else None
    return extras if isinstance(extras, dict) else {}


def _has_names(names: Any) -> bool:
    return isinstance(names, list) and any(isinstance(name, str) for name in names)


def turned(vectors: NDArray[np.float64], linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) vectors times a matrix from the left; untouched by the unit matrix."""
    if np.array_equal(linear, np.eye(3)):
        return vectors
    return np.asarray(np.einsum("ij,nj->ni", linear, vectors))
