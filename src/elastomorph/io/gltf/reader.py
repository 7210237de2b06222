"""Reads a rig from .glb and .gltf files: our own as they were, others as they are."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError, warn
from elastomorph.io.choices import ListedMesh, chosen_meshes, wanted_names
from elastomorph.io.gltf.accessors import EXTENSION as DRACO
from elastomorph.io.gltf.appearance import read_appearance
from elastomorph.io.gltf.container import GltfFile, object_of, open_gltf
from elastomorph.io.gltf.mesh_extras import is_part, restored_surface, rows_of_parts, unpacked
from elastomorph.io.gltf.meshopt import EXTENSIONS as MESHOPT
from elastomorph.io.gltf.nodes import PlacedMesh, placed_meshes
from elastomorph.io.gltf.primitives import (
    Primitives,
    joined_primitives,
    read_primitives,
    target_count,
)
from elastomorph.io.gltf.rig_extras import (
    StoredMorph,
    StoredRig,
    described_meshes,
    joined_rigs,
    stored_rig,
)
from elastomorph.io.joined_rig import Placing, RigPart, joined_rig
from elastomorph.io.untrusted import naming_file, shortened
from elastomorph.model.mesh import FaceLabels, Material, Mesh, Source, UVMap
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig
from elastomorph.rig.laws import Corrective

# What they say is of materials, images, lights, sounds or behaviour: no vertex depends on it.
_HARMLESS = (
    *("KHR_materials_", "EXT_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_"),
    *("KHR_lights_", "EXT_lights_", "KHR_audio_", "KHR_physics_", "KHR_interactivity", "KHR_xmp"),
    *("VRM", "KHR_node_visibility", "KHR_animation_pointer"),
)
# As the targets of bends are named.
_BEND = re.compile(r"(.+)\.bend\d+_*")
_READ = ("KHR_mesh_quantization", DRACO, *MESHOPT)


def read_glb(path: str | Path, *, mesh: str | Sequence[str] | None = None) -> Rig:
    """The rig in a .glb, .gltf or .vrm file.

    A file of `write_glb` comes back with its polygons, vertex order, texture coordinates, labels,
    bends and bend curves; positions in single precision. If another program has changed it so
    that these no longer fit, a warning says so and it is read as any other file:

    - All meshes of the scene become one, in the order of the scene and placed by their nodes; one
      with a skin by its joints, vertex by vertex, in the pose that the file shows at rest.
      Vertices are neither merged nor reordered; triangles stay triangles, unless
      ``FB_ngon_encoding`` says which polygons they are of.
    - Morph targets of the same name in several meshes are one morph, on a straight path; a mesh
      without any is part of the neutral. Targets without names are called ``target_0`` and so on.
    - Materials become material labels, of those of one name with a number behind the second; nodes
      become group labels where several have a mesh. What they look like is in `Mesh.appearance`,
      unless all are plain greys, and the texture coordinates are those of their base colours.
    - Animations and default weights are passed over.

    Args:
        path: The file. Buffers in other files are read only from its own folder.
        mesh: Name of the mesh to read, or names of several: of its node or its own.

    Raises:
        FileError: A file is missing or cannot be read.
        FormatError: It is damaged, needs an extension that is not read, or has no mesh of a name.
        MissingExtraError: It is compressed, and what unpacks it is not installed.
        ParameterError: An empty list of names.
    """
    wanted = wanted_names(mesh)
    file = open_gltf(path)
    require_known_extensions(file)
    with naming_file(path), np.errstate(all="ignore"):
        return rig_of(file, read_meshes(file, wanted_meshes(file, wanted)))


@dataclass(frozen=True, eq=False)
class ReadMesh:
    """A surface of a scene, and what the file says of its morphs."""

    part: RigPart
    stored: StoredRig
    gone: str  # What another program has left out of what elastomorph stored, if anything
    sheets: tuple[Sheet, ...]  # The meshes of the scene that show it: one, but in files of ours


@dataclass(frozen=True, eq=False)
class Sheet:
    """A mesh of a scene that shows a surface, or one material of it."""

    placed: PlacedMesh
    primitives: Primitives
    stored: Any  # ``extras.elastomorph``, None where there is none
    rows: NDArray[np.int32]  # (N,) the vertex of the surface that each of its vertices is

    @property
    def said(self) -> dict[str, Any]:
        """What is stored with it."""
        return self.stored if isinstance(self.stored, dict) else {}


def read_meshes(file: GltfFile, placed: Sequence[PlacedMesh]) -> list[ReadMesh]:
    """Meshes of a scene as far as they show a surface."""
    read = list(zip(placed, read_primitives(file, placed), strict=True))
    used = {name for _, own in read if own is not None for name in own.materials if name}
    looks, described = read_appearance(file, used), described_meshes(file)
    sheets = [
        Sheet(own, shown, described.get(own.number), np.arange(shown.count, dtype=np.int32))
        for own, shown in read
        if shown is not None
    ]
    return [_read(file, own, looks) for own in _surfaces(file, sheets)]


def rig_of(file: GltfFile, meshes: Sequence[ReadMesh]) -> Rig:
    """The rig that some meshes of a file are together; a warning says what they have lost."""
    gone = list(dict.fromkeys(filter(None, (own.gone or _emptied(own, meshes) for own in meshes))))
    if gone:
        more = f"; {len(gone) - 1} more of its meshes have lost something too" if gone[1:] else ""
        warn(f"{file.path}: {gone[0]}{more}")
    correctives: dict[str, Corrective] = {}
    groups: dict[str, list[str]] = {}
    for own in meshes:
        correctives |= own.stored.correctives
        groups |= own.stored.groups
    neutral, morphs = joined_rig([own.part for own in meshes], str(file.path))
    return Rig(neutral, morphs, correctives=correctives, groups=groups)


def wanted_meshes(file: GltfFile, wanted: Sequence[str]) -> list[PlacedMesh]:
    """The meshes of the scene that have one of some names; all where none is given."""
    placed = placed_meshes(file)
    if not wanted:
        return placed
    listed = [ListedMesh(own.names, target_count(file, own)) for own in placed]
    try:
        return [placed[number] for number in chosen_meshes(listed, wanted)]
    except ParameterError as problem:
        file.refuse(str(problem))


def _surfaces(file: GltfFile, sheets: Sequence[Sheet]) -> list[tuple[list[Sheet], Primitives]]:
    """The meshes that show each surface, and the surface; one each, but in files of ours."""
    parts = [own for own in sheets if is_part(own.stored)]
    apart = [([own], own.primitives) for own in sheets]
    if not any("whole" in own.said for own in parts):  # some of them alone
        return apart
    parts.sort(key=lambda own: str(own.said["part"].get("number")).zfill(9))
    try:
        if any(len(own.primitives.attributes) != 1 for own in parts):
            raise ParameterError("another program has split or changed its vertices")
        counts = [own.primitives.count for own in parts]
        rows, count = rows_of_parts([own.said for own in parts], counts)
        placed = [replace(own, rows=each) for own, each in zip(parts, rows, strict=True)]
        whole = (placed, joined_primitives([own.primitives for own in parts], rows, count))
    except ValueError as problem:
        lost = _unfit("its materials are read as meshes of their own", problem)
        warn(f"{file.path}: {lost}")
        return apart
    first = min(n for n, own in enumerate(sheets) if own in parts)
    others = [own if n != first else whole for n, own in enumerate(apart)]
    return [own for n, own in enumerate(others) if n == first or sheets[n] not in parts]


def _read(
    file: GltfFile, shown: tuple[list[Sheet], Primitives], looks: dict[str, Material] | None
) -> ReadMesh:
    """A surface with its morphs, as described or as the file shows them; and what is gone."""
    sheets, primitives = shown
    first: dict[str, Any] = sheets[0].said
    whole = first["whole"] if len(sheets) > 1 else first
    surface: Any = whole.get("surface")
    neutral = _restored(file, primitives, surface, looks) if isinstance(surface, dict) else None
    vertex_of = np.arange(primitives.count, dtype=np.int32)
    if neutral is None:
        neutral = _neutral(file, primitives, looks)
    elif (count := len(neutral.vertices)) < len(vertex_of):  # copies along texture seams follow
        vertex_of[count:] = unpacked(surface["copies"], len(vertex_of) - count)
    straight = tuple(StoredMorph.straight(name) for name in primitives.targets)
    stored = StoredRig(straight, {}, {}, described=False)
    gone = _undescribed(primitives.targets)
    if any(own.stored is not None for own in sheets):
        try:
            each = [
                stored_rig(own.stored, own.primitives.targets, file.budget, own.primitives.given)
                for own in sheets
            ]
            stored, gone = (each[0] if len(each) == 1 else joined_rigs(each, whole)), ""
        except ValueError as problem:
            gone = _unfit("each morph target read as a slider of its own", problem)
    morphs = {morph.name: _morph(neutral, primitives, morph) for morph in stored.morphs}
    name = sheets[0].placed.names[-1 if len(sheets) > 1 else 0]  # that of the mesh, of all
    part = RigPart(name, neutral, morphs, Placing(np.eye(3), np.zeros(3)))
    own = tuple(replace(sheet, rows=vertex_of[sheet.rows]) for sheet in sheets)
    return ReadMesh(part, stored, gone, own)


def named_bends(targets: Sequence[str]) -> list[str]:
    """Those of some targets whose names are those of bends of others."""
    known = set(targets)
    return [name for name in targets if (of := _BEND.fullmatch(name)) and of[1] in known]


def _undescribed(targets: Sequence[str]) -> str:
    """What is to be said of a mesh of targets named as bends are, of which it says nothing."""
    bends = named_bends(targets)
    if not bends:
        return ""
    return (
        f"{len(bends)} of its morph targets have names of bends, such as "
        f"{shortened(bends[0])!r}, and no curves that they follow: each is read as a slider of its "
        "own; if another program has dropped the curves, 'elastomorph bend FILE --from BENT' gives "
        "them back from the bent file"
    )


def _emptied(mesh: ReadMesh, meshes: Sequence[ReadMesh]) -> str:
    """What is to be said of a mesh whose bends do nothing: they are written where they move it.

    Nothing, where they move another that says the same: programs make a mesh of each material.
    """
    first = mesh.sheets[0]
    if len(mesh.sheets) == 1 and is_part(first.stored):
        return ""  # of a material of ours alone, normals may turn where nothing moves
    bends = [target for morph in mesh.stored.morphs for target, _ in morph.bends]
    alike = (s for own in meshes for s in own.sheets if own.sheets[0].stored == first.stored)
    blocks = (block for sheet in alike for block in sheet.primitives.attributes)
    moved = {name for own in blocks for name, by in own.displacements.items() if by.any()}
    empty = [target for target in bends if target not in moved]
    if not empty:
        return ""
    return (
        f"{len(empty)} of {len(bends)} bends, such as {shortened(empty[0])!r}, move nothing: "
        "rounded away or emptied by another program; the paths are straighter there"
    )


def require_known_extensions(file: GltfFile) -> None:
    """Refuse a file that cannot be understood without an extension that is not read."""
    for name in file.items("extensionsRequired"):
        if not isinstance(name, str):
            file.refuse("a required extension has no name")
        if name not in _READ and not name.startswith(_HARMLESS):
            file.refuse(
                f"it cannot be read without the extension {name[:60]}, which is not known here and "
                "may say where vertices are. Export it again without it"
            )


def _restored(
    file: GltfFile,
    primitives: Primitives,
    stored: dict[str, Any],
    looks: dict[str, Material] | None,
) -> Mesh | None:
    """The mesh that `write_glb` described; None, with a warning, where it fits no longer."""
    vertices = primitives.vertices()
    triangles = [own for own in primitives.triangles if len(own)]
    try:
        if len(primitives.attributes) != 1:
            raise ParameterError("another program has split or changed its vertices")
        surface = restored_surface(stored, triangles, vertices, primitives.texture())
    except ValueError as problem:
        lost = _unfit("its polygons are lost, and it is read with triangles for polygons", problem)
        warn(f"{file.path}: {lost}")
        return None
    own, source = vertices[: stored["vertices"]], Source(str(file.path))
    return Mesh(own, **surface, source=source, appearance=looks, copyright=_copyright(file))


def _copyright(file: GltfFile) -> str:
    found = object_of(file.document.get("asset")).get("copyright")
    return found if isinstance(found, str) else ""


def _neutral(file: GltfFile, primitives: Primitives, looks: dict[str, Material] | None) -> Mesh:
    """The mesh as the file shows it."""
    polygons, texture = primitives.polygons(), primitives.texture()
    uv = materials = None
    if texture is not None:
        corners = polygons.indices
        shown = np.asarray(np.isfinite(texture).all(axis=1))
        coordinates = np.where(shown[:, None], texture * [1, -1] + [0, 1], 0.0)
        uv = UVMap(coordinates, np.where(shown[corners], corners, -1).astype(np.int32))
    names = tuple(dict.fromkeys(name for name in primitives.materials if name is not None))
    if names:
        label_of: dict[str | None, int] = {name: label for label, name in enumerate(names)}
        labels = [label_of.get(name, -1) for name in primitives.materials]
        counts = [int(own.sum()) for own in primitives.begins]
        materials = FaceLabels(names, np.repeat(np.array(labels, dtype=np.int32), counts))
    return Mesh(
        primitives.vertices(),
        polygons,
        uv=uv,
        materials=materials,
        source=Source(str(file.path), split=True),
        appearance=looks,
        copyright=_copyright(file),
    )


def _morph(neutral: Mesh, primitives: Primitives, stored: StoredMorph) -> Morph:
    count = len(neutral.vertices)
    if stored.target is None:
        delta = np.zeros((count, 3))
    else:
        delta = primitives.displacement(stored.target)[:count]
    bends = [primitives.displacement(target)[:count] for target, _ in stored.bends]
    curves = [curve for _, curve in stored.bends]
    if stored.fold is not None:  # (t + fold(t)) Δ = tΔ + fold(t) Δ
        bends.append(delta)
        curves.append(stored.fold)
    return Morph(
        neutral,
        neutral.with_vertices(neutral.vertices + delta),
        np.array(bends).reshape(-1, count, 3),
        tuple(curves),
        **stored.more,
    )


def _unfit(instead: str, problem: Exception) -> str:
    return (
        f"what elastomorph stored beside the mesh no longer fits it ({shortened(problem)}); "
        f"{instead}"
    )
