"""Where ``auto`` leads every vertex of a character: computed from the file as it was."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import elastomorph as em
from acceptance.gltf_file import GltfFile
from acceptance.posing import Floats, Scene
from elastomorph.model.geometry import moved_extent
from elastomorph.model.polygons import Polygons
from elastomorph.paths.auto import Auto

_TOGETHER = 1e-6  # of D: vertices of a seam are this close in every shape


@dataclass(frozen=True, eq=False)
class Face:
    """All primitives with targets as one surface, as the skeleton holds them at rest."""

    places: dict[tuple[int, int], slice]  # by node and number of the primitive
    neutral: Floats  # (V, 3)
    targets: dict[str, Floats]  # (V, 3) by name
    triangles: NDArray[np.int64]  # (T, 3)

    @classmethod
    def of(cls, scene: Scene) -> Face:
        """The face of a scene; a mesh that is shown twice counts once."""
        nodes: dict[int, int] = {}
        for node in scene.faces:
            nodes.setdefault(scene.file.nodes[node]["mesh"], node)
        places, start, triangles = {}, 0, []
        whole: list[Floats] = []
        moves: dict[str, list[Floats]] = {
            name: [] for name in dict.fromkeys(n for mesh in nodes for n in scene.names(mesh))
        }
        for mesh, node in nodes.items():
            for surface, held in zip(scene.surfaces(node), scene.matrices(node), strict=True):
                place = slice(start, start + len(surface.positions))
                places[node, surface.number[1]] = place
                start = place.stop
                linear, shift = held[..., :3], held[..., 3]
                faces = corners(scene.file, *surface.number) + place.start
                # What a node mirrors has its front on the other side.
                mirrored = np.median(np.linalg.det(linear)) < 0
                triangles.append(faces[:, ::-1] if mirrored else faces)
                whole.append(np.einsum("...ij,...j->...i", linear, surface.positions) + shift)
                of_name = dict(zip(scene.names(mesh), surface.targets, strict=False))
                for name, parts in moves.items():
                    moved = of_name.get(name, np.zeros_like(surface.positions))
                    parts.append(np.einsum("...ij,...j->...i", linear, moved))
        neutral = np.concatenate(whole)
        targets = {name: neutral + np.concatenate(parts) for name, parts in moves.items()}
        return cls(places, neutral, targets, np.concatenate(triangles))

    def in_numbers_of(self, rig: em.Rig) -> Face:
        """The same face with the numbers of a rig that was read, which are within rounding.

        Where a surface is folded to nothing in the neutral, paths notice a ten-millionth.
        """
        shared = [name for name in self.targets if name in rig.morphs]
        far = (
            rig.neutral.vertices[:, None],
            *(rig.morphs[name].target.vertices[:, None] for name in shared),
        )
        near = self.neutral[:, None], *(self.targets[name][:, None] for name in shared)
        theirs, ours = (np.concatenate(own, axis=1).reshape(len(own[0]), -1) for own in (far, near))
        # A few mixed coordinates tell vertices apart as well as all of them do.
        mixed = np.random.default_rng(0).normal(size=(theirs.shape[1], 6))
        away, at = cKDTree(theirs @ mixed).query(ours @ mixed)
        assert away.max() < 1e-4 * (self.extent or 1.0) * len(shared)
        targets = {
            name: rig.morphs[name].target.vertices[at] if name in shared else own
            for name, own in self.targets.items()
        }
        return replace(self, neutral=rig.neutral.vertices[at], targets=targets)

    def shaken(self) -> Face:
        """The same face a hundred-millionth larger, its triangles in another order.

        A sound path is the same. Of a target that folds a surface onto itself, turns are arbitrary.
        """
        scale = 1 + 1e-8
        targets = {name: own * scale for name, own in self.targets.items()}
        order = np.random.default_rng(1).permutation(len(self.triangles))
        return replace(
            self, neutral=self.neutral * scale, targets=targets, triangles=self.triangles[order]
        )

    @cached_property
    def extent(self) -> float:
        """D: the largest distance between two vertices that a target moves."""
        return moved_extent(self.neutral, self.targets.values())

    @cached_property
    def welded(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """(W,) a vertex of each place, and (V,) the place of each vertex."""
        near = _TOGETHER * (self.extent or 1.0)
        pairs = cKDTree(self.neutral).query_pairs(near, output_type="ndarray")
        for target in self.targets.values():
            apart = np.linalg.norm(target[pairs[:, 0]] - target[pairs[:, 1]], axis=1)
            pairs = pairs[apart <= 2 * near]
        count = len(self.neutral)
        graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (count, count))
        _, label = connected_components(graph, directed=False)
        _, first, place = np.unique(label, return_index=True, return_inverse=True)
        return first, place.reshape(-1)

    @cached_property
    def _moving(self) -> NDArray[np.bool_]:
        """(W,) whether a place belongs to a connected part that a target moves."""
        first, place = self.welded
        faces, count = place[self.triangles], len(first)
        ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
        graph = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), (count, count))
        _, part = connected_components(graph, directed=False)
        moved = np.zeros(count, dtype=bool)
        for target in self.targets.values():
            moved |= (target != self.neutral).any(axis=1)[first]
        return np.isin(part, part[moved])

    def paths(self, names: list[str]) -> dict[str, em.Morph]:
        """The path of some targets on the welded surface, of its connected parts that move.

        They are held within the default tolerance, as a fraction of D rather than of the diameter
        of what they are computed on. Where polygons would turn over, the path depends on it.
        """
        first, place = self.welded
        faces = place[self.triangles]
        proper = (faces != np.roll(faces, 1, axis=1)).all(axis=1) & self._moving[faces[:, 0]]
        kept = np.flatnonzero(self._moving)
        number = np.full(len(first), -1)
        number[kept] = np.arange(len(kept))
        polygons = Polygons.of(number[faces[proper]].astype(np.int32))
        mesh = em.Mesh(self.neutral[first[kept]], polygons)
        own = Auto()
        whole = mesh.diameter or 1.0
        part = (self.extent or whole) / whole
        to = em.prepare(
            mesh, replace(own, tolerance=own.tolerance * part), extent=self.extent or None
        )
        ends = {name: self.targets[name][first[kept]] for name in names}
        return {name: to(mesh.with_vertices(end)) for name, end in ends.items()}

    def at(self, path: em.Morph, t: float) -> Floats:
        """(V, 3) of all primitives at a weight of a path."""
        first, place = self.welded
        found = self.neutral[first].copy()
        found[self._moving] = path.at(np.array([t]))[0]
        return np.asarray(found[place])


def corners(file: GltfFile, mesh: int, number: int) -> NDArray[np.int64]:
    """(T, 3) the triangles of a primitive."""
    primitive = file.meshes[mesh]["primitives"][number]
    count = file.accessors[primitive["attributes"]["POSITION"]]["count"]
    if "indices" not in primitive:
        return np.arange(count).reshape(-1, 3)
    assert primitive.get("mode", 4) == 4
    return file.array(primitive["indices"]).astype(np.int64).reshape(-1, 3)
