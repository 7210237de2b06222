"""The primitives of the meshes that a scene shows: vertices, triangles, morph targets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.io.blend_shapes import different_names
from elastomorph.io.gltf.accessors import read_floats, read_indices
from elastomorph.io.gltf.appearance import material_names, shown_coordinates
from elastomorph.io.gltf.container import GltfFile, open_gltf
from elastomorph.io.gltf.nodes import PlacedMesh, Placement, placed_meshes
from elastomorph.io.untrusted import naming_file
from elastomorph.model.polygons import Polygons

_POINTS, _TRIANGLES, _STRIP, _FAN = 0, 4, 5, 6
_FANS = "FB_ngon_encoding"  # Triangles of one polygon follow each other from its first corner


@dataclass(frozen=True, eq=False)
class Attributes:
    """What one or several primitives say of their vertices, in place."""

    start: int  # Number of the first of them among all vertices
    vertices: NDArray[np.float64]  # (N, 3) float64
    texture: NDArray[np.float64] | None  # (N, 2) float64 with v from the top, if any
    displacements: dict[str, NDArray[np.float64]]  # (N, 3) by morph target
    placement: Placement  # From the space of the mesh to that of the scene


@dataclass(eq=False)
class Primitives:
    """All primitives of a mesh."""

    given: list[str]  # Names of the morph targets in order, as the file has them
    attributes: list[Attributes] = field(default_factory=list)  # The vertices
    triangles: list[NDArray[np.int32]] = field(default_factory=list)  # (T, 3) a primitive
    begins: list[NDArray[np.bool_]] = field(default_factory=list)  # (T,) which begin a polygon
    materials: list[str | None] = field(default_factory=list)  # A primitive
    block_of: dict[int, int] = field(default_factory=dict)  # By primitive: which attributes

    @cached_property
    def targets(self) -> list[str]:
        """Names of the morph targets in order, each different from the others."""
        return different_names(self.given)

    @property
    def count(self) -> int:
        """Number of vertices."""
        return sum(len(own.vertices) for own in self.attributes)

    def vertices(self) -> NDArray[np.float64]:
        """(V, 3) positions of all vertices."""
        return np.concatenate([own.vertices for own in self.attributes])

    def texture(self) -> NDArray[np.float64] | None:
        """(V, 2) texture coordinates, v from the top, NaN where there are none; or None."""
        if all(own.texture is None for own in self.attributes):
            return None
        found = np.full((self.count, 2), np.nan)
        for own in self.attributes:
            if own.texture is not None:
                found[own.start : own.start + len(own.vertices)] = own.texture
        return found

    def polygons(self) -> Polygons:
        """The polygons that the triangles are fans of, each from its first corner."""
        begins = np.concatenate(self.begins)
        corners = np.column_stack([begins, begins, np.ones_like(begins)])
        offsets = np.append(0, np.cumsum(corners.sum(axis=1)))
        return Polygons(np.concatenate(self.triangles)[corners], offsets[np.append(begins, True)])

    def displacement(self, target: str) -> NDArray[np.float64]:
        """(V, 3) what a morph target moves."""
        found = np.zeros((self.count, 3))
        for own in self.attributes:
            if target in own.displacements:
                found[own.start : own.start + len(own.vertices)] = own.displacements[target]
        return found


def joined_primitives(
    parts: Sequence[Primitives], rows: Sequence[NDArray[np.int32]], count: int
) -> Primitives:
    """The meshes of one surface of so many vertices, of which each has some rows, as one.

    A ValueError where they do not fit.
    """
    place = np.concatenate(rows)
    apart = np.concatenate([part.vertices() for part in parts])
    vertices = np.full((count, 3), np.nan)
    vertices[place] = apart
    if not np.array_equal(vertices[place], apart) or np.isnan(vertices).any():
        raise ParameterError("its meshes do not lie on each other as they did")
    textures = [part.texture() for part in parts]
    texture = None
    if any(own is not None for own in textures):
        texture = np.full((count, 2), np.nan)
    displacements: dict[str, NDArray[np.float64]] = {}
    for part, own, shown in zip(parts, rows, textures, strict=True):
        if texture is not None and shown is not None:
            texture[own] = shown
        for name, moved in part.attributes[0].displacements.items():
            displacements.setdefault(name, np.zeros((count, 3)))[own] = moved
    placement = parts[0].attributes[0].placement
    return Primitives(
        list(dict.fromkeys(name for part in parts for name in part.targets)),
        [Attributes(0, vertices, texture, displacements, placement)],
        [own[t] for part, own in zip(parts, rows, strict=True) for t in part.triangles],
        [begins for part in parts for begins in part.begins],
        [name for part in parts for name in part.materials],
    )


def read_primitives(file: GltfFile, placed: Sequence[PlacedMesh]) -> list[Primitives | None]:
    """Read meshes of a scene; None for one that shows nothing of a surface.

    Triangles, strips and fans are read. Points are only where there is nothing else, as the
    markers of a capture; lines are passed over.
    """
    modes = {
        primitive.get("mode", _TRIANGLES)
        for mesh in file.items("meshes")
        if isinstance(mesh, dict)
        for primitive in file.list_in(mesh, "primitives", "a mesh")
        if isinstance(primitive, dict) and isinstance(primitive.get("mode", _TRIANGLES), int)
    }
    surfaces = (_TRIANGLES, _STRIP, _FAN)
    wanted = surfaces if modes.intersection(surfaces) else (_POINTS,)
    names = material_names(file)
    found = [_read_mesh(file, mesh, wanted, names) for mesh in placed]
    shown = [own for own in found if own.attributes]
    if not shown:
        file.refuse("it shows no triangles; expected a mesh with morph targets")
    targets = {name for own in shown for name in own.targets}
    # A morph has a target for every vertex, however few of them it moves; what it moves them by was
    # counted as it was read.
    copies = 1 if len(shown) == 1 else 2
    vertices = sum(own.count for own in shown)
    file.budget.spend_fields(vertices, len(targets), copies=copies)
    if len(shown) > 1:  # joining copies them
        file.budget.spend_fields(vertices, 2)
    return [own if own.attributes else None for own in found]


def target_count(file: GltfFile, placed: PlacedMesh) -> int:
    """Number of morph targets of a mesh."""
    of = f"mesh {placed.number}"
    primitives = file.list_in(file.item("meshes", placed.number, "a node"), "primitives", of)
    counts = [len(file.list_in(p, "targets", of)) for p in primitives if isinstance(p, dict)]
    return max(counts, default=0)


def _read_mesh(
    file: GltfFile, placed: PlacedMesh, modes: tuple[int, ...], materials: Sequence[str]
) -> Primitives:
    mesh = file.item("meshes", placed.number, "a node")
    of = f"mesh {placed.number}"
    numbered = {
        number: primitive
        for number, primitive in enumerate(file.list_in(mesh, "primitives", of))
        if isinstance(primitive, dict) and primitive.get("mode", _TRIANGLES) in modes
    }
    primitives = list(numbered.values())
    counts = [len(file.list_in(each, "targets", of)) for each in primitives]
    file.budget.spend_objects(sum(counts) + len(counts))
    found = Primitives(target_names([mesh, *primitives], max(counts, default=0)))
    known: dict[tuple[Any, ...], Attributes] = {}
    for number, primitive in numbered.items():
        attributes = file.object_in(primitive, "attributes", of)
        targets = [
            target.get("POSITION") if isinstance(target, dict) else None
            for target in file.list_in(primitive, "targets", of)
        ]
        image = shown_coordinates(file, primitive)
        named = (attributes.get("POSITION"), attributes.get(image), *targets)
        # What is no number is refused when it is read.
        key = tuple(value if isinstance(value, int) else None for value in named)
        if placed.skin is not None:
            key = (*key, *_held_by(attributes))
        if key not in known:
            by_name = dict(zip(found.targets, targets, strict=False))
            shown = {**attributes, "TEXCOORD_0": attributes.get(image)}
            known[key] = _read_attributes(file, placed, found.count, shown, by_name)
            found.attributes.append(known[key])
        found.block_of[number] = found.attributes.index(known[key])
        triangles = _read_triangles(file, primitive, known[key], of)
        begins = _begins(primitive, triangles)
        if known[key].placement.mirrors:  # fans from the same corner, wound the other way
            last = np.lexsort([-np.arange(len(begins)), np.cumsum(begins)])
            triangles = triangles[last][:, [0, 2, 1]]
        found.triangles.append(triangles)
        found.begins.append(begins)
        found.materials.append(_material_name(file, primitive, of, materials))
    return found


def _read_attributes(
    file: GltfFile, placed: PlacedMesh, start: int, attributes: dict[str, Any], targets: Any
) -> Attributes:
    """The vertices, from this number on, of the accessors of attributes and of named targets."""
    of = f"mesh {placed.number}"
    if "POSITION" not in attributes:
        file.refuse(f"a primitive of {of} has no positions")
    vertices = read_floats(file, attributes["POSITION"], 3, f"the positions of {of}")
    count, texture = len(vertices), None
    placement = placed.placement(file, attributes, count, of)
    if attributes.get("TEXCOORD_0") is not None:
        what = f"the texture coordinates of {of}"
        texture = read_floats(file, attributes["TEXCOORD_0"], 2, what, count=count)
    displacements = {}
    for name, number in targets.items():
        if number is not None:
            what = f"the morph target {name[:60]!r} of {of}"
            moved = read_floats(file, number, 3, what, count=count)
            if moved.any():
                displacements[name] = placement.offsets(moved)
    vertices = placement.positions(vertices)
    return Attributes(start, vertices, texture, displacements, placement)


def _read_triangles(
    file: GltfFile, primitive: dict[str, Any], attributes: Attributes, of: str
) -> NDArray[np.int32]:
    mode, count = primitive.get("mode", _TRIANGLES), len(attributes.vertices)
    if mode == _POINTS:
        return np.zeros((0, 3), dtype=np.int32)
    corners = np.arange(count)
    if "indices" in primitive:
        corners = read_indices(file, primitive["indices"], f"the triangles of {of}")
        if corners.max() >= count:
            file.refuse(f"a triangle of {of} names vertex {corners.max():,} of {count:,}")
    if len(corners) < 3 or (mode == _TRIANGLES and len(corners) % 3):
        file.refuse(f"{of} has {len(corners):,} corners, which do not make whole triangles")
    file.budget.spend(len(corners) * (12 if mode == _TRIANGLES else 36))
    if mode == _TRIANGLES:
        triangles = corners.reshape(-1, 3)
    else:
        triangles = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    if mode == _FAN:
        triangles[:, 0] = corners[0]
    if mode == _STRIP:
        triangles[1::2] = triangles[1::2, [1, 0, 2]]
        same = triangles == np.roll(triangles, 1, axis=1)
        triangles = triangles[~same.any(axis=1)]  # strips are joined by triangles without area
    return (triangles + attributes.start).astype(np.int32)


def _begins(primitive: dict[str, Any], triangles: NDArray[np.int32]) -> NDArray[np.bool_]:
    """(T,) which triangles begin a polygon: all, unless the file says that they are fans.

    Those that only begin with the corner of the one before, and do not lie on it, begin one too. So
    do all of a fan that comes to a corner again: no polygon has one twice.
    """
    begins = np.ones(len(triangles), dtype=bool)
    extensions = primitive.get("extensions")
    fans = isinstance(extensions, dict) and _FANS in extensions
    if fans and primitive.get("mode", _TRIANGLES) == _TRIANGLES:
        begins[1:] = (triangles[1:, :2] != triangles[:-1, [0, 2]]).any(axis=1)
        fan = np.cumsum(begins)
        of_fan = np.concatenate([fan, fan[begins]])
        corners = np.concatenate([triangles[:, 2], triangles[begins, 1]])
        ends, times = np.unique([of_fan, corners], axis=1, return_counts=True)
        begins |= np.isin(fan, ends[0, times > 1])
    return begins


def _material_name(
    file: GltfFile, primitive: dict[str, Any], of: str, names: Sequence[str]
) -> str | None:
    if "material" not in primitive:
        return None
    number = primitive["material"]
    file.item("materials", number, of)
    return names[int(number)]


def target_names(holders: Sequence[dict[str, Any]], count: int) -> list[str]:
    """The names of the morph targets of a mesh; ``target_0``, ``target_1`` where they have none.

    Most programs name them in the extras of the mesh, some in those of each primitive, and older
    ones in those of each target. Several may have the same.
    """
    lists: list[Any] = [_extras(holder).get("targetNames") for holder in holders]
    lists += [
        [_extras(target).get("name") for target in holder["targets"]]
        for holder in holders
        if isinstance(holder.get("targets"), list)
    ]
    named = (own for own in lists if isinstance(own, list) and any(type(n) is str for n in own))
    given: list[Any] = next(named, [])
    given = [*given[:count], *[None] * (count - len(given))]
    return [
        name if isinstance(name, str) else f"target_{number}" for number, name in enumerate(given)
    ]


def _extras(holder: Any) -> dict[str, Any]:
    extras = holder.get("extras") if isinstance(holder, dict) else None
    return extras if isinstance(extras, dict) else {}


def _held_by(attributes: dict[str, Any]) -> tuple[Any, ...]:
    """The accessors that say which joints hold the vertices of a primitive."""
    names = sorted(name for name in attributes if name.startswith(("JOINTS_", "WEIGHTS_")))
    return tuple((name, attributes[name]) for name in names if isinstance(attributes[name], int))


# Colours of vertices in glTF files (COLOR_0), as scanners give them that write no image.

_WIDTHS = {"VEC3": 3, "VEC4": 4}


def read_gltf_colours(path: str | Path) -> NDArray[np.uint8] | None:
    """The colours of the vertices of a .glb or .gltf file, or None where it has none.

    Returns:
        (V, 3) uint8, red first, as screens show them: a file has them as light is. The vertices
        are those of the meshes of its scene in their order; what has no colour is white.

    Raises:
        FileError: It cannot be read.
        FormatError: It is damaged.
    """
    file = open_gltf(path)
    if not any(_coloured(primitive) for mesh in file.items("meshes") for primitive in _in(mesh)):
        return None
    with naming_file(path), np.errstate(all="ignore"):
        placed = placed_meshes(file)
        read = zip(placed, read_primitives(file, placed), strict=True)
        light = np.concatenate([_light(file, *own) for own in read])
        light = np.clip(np.nan_to_num(light), 0, 1)
        low = light <= 0.0031308
        shown = np.where(low, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        return np.asarray(np.round(255 * shown), dtype=np.uint8)


def _light(
    file: GltfFile, placed: PlacedMesh, primitives: Primitives | None
) -> NDArray[np.float64]:
    """(V, 3) linear colours of a mesh, from 0 to 1."""
    if primitives is None:
        return np.ones((0, 3))
    found = np.ones((primitives.count, 3))
    of = f"the colours of mesh {placed.number}"
    every = _in(file.item("meshes", placed.number, "a node"))
    for number, block in primitives.block_of.items():
        if _coloured(every[number]):
            own = primitives.attributes[block]
            accessor = every[number]["attributes"]["COLOR_0"]
            kind = file.item("accessors", accessor, of).get("type")
            width = _WIDTHS.get(kind if isinstance(kind, str) else "", 4)
            values = read_floats(file, accessor, width, of, count=len(own.vertices))
            found[own.start : own.start + len(own.vertices)] = values[:, :3]
    return found


def _in(mesh: object) -> list[dict[str, dict[str, object]]]:
    """The primitives of a mesh; what is none stands as an empty one."""
    every = mesh.get("primitives") if isinstance(mesh, dict) else None
    every = every if isinstance(every, list) else []
    return [own if isinstance(own, dict) else {} for own in every]


def _coloured(primitive: dict[str, dict[str, object]]) -> bool:
    attributes = primitive.get("attributes")
    return isinstance(attributes, dict) and "COLOR_0" in attributes
