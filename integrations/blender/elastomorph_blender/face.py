"""The face of the selected objects: one neutral and its targets, as the world places them at rest.

Eyes, teeth and tongue are objects of their own and follow the same joint as the skin, so a path is
made for all of them at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from elastomorph import Mesh, Rig
from elastomorph.model.mesh import Source
from elastomorph.model.polygons import Polygons
from elastomorph.rig.build import bare_rig

from .record import bend_names, correctives
from .refusal import RefusedError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Part:
    """One object of a face.

    Attributes:
        thing: The object.
        basis: (V, 3) its neutral, in its own space.
        offsets: (V, 3) what each of its keys adds to the neutral at 1, in its own space.
        to_world: (4, 4) from its own space to the world, at rest.
    """

    thing: bpy.types.Object
    basis: Array
    offsets: dict[str, Array]
    to_world: Array

    @property
    def keys(self) -> bpy.types.Key:
        """The data-block of its shape keys."""
        return self.thing.data.shape_keys

    def placed(self) -> Array:
        """(V, 3) the neutral in the world."""
        return self.basis @ self.to_world[:3, :3].T + self.to_world[:3, 3]

    def turned(self, offsets: Array) -> Array:
        """(V, 3) offsets in the world."""
        return offsets @ self.to_world[:3, :3].T

    def own(self, offsets: Array) -> Array:
        """(V, 3) offsets of the world in the space of the object."""
        return offsets @ np.linalg.inv(self.to_world[:3, :3]).T


@dataclass(frozen=True, eq=False)
class Face:
    """Objects that share shape keys, as one face.

    Attributes:
        parts: Its objects.
        rig: Neutral and targets, in the world at rest.
        spans: For each part, its vertices of the rig.
    """

    parts: tuple[Part, ...]
    rig: Rig
    spans: tuple[slice, ...]


def selected_objects(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The active object, and the selected ones that share a shape key with it.

    Raises:
        RefusedError: Something about one of them cannot be bent.
    """
    active = context.active_object
    if active is None or active.type != "MESH":
        raise RefusedError("Select a mesh with shape keys: there is no active mesh object")
    if active.data.shape_keys is None or len(active.data.shape_keys.key_blocks) < 2:
        raise RefusedError(f"{active.name} has no shape keys beside its basis: select the face")
    if context.mode != "OBJECT":
        raise RefusedError("Shape keys are bent in object mode: leave the present mode first")
    own = set(target_names(active))
    things = [active]
    for thing in context.selected_objects:
        if thing == active or thing.type != "MESH" or thing.data.shape_keys is None:
            continue
        if own.intersection(target_names(thing)):
            things.append(thing)
    for thing in things:
        _require_editable(thing)
    return things


def target_names(thing: bpy.types.Object) -> list[str]:
    """Names of the shape keys of an object that are targets: neither its basis nor bends."""
    keys = thing.data.shape_keys
    bends = bend_names(keys)
    blocks = (block for block in keys.key_blocks if block != keys.reference_key)
    return [block.name for block in blocks if block.name not in bends]


def read_face(things: Sequence[bpy.types.Object]) -> Face:
    """The objects as one face.

    Raises:
        RefusedError: An object is scaled to nothing, or nothing moves.
    """
    parts = tuple(_part(thing) for thing in things)
    names = list(dict.fromkeys(name for part in parts for name in part.offsets))
    neutral = np.concatenate([part.placed() for part in parts])
    deltas = {name: np.zeros_like(neutral) for name in names}
    starts = np.cumsum([0, *(len(part.basis) for part in parts)])
    for part, start, stop in zip(parts, starts, starts[1:], strict=False):
        for name, offsets in part.offsets.items():
            deltas[name][start:stop] = part.turned(offsets)
    if not any(delta.any() for delta in deltas.values()):
        raise RefusedError(
            f"No shape key of {things[0].name} moves anything: there is nothing to bend"
        )
    # Importers split vertices at seams: those that are at one place in all keys move as one.
    source = Source(things[0].name, split=True)
    mesh = Mesh(neutral, _polygons(parts), source=source)
    targets = {name: mesh.with_vertices(neutral + delta) for name, delta in deltas.items()}
    spans = tuple(slice(start, stop) for start, stop in pairwise(starts.tolist()))
    laws = {name: law for part in parts for name, law in correctives(part.keys).items()}
    return Face(parts, Rig(mesh, bare_rig(mesh, targets).morphs, correctives=laws), spans)


def _require_editable(thing: bpy.types.Object) -> None:
    mesh = thing.data
    if thing.library or mesh.library or mesh.shape_keys.library or thing.override_library:
        library = thing.library or mesh.library or mesh.shape_keys.library
        source = f" from {library.filepath}" if library else " and overridden here"
        raise RefusedError(
            f"{thing.name} is linked{source}, where its shape keys are: bend it in its own file, "
            "or make its mesh local (Object > Relations > Make Local)"
        )
    if mesh.users - mesh.use_fake_user > 1:
        raise RefusedError(
            f"the mesh of {thing.name} is used by {mesh.users - mesh.use_fake_user} objects, which "
            "would all be bent: give it a mesh of its own (Object > Relations > Make Single User)"
        )
    if not mesh.shape_keys.use_relative:
        raise RefusedError(
            f"the shape keys of {thing.name} are absolute: paths lead to relative keys, so turn on "
            "Relative in Mesh data > Shape Keys"
        )


def _part(thing: bpy.types.Object) -> Part:
    keys = thing.data.shape_keys
    to_world = np.array(_at_rest(thing))
    if not np.isfinite(to_world).all() or np.linalg.matrix_rank(to_world[:3, :3]) < 3:
        raise RefusedError(f"{thing.name} is scaled to 0 along an axis: give it a scale")
    basis = positions(keys.reference_key)
    offsets = {}
    for name in target_names(thing):
        block = keys.key_blocks[name]
        offset = positions(block) - positions(block.relative_key)
        if block.vertex_group in thing.vertex_groups:
            offset *= _group_weights(thing, block.vertex_group)[:, None]
        offsets[name] = offset
    return Part(thing, basis, offsets, to_world)


def positions(block: bpy.types.ShapeKey) -> Array:
    """(V, 3) of a key, in the space of its object."""
    flat = np.empty(3 * len(block.data), dtype=np.float32)
    block.data.foreach_get("co", flat)
    return flat.astype(np.float64).reshape(-1, 3)


def _group_weights(thing: bpy.types.Object, name: str) -> Array:
    group = thing.vertex_groups[name].index
    weights = np.zeros(len(thing.data.vertices))
    for vertex in thing.data.vertices:
        for membership in vertex.groups:
            if membership.group == group:
                weights[vertex.index] = membership.weight
    return weights


def _at_rest(thing: bpy.types.Object) -> Matrix:
    """From the space of an object to the world, with armatures that carry it in their rest pose."""
    parent = thing.parent
    if parent is None:
        return thing.matrix_world.copy()
    if thing.parent_type != "BONE" or thing.parent_bone not in parent.data.bones:
        return _at_rest(parent) @ parent.matrix_world.inverted_safe() @ thing.matrix_world
    bone = parent.data.bones[thing.parent_bone]
    # Blender carries children at the tail of a bone, or relative to its rest pose.
    carried = (
        Matrix()
        if bone.use_relative_parent
        else (bone.matrix_local @ Matrix.Translation((0, bone.length, 0)))
    )
    return _at_rest(parent) @ carried @ thing.matrix_parent_inverse @ thing.matrix_basis


def _polygons(parts: Sequence[Part]) -> Polygons:
    """The polygons of all objects, over the vertices of the face."""
    corners, sizes, start = [], [], 0
    for part in parts:
        mesh = part.thing.data
        own = np.empty(len(mesh.loops), dtype=np.int32)
        mesh.loops.foreach_get("vertex_index", own)
        size = np.empty(len(mesh.polygons), dtype=np.int32)
        mesh.polygons.foreach_get("loop_total", size)
        corners.append(own + start)
        sizes.append(size)
        start += len(mesh.vertices)
    return Polygons(np.concatenate(corners), np.concatenate([[0], *sizes]).cumsum())
