"""Reads a rig from .glb and .gltf files: our own as they were, others as they are."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ElastomorphWarning, ParameterError
from elastomorph.io.gltf.container import GltfFile, open_gltf
from elastomorph.io.gltf.rig_extras import StoredMorph, StoredRig, stored_rig
from elastomorph.io.gltf.scene import PlacedMesh, placed_meshes
from elastomorph.io.gltf.scene_surface import SceneSurface
from elastomorph.io.gltf.surface_extras import restored_surface
from elastomorph.io.gltf.surfaces import read_surfaces, shape_count
from elastomorph.io.joined_rig import RigPart, joined_rig
from elastomorph.io.mesh_choice import ListedMesh, chosen_meshes, wanted_names
from elastomorph.io.placing import Placing
from elastomorph.io.untrusted import naming_file, shortened
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons
from elastomorph.rig import Rig

__all__ = ["read_glb"]

_HARMLESS = (
    *("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "MSFT_texture_"),
    *("VRM", "KHR_xmp", "KHR_node_visibility", "KHR_animation_pointer"),
)
_READ = ("KHR_mesh_quantization",)


def read_glb(path: str | Path, *, mesh: str | Sequence[str] | None = None) -> Rig:
    """The rig in a .glb, .gltf or .vrm file.

    A file of `write_glb` comes back with its polygons, vertex order, texture coordinates, labels,
    bends and bend curves; positions in single precision. If another program has changed it so
    that these no longer fit, a warning says so and it is read as any other file:

    - All meshes of the scene become one, in the order of the scene and placed by their nodes; one
      with a skin by its joints, in the pose it was bound in.
      Vertices are neither merged nor reordered; triangles stay triangles.
    - Morph targets of the same name in several meshes are one morph, on a straight path; a mesh
      without any is part of the neutral. Targets without names are called ``target_0`` and so on.
    - Materials become material labels; nodes become group labels where several have a mesh.
    - Skins, animations, default weights and textures are passed over.

    Args:
        path: The file. Buffers in other files are read only from its own folder.
        mesh: Name of the mesh to read, or names of several: of its node or its own.

    Raises:
        FileError: A file is missing or cannot be read.
        FormatError: It is damaged, compressed, needs an extension that is not read, or has no mesh
            of a name.
        ParameterError: An empty list of names.
    """
    wanted = wanted_names(mesh)
    file = open_gltf(path)
    _require_extensions(file)
    with naming_file(path), np.errstate(all="ignore"):
        placed = _chosen(file, wanted)
        parts = [
            _part(file, own, surface)
            for own, surface in zip(placed, read_surfaces(file, placed), strict=True)
            if surface is not None
        ]
        neutral, morphs = joined_rig([part for part, _ in parts], str(path))
        return Rig(
            neutral,
            morphs,
            correctives=_merged(stored.correctives for _, stored in parts),
            groups=_merged(stored.groups for _, stored in parts),
        )


def _chosen(file: GltfFile, wanted: Sequence[str]) -> list[PlacedMesh]:
    placed = placed_meshes(file)
    if not wanted:
        return placed
    listed = [ListedMesh(own.names, shape_count(file, own)) for own in placed]
    try:
        return [placed[number] for number in chosen_meshes(listed, wanted)]
    except ParameterError as problem:
        file.refuse(str(problem))


def _part(file: GltfFile, placed: PlacedMesh, surface: SceneSurface) -> tuple[RigPart, StoredRig]:
    """A mesh with its morphs, as `write_glb` described them or as the file shows them."""
    extras = file.item("meshes", placed.number, "a node").get("extras")
    own = extras.get("elastomorph") if isinstance(extras, dict) else None
    neutral = _neutral(file, surface, own)
    stored = _description(file, surface, own)
    morphs = {morph.name: _morph(neutral, surface, morph) for morph in stored.morphs}
    return RigPart(placed.names[0], neutral, morphs, Placing(np.eye(3), np.zeros(3))), stored


def _merged(kinds: Iterable[dict[str, list[str]]]) -> dict[str, list[str]]:
    return {name: members for own in kinds for name, members in own.items()}


def _require_extensions(file: GltfFile) -> None:
    for name in file.items("extensionsRequired"):
        if not isinstance(name, str):
            file.refuse("a required extension has no name")
        if "draco" in name.lower() or "meshopt" in name.lower():
            file.refuse(
                f"it is compressed ({name[:60]}), which is not read. Export it again without "
                "compression"
            )
        if name not in _READ and not name.startswith(_HARMLESS):
            file.refuse(
                f"it cannot be read without the extension {name[:60]}. Export it again without it"
            )


def _neutral(file: GltfFile, surface: SceneSurface, extras: Any) -> Mesh:
    vertices, texture = surface.vertices(), surface.texture()
    source = Source(str(file.path))
    stored = extras.get("surface") if isinstance(extras, dict) else None
    if isinstance(stored, dict):
        parts = [piece.triangles for piece in surface.pieces if len(piece.triangles)]
        try:
            if len(surface.sheets) != 1:
                raise ParameterError("another program has split or changed its vertices")
            own = restored_surface(stored, parts, vertices, texture)
        except ValueError as problem:
            _warn(
                file, "its polygons are lost, and it is read with triangles for polygons", problem
            )
        else:
            return Mesh(vertices[: stored["vertices"]], **own, source=source)
    corners = np.concatenate([piece.triangles for piece in surface.pieces])
    return Mesh(
        vertices,
        Polygons.of(corners),
        uv=_uv(texture, corners),
        materials=_materials(surface),
        source=source,
    )


def _uv(texture: NDArray[np.float64] | None, triangles: NDArray[np.int32]) -> UVMap | None:
    if texture is None:
        return None
    corners = triangles.reshape(-1)
    shown = np.asarray(np.isfinite(texture).all(axis=1))
    coordinates = np.where(shown[:, None], texture * [1, -1] + [0, 1], 0.0)
    return UVMap(coordinates, np.where(shown[corners], corners, -1).astype(np.int32))


def _materials(surface: SceneSurface) -> FaceLabels | None:
    labels = [piece.material for piece in surface.pieces]
    names = tuple(dict.fromkeys(label for label in labels if label is not None))
    if not names:
        return None
    place_of = {name: place for place, name in enumerate(names)}
    places = [-1 if label is None else place_of[label] for label in labels]
    counts = [len(piece.triangles) for piece in surface.pieces]
    return FaceLabels(names, np.repeat(np.array(places, dtype=np.int32), counts))


def _description(file: GltfFile, surface: SceneSurface, extras: Any) -> StoredRig:
    """The morphs, as the file describes them or as its morph targets are."""
    if extras is not None:
        try:
            return stored_rig(extras, surface.targets, file.budget)
        except ValueError as problem:
            _warn(file, "each morph target read as a slider of its own", problem)
    return StoredRig(tuple(StoredMorph.straight(name) for name in surface.targets), {}, {})


def _morph(neutral: Mesh, surface: SceneSurface, stored: StoredMorph) -> Morph:
    count = len(neutral.vertices)
    delta = surface.displacement(stored.target)[:count]
    bends = [surface.displacement(target)[:count] for target, _ in stored.bends]
    return Morph(
        neutral,
        neutral.with_vertices(neutral.vertices + delta),
        np.stack(bends) if bends else np.zeros((0, count, 3)),
        tuple(curve for _, curve in stored.bends),
        method=stored.method,
        limit_law=stored.limit_law,
        bake_error=stored.bake_error,
        choice=stored.choice,
        bare=stored.bare,
    )


def _warn(file: GltfFile, instead: str, problem: Exception) -> None:
    warnings.warn(
        f"{file.path}: what elastomorph stored beside the mesh no longer fits it "
        f"({shortened(problem)}); {instead}",
        ElastomorphWarning,
        stacklevel=6,
    )
