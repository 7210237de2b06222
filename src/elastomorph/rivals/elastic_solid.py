"""``elastic-solid``: the flesh of a head as an elastic solid between a jaw that turns and a skull.

Stands for Hahn and others, *Rig-Space Physics* (2012), Kozlov and others, *Enhancing Facial
Blendshape Rigs with Physical Simulation* (2017), and Ichim and others, *Phace* (2017), the paper's
[17], [19] and [20]: tetrahedra inside the head, linear finite elements (scikit-fem), equilibrium at
each moment. The paper quotes two minutes a face of 8,098 tetrahedron vertices for [20].

    E(x) = Σ_e ∫ μ |ε|² + λ/2 tr(ε)²,        ε = sym(Rᵀ∇x) - I

R = 1 everywhere is linear elasticity, which swells when it turns; corotational elasticity has the
nearest rotation to ∇x for each tetrahedron, found in turns with x: stiffness warping after Müller
and Gross, *Interactive Virtual Materials* (2004), K = Σ_e R Kₑ Rᵀ.

Ours, where the sources leave it open. The tetrahedra are a lattice that the skin rides on
(`Lattice`): body-centred cubic, the corners and centres of cubes, with four tetrahedra about each
face that two cubes share, all of one shape. Those stay that have a node inside the surface or a
vertex of it; the surface is not meshed, it is carried. Holes (a neck, the sockets of eyes) are
closed by a cone to the middle of their rim.

Parts that turn rigidly (lower teeth, tongue) are the jaw, and lie on their screw; what both ends
have at the same place is still. A node is bone if it is deeper below the skin than `depth`, or
within a cell of a jaw's part. It is of the jaw if such a part is nearer than anything that is
still, and no farther than `depth`: what is behind the throat is nearer to the tongue than to still
skin, yet of the neck, and would be turned into it. All other bone is of the skull; a node whose
skin is all still is still. The skin is free. What this leaves of the target (a smile is no work of
bones) is added in proportion to t, so that both ends are exact. A tetrahedron that the target
stretches more than `torn` times spans the open mouth: it is softened a thousandfold.

``deformation-gradients``: rotation and stretch of every triangle interpolated, then one solve.

After Roh, Kim, Jang, Seol and Kim, *Interactive Facial Expression Editing with Non-linear
Blendshape Interpolation* (Eurographics 2022), the paper's [15], who interpolate the deformation
gradients of blendshapes; the gradients and the solve are those of Sumner and Popović, *Deformation
Transfer for Triangle Meshes* (ACM Trans. Graph. 23, 2004). The affine map of a triangle with its
normal is F = R S, a rotation and a symmetric stretch. On the way

    F(t) = exp(t log R) (I + t (S - I)),        x(t) = argmin Σ_T area_T ‖∇x - F_T(t)‖²

The normal equations are Poisson's with the cotangent Laplacian of the neutral, factored once.

Ours, where the sources leave it open: a polygon counts as all its shortest fans of triangles
(`triangulate`), one without area not at all; vertices that both ends have at the same place stay
there; where a connected part has none, its centre (mean of vertices) moves straight.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import MeshError, ParameterError
from elastomorph.evaluation.rigid_bodies import RigidParts, find_rigid_parts
from elastomorph.model.cholesky import symmetric_factor
from elastomorph.model.geometry import component_of, connected_parts, sides_of
from elastomorph.model.mesh import Mesh, part_of
from elastomorph.model.sequence import MeshSequence
from elastomorph.model.surface import triangulate
from elastomorph.rivals.rival import Faces, Rival, straight

# Triangles whose area is below this part of D² have no direction that could turn.
_FLAT = 1e-14


@dataclass(frozen=True)
class DeformationGradients(Rival):
    """Rotation and stretch of every triangle interpolated, then a Poisson solve."""

    name = "deformation-gradients"
    source = "Roh and others 2022, [15]; Sumner and Popović 2004"
    on_surfaces = True

    def faces(
        self, recording: MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        """The face at each time."""
        from scipy.spatial.transform import Rotation

        start, end = recording.frames
        triangles, shares = triangulate(recording.mesh)
        real = _doubled_areas(start[triangles]) > _FLAT * recording.mesh.diameter**2
        triangles, shares = triangles[real], shares[real]
        turns, stretches = polar(_frames(end[triangles]) @ np.linalg.inv(_frames(start[triangles])))
        logs = Rotation.from_matrix(turns).as_rotvec()
        poisson = _Poisson.of(recording, triangles, shares)
        for time in times:
            part = np.eye(3) + time * (stretches - np.eye(3))
            gradients = Rotation.from_rotvec(time * logs).as_matrix() @ part
            yield poisson.solved(gradients, straight(recording, float(time)))


@dataclass(frozen=True, eq=False)
class _Poisson:
    """What finds the vertices whose gradients come nearest to wanted ones."""

    triangles: NDArray[np.int32]  # (T, 3)
    slopes: NDArray[np.float64]  # (T, 3, 3) of each corner's hat function, times the area
    laplacian: Any  # (V, V) of the neutral, sparse
    held: NDArray[np.bool_]  # (V,) vertices that stay; of a part without any, one that is moved on
    part_of: NDArray[np.int32]  # (V,)
    floating: NDArray[np.bool_]  # (P,) whether nothing of a part stays
    factor: Any

    @classmethod
    def of(
        cls,
        recording: MeshSequence,
        triangles: NDArray[np.int32],
        shares: NDArray[np.float64],
    ) -> _Poisson:
        """Factor the Laplacian of the first frame."""
        from scipy.sparse import coo_array, csc_array

        start, end = recording.frames
        count = len(start)
        slopes, areas = _slopes(start[triangles])
        weights = np.einsum("t,tix,tjx->tij", shares * areas, slopes, slopes)
        rows = np.broadcast_to(triangles[:, :, None], weights.shape).ravel()
        columns = np.broadcast_to(triangles[:, None, :], weights.shape).ravel()
        laplacian = csc_array(coo_array((weights.ravel(), (rows, columns)), shape=(count, count)))
        part_of = component_of(count, sides_of(triangles))
        held = (start == end).all(axis=1)
        floating = np.bincount(part_of, held) == 0
        held[np.unique(part_of, return_index=True)[1][floating]] = True
        free = csc_array(laplacian[~held][:, ~held])
        factor = symmetric_factor(free) if free.shape[0] else None
        scaled = (shares * areas)[:, None, None] * slopes
        return cls(triangles, scaled, laplacian, held, part_of, floating, factor)

    def solved(
        self, gradients: NDArray[np.float64], placed: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(V, 3) the vertices of (T, 3, 3) gradients; floating parts have the centres of others."""
        found = placed.copy()
        if self.factor is None:
            return found
        pulls = np.einsum("txy,tiy->tix", gradients, self.slopes)
        wanted = np.stack(
            [
                np.bincount(self.triangles.ravel(), axis.ravel(), minlength=len(placed))
                for axis in np.moveaxis(pulls, 2, 0)
            ],
            axis=1,
        )
        free = ~self.held
        known = self.laplacian[free][:, self.held] @ placed[self.held]
        found[free] = self.factor.solve(np.ascontiguousarray(wanted[free] - known))
        off = part_means(placed - found, self.part_of)
        off[~self.floating] = 0.0
        return found + off[self.part_of]


def part_means(vectors: NDArray[np.float64], part_of: NDArray[np.int32]) -> NDArray[np.float64]:
    """(P, 3) means of (V, 3) vectors over the parts of a mesh."""
    sums = [np.bincount(part_of, axis) for axis in vectors.T]
    return np.stack(sums, axis=1) / np.bincount(part_of)[:, None]


def _doubled_areas(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    sides = corners[:, 1:] - corners[:, :1]
    return np.asarray(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1))


def _frames(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 3, 3) two sides and the normal of (T, 3, 3) triangles, as columns.

    The normal has the length of a side, so that it stretches as the triangle does.
    """
    sides = corners[:, 1:] - corners[:, :1]
    normal = np.cross(sides[:, 0], sides[:, 1])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, np.sqrt(size), out=np.zeros_like(normal), where=size > 0)
    return np.stack([sides[:, 0], sides[:, 1], normal], axis=2)


def _slopes(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(T, 3, 3) gradient of the hat function of each corner, and (T,) areas."""
    opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    normal = np.cross(opposite[:, 0], opposite[:, 1])
    doubled = np.linalg.norm(normal, axis=1)
    slopes = np.cross(normal[:, None], opposite) / (doubled**2)[:, None, None]
    return slopes, 0.5 * doubled


def polar(
    matrices: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N, 3, 3) F = R S: the nearest rotations R and the symmetric S that are left of them."""
    left, sizes, right = np.linalg.svd(matrices)
    mirrored = np.linalg.det(left) * np.linalg.det(right) < 0
    sizes[mirrored, -1] *= -1.0
    left[mirrored, :, -1] *= -1.0
    turns = left @ right
    return turns, np.einsum("nki,nk,nkj->nij", right, sizes, right)


# The lattice lies askew of the axes' origin, so that no line of it runs along an edge.
_ASKEW = np.sqrt([2.0, 3.0, 5.0]) % 1.0
# Less of a solid than this share of the box around it is a sheet.
_LEAST_SOLID = 1e-3
_AROUND = ((0, 0), (1, 0), (1, 1), (0, 1))


@dataclass(frozen=True, eq=False)
class Closed:
    """A closed surface: triangles, each counting in part."""

    points: NDArray[np.float64]  # (P, 3)
    triangles: NDArray[np.int64]  # (T, 3), counter-clockwise from outside
    shares: NDArray[np.float64]  # (T,)

    @property
    def volume(self) -> float:
        """What is inside."""
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        return float((np.einsum("ti,ti->t", a, np.cross(b, c)) * self.shares).sum()) / 6.0

    @classmethod
    def of(cls, mesh: Mesh) -> Closed:
        """A mesh with its holes closed; of one connected part.

        Raises:
            MeshError: It has no inside.
        """
        triangles, shares = triangulate(mesh)
        corners = triangles.astype(np.int64)
        ends = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
        weights = np.tile(shares, 3) * np.where(ends[:, 0] < ends[:, 1], 1.0, -1.0)
        edges, place = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
        net = np.bincount(place.ravel(), weights)
        open_edges = np.abs(net) > 1e-6
        rim = np.where((net > 0)[:, None], edges[:, ::-1], edges)[open_edges]
        points, caps = _cones(mesh.vertices, rim)
        found = cls(
            points,
            np.concatenate([corners, caps]),
            np.concatenate([shares, np.abs(net[open_edges])]),
        )
        if found.volume < 0:
            found = cls(points, found.triangles[:, ::-1], found.shares)
        box = float(np.ptp(points, axis=0).prod())
        if not found.volume > _LEAST_SOLID * box:
            raise MeshError("it needs a closed body, and this surface has next to nothing inside")
        return found

    def inside(
        self, x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """(X, Y, Z) whether the points of a grid are inside: how often lines along x cross."""
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        low = np.minimum(np.minimum(a, b), c)
        high = np.maximum(np.maximum(a, b), c)
        first = np.stack([np.searchsorted(own, low[:, i]) for i, own in ((1, y), (2, z))], axis=1)
        last = np.stack([np.searchsorted(own, high[:, i]) for i, own in ((1, y), (2, z))], axis=1)
        spans = last - first
        counts = spans.prod(axis=1)
        triangle = np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(triangle)) - np.repeat(np.cumsum(counts) - counts, counts)
        j = first[triangle, 0] + number // np.maximum(spans[triangle, 1], 1)
        k = first[triangle, 1] + number % np.maximum(spans[triangle, 1], 1)
        line = np.stack([y[j], z[k]], axis=1)
        corners = (a[triangle], b[triangle], c[triangle])
        # Twice the areas that the line makes with the sides, across x.
        areas = np.stack(
            [
                _crossed(corners[(i + 1) % 3][:, 1:] - line, corners[(i + 2) % 3][:, 1:] - line)
                for i in range(3)
            ],
            axis=1,
        )
        whole = areas.sum(axis=1)
        hit = ((areas > 0).all(axis=1) | (areas < 0).all(axis=1)) & (whole != 0)
        areas, whole, triangle = areas[hit], whole[hit], triangle[hit]
        at = sum(areas[:, i] * corners[i][hit, 0] for i in range(3)) / whole
        winding = np.zeros((len(y), len(z), len(x)))
        turns = np.sign(whole) * self.shares[triangle]
        np.add.at(winding, (j[hit], k[hit]), turns[:, None] * (x < np.asarray(at)[:, None]))
        return np.moveaxis(winding > 0.5, 2, 0)


@dataclass(frozen=True, eq=False)
class Lattice:
    """Tetrahedra and the points that ride on them."""

    nodes: NDArray[np.float64]  # (N, 3)
    tetrahedra: NDArray[np.int64]  # (K, 4), positive volume
    carrier: NDArray[np.int64]  # (P,) the tetrahedron of each point; -1 where it is in none
    shares: NDArray[np.float64]  # (P, 4) its barycentric coordinates

    @classmethod
    def inside(
        cls, surface: Closed, skin: NDArray[np.float64], riders: NDArray[np.float64], count: int
    ) -> Lattice:
        """About so many nodes within a surface and about (S, 3) points of it; (P, 3) ride along."""
        step = (2.0 * surface.volume / count) ** (1.0 / 3.0)
        low = surface.points.min(axis=0) - (2.0 + _ASKEW) * step
        shape = np.ceil(np.ptp(surface.points, axis=0) / step).astype(int) + 6
        corners = [low[i] + step * np.arange(shape[i]) for i in range(3)]
        centres = [own[:-1] + step / 2 for own in corners]
        is_in = np.concatenate([surface.inside(*own).ravel() for own in (corners, centres)])
        nodes = np.concatenate(
            [
                np.stack(np.meshgrid(*own, indexing="ij"), 3).reshape(-1, 3)
                for own in (corners, centres)
            ]
        )
        tetrahedra = _tetrahedra(tuple(int(n) for n in shape))
        kept = np.asarray(is_in[tetrahedra].any(axis=1))
        kept[_located(nodes, tetrahedra, skin)[0]] = True
        # What hangs on an edge alone would swing about it: with it all that its nodes span.
        touched = np.zeros(len(nodes), dtype=bool)
        touched[tetrahedra[kept]] = True
        kept |= touched[tetrahedra].all(axis=1)
        used = np.flatnonzero(touched)
        renamed = np.searchsorted(used, tetrahedra[kept])
        carrier, shares = _located(nodes, tetrahedra, riders)
        place = np.where(kept, np.cumsum(kept) - 1, -1)
        return cls(nodes[used], renamed, np.where(carrier >= 0, place[carrier], -1), shares)

    def carried(self, nodes: NDArray[np.float64]) -> NDArray[np.float64]:
        """(P, 3) the riders where the nodes are elsewhere; meaningless for those in none."""
        corners = nodes[self.tetrahedra[self.carrier]]
        return np.asarray(np.einsum("pc,pci->pi", self.shares, corners))


def _cones(
    points: NDArray[np.float64], rim: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The points with the middles of all rims behind them, and triangles from rims to middles."""
    from elastomorph.model.geometry import component_of

    if not len(rim):
        return points, np.zeros((0, 3), dtype=np.int64)
    own, place = np.unique(rim, return_inverse=True)
    rim_of = component_of(len(own), place.reshape(-1, 2))
    sums = np.stack([np.bincount(rim_of, axis) for axis in points[own].T], axis=1)
    middles = sums / np.bincount(rim_of)[:, None]
    apex = len(points) + rim_of[place.reshape(-1, 2)[:, 0]]
    return np.concatenate([points, middles]), np.column_stack([rim, apex])


def _crossed(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


def _tetrahedra(shape: tuple[int, ...]) -> NDArray[np.int64]:
    """(K, 4) of a lattice of so many corners along each axis; centres are numbered behind them."""
    corner = np.arange(np.prod(shape)).reshape(shape)
    cubes = tuple(n - 1 for n in shape)
    centre = corner.size + np.arange(np.prod(cubes)).reshape(cubes)
    found = []
    for axis in range(3):
        others = [i for i in range(3) if i != axis]
        one, other = (np.take(centre, np.arange(s, cubes[axis] - 1 + s), axis) for s in (0, 1))
        ring = []
        for offsets in _AROUND:
            part = np.take(corner, np.arange(1, cubes[axis]), axis)
            for i, offset in zip(others, offsets, strict=True):
                part = np.take(part, np.arange(offset, cubes[i] + offset), i)
            ring.append(part)
        # Seen along y the two other axes turn the other way round.
        ends = (one, other) if axis != 1 else (other, one)
        for i in range(4):
            found.append(
                np.stack([ends[0], ring[i], ring[(i + 1) % 4], ends[1]], -1).reshape(-1, 4)
            )
    return np.concatenate(found)


def _located(
    nodes: NDArray[np.float64], tetrahedra: NDArray[np.int64], points: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(P,) the tetrahedron each point is in, and (P, 4) its barycentric coordinates there."""
    from scipy.spatial import cKDTree

    near = 12
    found = cKDTree(nodes[tetrahedra].mean(axis=1)).query(points, k=near)[1]
    candidates: NDArray[np.int64] = np.asarray(found)
    corners = nodes[tetrahedra[candidates]]
    sides = np.swapaxes(corners[:, :, 1:] - corners[:, :, :1], 2, 3)
    rest = np.linalg.solve(sides, (points[:, None] - corners[:, :, 0])[..., None])[..., 0]
    shares = np.concatenate([1.0 - rest.sum(axis=2, keepdims=True), rest], axis=2)
    best = shares.min(axis=2).argmax(axis=1)
    own = np.arange(len(points))
    within = shares[own, best].min(axis=1) > -1e-9
    return np.where(within, candidates[own, best], -1), shares[own, best]


# More do not help where flesh is folded between the jaw and the neck.
_MOST_TURNS = 12


@dataclass(frozen=True, eq=False)
class Pattern:
    """Where the blocks of all tetrahedra go in a sparse matrix, found once."""

    order: NDArray[np.int64]  # (16 K,) blocks sorted by row and column
    starts: NDArray[np.int64]  # (B,) where in it each block of the matrix starts
    rows: NDArray[np.int64]  # (N + 1,) where the blocks of each node's row start
    columns: NDArray[np.int64]  # (B,) the node of each block's column

    @classmethod
    def of(cls, tetrahedra: NDArray[np.int64], count: int) -> Pattern:
        """The pattern of so many nodes."""
        pairs = (tetrahedra[:, :, None] * count + tetrahedra[:, None]).ravel()
        order = np.argsort(pairs, kind="stable")
        blocks, starts = np.unique(pairs[order], return_index=True)
        rows = np.searchsorted(blocks, count * np.arange(count + 1))
        return cls(order, starts, rows, blocks % count)

    def summed(self, blocks: NDArray[np.float64]) -> Any:
        """(3 N, 3 N) the sum of (K, 4, 4, 3, 3) blocks."""
        from scipy.sparse import bsr_array

        values = np.add.reduceat(blocks.reshape(-1, 9)[self.order], self.starts, axis=0)
        count = 3 * (len(self.rows) - 1)
        parts = (values.reshape(-1, 3, 3), self.columns, self.rows)
        return bsr_array(parts, shape=(count, count)).tocsr()


@dataclass(frozen=True, eq=False)
class Solid:
    """Tetrahedra with the stiffness of each, to be warped and summed."""

    lattice: Lattice
    inverse: NDArray[np.float64]  # (K, 3, 3) of the sides at rest, as columns
    stiffness: NDArray[np.float64]  # (K, 4, 3, 4, 3)
    pattern: Pattern

    @classmethod
    def of(cls, lattice: Lattice, poisson: float, youngs: NDArray[np.float64]) -> Solid:
        """The stiffness of every tetrahedron, by scikit-fem, for (K,) Young's moduli."""
        from skfem import Basis, ElementTetP1, ElementVector, MeshTet
        from skfem.models.elasticity import lame_parameters, linear_elasticity

        mesh = MeshTet(lattice.nodes.T.copy(), lattice.tetrahedra.T.copy(), sort_t=False)
        basis = Basis(mesh, ElementVector(ElementTetP1()), intorder=1)
        form = linear_elasticity(*lame_parameters(1.0, poisson))
        local = form.coo_data(basis).tolocal()
        sides = _sides(lattice.nodes, lattice.tetrahedra)
        local *= youngs[:, None, None]
        stiffness = local.reshape(-1, 4, 3, 4, 3)
        pattern = Pattern.of(lattice.tetrahedra, len(lattice.nodes))
        return cls(lattice, np.asarray(np.linalg.inv(sides)), stiffness, pattern)

    def turns(self, nodes: NDArray[np.float64]) -> NDArray[np.float64]:
        """(K, 3, 3) the nearest rotation to the gradient of each tetrahedron."""
        return polar(_sides(nodes, self.lattice.tetrahedra) @ self.inverse)[0]

    def linear(self, bones: NDArray[np.float64], bone: NDArray[np.bool_]) -> NDArray[np.float64]:
        """(N, 3) the equilibrium of linear elasticity for given bones."""
        still = np.tile(np.eye(3), (len(self.inverse), 1, 1))
        return self._solved(still, self.lattice.nodes, bones, bone)

    def settled(
        self,
        nodes: NDArray[np.float64],
        bones: NDArray[np.float64],
        bone: NDArray[np.bool_],
        smallest: float,
    ) -> NDArray[np.float64]:
        """(N, 3) the corotational equilibrium for given bones, found from nodes near it."""
        # The turns of before: bones that have moved alone fold the flesh beside them.
        nodes = self._solved(self.turns(nodes), nodes, bones, bone)
        part, before = 1.0, np.inf
        for _ in range(_MOST_TURNS):
            step = self._solved(self.turns(nodes), nodes, bones, bone) - nodes
            moved = float(np.abs(step).max())
            nodes += part * step
            if moved < smallest:
                break
            # Where flesh folds, turns and places may chase each other in a circle.
            part, before = (part if moved < before else max(0.7 * part, 0.3)), moved
        return nodes

    def _solved(
        self,
        turns: NDArray[np.float64],
        guess: NDArray[np.float64],
        bones: NDArray[np.float64],
        bone: NDArray[np.bool_],
    ) -> NDArray[np.float64]:
        """(N, 3) where the forces on all nodes but bones vanish, for given rotations."""
        from scipy.sparse import diags_array
        from scipy.sparse.linalg import cg

        own = self.lattice.tetrahedra
        half = np.einsum("kij,kajbl->kaibl", turns, self.stiffness)
        pulls = np.einsum("kaibl,kbl->kai", half, self.lattice.nodes[own])
        matrix = self.pattern.summed(np.einsum("kaibl,kml->kabim", half, turns))
        slots = 3 * own[:, :, None] + np.arange(3)
        force = np.bincount(slots.ravel(), pulls.ravel(), minlength=guess.size)
        given = np.repeat(bone, 3)
        free = matrix[~given]
        known = force[~given] - free[:, given] @ bones.ravel()
        inner = free[:, ~given]
        inverse: Any = diags_array(1.0 / inner.diagonal())
        start = guess.ravel()[~given]
        found = guess.copy()
        found[bone] = bones
        solution, _ = cg(inner, known, x0=start, rtol=1e-7, maxiter=5000, M=inverse)
        found[~bone] = solution.reshape(-1, 3)
        return found


def _sides(nodes: NDArray[np.float64], tetrahedra: NDArray[np.int64]) -> NDArray[np.float64]:
    """(K, 3, 3) three sides of each tetrahedron, as columns."""
    corners = nodes[tetrahedra]
    return np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)


ELASTICITIES = ("corotational", "linear")
_SOFT = 1e-3
_MARCH = 10


@dataclass(frozen=True)
class ElasticSolid(Rival):
    """Flesh between a jaw that turns and a skull, as an elastic solid.

    Attributes:
        elasticity: ``corotational``, rotations taken out of the strain, or ``linear``.
        nodes: About how many nodes the lattice has within the skin.
        depth: How thick flesh is above bone, as a fraction of D.
        torn: How far the target may stretch flesh before it is taken for a gap.
        poisson: Poisson's ratio, below 1/2; the stiffness itself has no effect.
        tolerance: A face is found when no node moves by more than this part of D, or after twelve
            turns.
    """

    name = "elastic-solid"
    source = "Hahn 2012, Kozlov 2017, Ichim 2017, [17, 19, 20]"
    on_surfaces = True
    package = "skfem"

    elasticity: str = "corotational"
    nodes: int = 6000
    depth: float = 0.09
    torn: float = 2.5
    poisson: float = 0.4
    tolerance: float = 1e-4

    def faces(
        self, recording: MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        """The face at each time.

        Raises:
            MeshError: Nothing turns rigidly, or the skin has no inside.
        """
        if self.elasticity not in ELASTICITIES:
            raise ParameterError(
                f"elasticity must be one of {', '.join(ELASTICITIES)}, found {self.elasticity!r}"
            )
        head = Head.between(recording, self.nodes, self.depth)
        whole = head.stretch(recording) <= self.torn
        solid = Solid.of(head.lattice, self.poisson, np.where(whole, 1.0, _SOFT))
        smallest = self.tolerance * recording.mesh.diameter

        def settled(nodes: NDArray[np.float64], time: float) -> NDArray[np.float64]:
            bones = head.bones_at(time)
            if self.elasticity == "corotational":
                return solid.settled(nodes, bones, head.bone, smallest)
            return solid.linear(bones, head.bone)

        # Marched once, for what the end leaves over; each face starts from the march before it.
        marks = np.linspace(0.0, 1.0, _MARCH + 1)
        march = [head.lattice.nodes]
        for mark in marks[1:]:
            march.append(settled(march[-1], float(mark)))
        missed = recording.frames[-1] - head.carried(march[-1], 1.0, recording)
        for time in times:
            before = march[max(int(np.searchsorted(marks, time)) - 1, 0)]
            nodes = settled(before, float(time))
            yield head.carried(nodes, float(time), recording) + time * missed


@dataclass(frozen=True, eq=False)
class Head:
    """What of a face is bone, what rides on its flesh, and where bones are at which time."""

    lattice: Lattice
    jaw: RigidParts
    skin: NDArray[np.int64]  # Vertices of the part that is the skin
    bone: NDArray[np.bool_]  # (N,) nodes that are given
    turning: NDArray[np.bool_]  # (N,) those of them that turn with the jaw
    rides: NDArray[np.bool_]  # (V,) vertices that the flesh carries

    @classmethod
    def between(cls, recording: MeshSequence, count: int, depth: float) -> Head:
        """The head of a neutral and a target."""
        from scipy.spatial import cKDTree

        mesh, (start, end) = recording.mesh, recording.frames
        jaw = find_rigid_parts(mesh, recording.target)
        if jaw is None:
            raise MeshError("no part of the face turns rigidly, so it has no jaw to move")
        skin = max(connected_parts(len(start), mesh.edges), key=len)
        closed = Closed.of(part_of(mesh, skin))
        lattice = Lattice.inside(closed, start[skin], start, count)
        still = (start == end).all(axis=1)
        if not still.any():
            raise MeshError("every vertex moves, so it has no skull to hang on")
        nodes = lattice.nodes
        to_jaw = np.asarray(cKDTree(start[jaw.vertices]).query(nodes)[0])
        to_still = np.asarray(cKDTree(start[still]).query(nodes)[0])
        cell = float(np.median(np.ptp(nodes[lattice.tetrahedra], axis=1).max(axis=1)))
        deep = np.asarray(cKDTree(start[skin]).query(nodes)[0]) > depth * mesh.diameter
        on_skin = lattice.carrier[skin]
        moving = np.zeros(len(nodes), dtype=bool)
        moving[lattice.tetrahedra[on_skin[~still[skin]]]] = True
        unmoved = np.zeros(len(nodes), dtype=bool)
        unmoved[lattice.tetrahedra[on_skin[still[skin]]]] = True
        near = to_jaw < np.where(deep, max(depth * mesh.diameter, cell), cell)
        turning = near & (to_jaw < to_still)
        bone = turning | deep | (unmoved & ~moving)
        rides = (lattice.carrier >= 0) & ~still
        rides[jaw.vertices] = False
        return cls(lattice, jaw, skin, bone, turning, rides)

    def stretch(self, recording: MeshSequence) -> NDArray[np.float64]:
        """(K,) how many times longer the target makes the longest drawn side of a tetrahedron.

        Each node goes where the nearest vertex of the skin does.
        """
        from scipy.spatial import cKDTree

        start, end = recording.frames
        nearest = self.skin[cKDTree(start[self.skin]).query(self.lattice.nodes)[1]]
        there = self.lattice.nodes + (end - start)[nearest]
        found = np.ones(len(self.lattice.tetrahedra))
        for one, other in combinations(self.lattice.tetrahedra.T, 2):
            before, after = (
                np.linalg.norm(nodes[one] - nodes[other], axis=1)
                for nodes in (self.lattice.nodes, there)
            )
            found = np.maximum(found, after / before)
        return found

    def bones_at(self, time: float) -> NDArray[np.float64]:
        """(B, 3) the given nodes at a time."""
        places = self.lattice.nodes.copy()
        places[self.turning] = self.jaw.screw.at(time, places[self.turning])
        return places[self.bone]

    def carried(
        self, nodes: NDArray[np.float64], time: float, recording: MeshSequence
    ) -> NDArray[np.float64]:
        """(V, 3) flesh on its tetrahedra, the jaw on its screw, and the rest straight."""
        face = straight(recording, time)
        face[self.rides] = self.lattice.carried(nodes)[self.rides]
        jaw = self.jaw.vertices
        face[jaw] = self.jaw.screw.at(time, recording.frames[0][jaw])
        return face
