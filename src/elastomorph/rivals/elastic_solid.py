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
(`Lattice`). Parts that turn rigidly (lower teeth, tongue) are the jaw, and lie on their screw; what
both ends have at the same place is still. A node is bone if it is deeper below the skin than
`depth`, or within a cell of a jaw's part. It is of the jaw if such a part is nearer than anything
that is still, and no farther than `depth`: what is behind the throat is nearer to the tongue than
to still skin, yet of the neck, and would be turned into it. All other bone is of the skull; a node
whose skin is all still is still. The skin is free. What this leaves of the target (a smile is no
work of bones) is added in proportion to t, so that both ends are exact. A tetrahedron that the
target stretches more than `torn` times spans the open mouth: it is softened a thousandfold.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import MeshError, ParameterError
from elastomorph.evaluation.rigid_bodies import RigidParts, find_rigid_parts
from elastomorph.model.geometry import connected_parts
from elastomorph.model.mesh import part_of
from elastomorph.model.sequence import MeshSequence
from elastomorph.rivals.lattice import Closed, Lattice
from elastomorph.rivals.rival import Faces, Rival, straight
from elastomorph.rivals.solid import Solid

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
