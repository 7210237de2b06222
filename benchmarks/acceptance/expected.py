"""Where ``auto`` leads every vertex of a character: computed from the file as it was."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import elastomorph as em
from acceptance.gltf_file import GltfFile
from acceptance.posing import Floats, Pose, Scene
from elastomorph.model.geometry import moved_extent
from elastomorph.model.polygons import Polygons

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
        rest = scene.posed(Pose(weights={n: np.zeros(scene.count(n)) for n in scene.faces}))
        places, start, triangles = {}, 0, []
        for node in nodes.values():
            for surface in scene.surfaces(node):
                key = (node, surface.number[1])
                places[key] = slice(start, start + len(surface.positions))
                triangles.append(corners(scene.file, *surface.number) + start)
                start = places[key].stop
        neutral = np.concatenate([rest[key] for key in places])
        names = [name for mesh in nodes for name in scene.names(mesh)]
        targets = {}
        for name in dict.fromkeys(names):
            weights = {
                node: np.array([float(own == name) for own in scene.names(mesh)])
                for mesh, node in nodes.items()
            }
            full = scene.posed(Pose(weights=weights))
            targets[name] = np.concatenate([full[key] for key in places])
        return cls(places, neutral, targets, np.concatenate(triangles))

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

    def paths(self, names: list[str], method: str = "auto") -> dict[str, em.Morph]:
        """The path of some targets on the welded surface."""
        first, place = self.welded
        faces = place[self.triangles]
        proper = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
        mesh = em.Mesh(self.neutral[first], Polygons.of(faces[proper].astype(np.int32)))
        to = em.prepare(mesh, method, extent=self.extent or None)
        return {name: to(mesh.with_vertices(self.targets[name][first])) for name in names}

    def at(self, path: em.Morph, t: float) -> Floats:
        """(V, 3) of all primitives at a weight of a path."""
        return np.asarray(path.at(np.array([t]))[0][self.welded[1]])


def corners(file: GltfFile, mesh: int, number: int) -> NDArray[np.int64]:
    """(T, 3) the triangles of a primitive."""
    primitive = file.meshes[mesh]["primitives"][number]
    count = file.accessors[primitive["attributes"]["POSITION"]]["count"]
    if "indices" not in primitive:
        return np.arange(count).reshape(-1, 3)
    assert primitive.get("mode", 4) == 4
    return file.array(primitive["indices"]).astype(np.int64).reshape(-1, 3)
