"""A template that has become a person, from whose neutral every pose begins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.similarity import Similarity
from elastomorph.capturing.scans.expressions import Expressions
from elastomorph.capturing.scans.face import Face
from elastomorph.capturing.scans.nonrigid import Elastic
from elastomorph.capturing.scans.placing import Marks, stillness
from elastomorph.capturing.scans.virtual import Shown
from elastomorph.capturing.work.registered import Registered
from elastomorph.model.mesh import Mesh, require_mesh, require_same_topology

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Person:
    """The template as one person, whom all scans show.

    Attributes:
        face: the template.
        elastic: at rest at the person's own neutral.
        expressions: of the template's rig, on this person.
        placing: what brought the scan that it was made from to its place, if it is known.
        still: (V,) how much each vertex tells where the head is; 0 where the scan shows nothing.
        clicked: vertex of a landmark → how far beside it the landmark is on the neutral's scan.
        shown: what of it can be followed, if its scan has colours.
    """

    face: Face
    elastic: Elastic
    expressions: Expressions | None
    placing: Similarity | None
    still: Points
    clicked: Mapping[int, Points]
    shown: Shown | None = None


def known_person(face: Face, neutral: Mesh, marks: Marks) -> Person:
    """The person of a neutral that was registered before."""
    require_mesh(neutral, "the neutral")
    require_same_topology(face.mesh, neutral)
    elastic = Elastic(face.vertices, face.triangles, face.size, face.skin)
    expressions = face.expressions
    if expressions is not None:
        expressions = expressions.transferred(neutral.vertices[face.first], elastic)
    placing = None
    if isinstance(neutral, Registered) and "placing" in neutral.figures:
        placing = placing_of(neutral)
    own = elastic.with_rest(neutral.vertices[face.first])
    still = stillness(own, expressions, marks)
    if isinstance(neutral, Registered):
        still = still * ~neutral.flagged[face.first]
    return Person(face, own, expressions, placing, still, {})


def placing_of(pose: Registered) -> Similarity:
    """What brought the scan of a pose to its place."""
    known = pose.figures["placing"]
    return Similarity(known["scale"], np.array(known["rotation"]), np.array(known["shift"]))


def wanted_at(elastic: Elastic, expressions: Expressions | None) -> Points:
    """(V,) how much each vertex is to be looked at: what expressions move most of all."""
    wanted = np.ones(len(elastic.rest))
    if expressions is not None:
        moved = np.linalg.norm(expressions.deltas, axis=2).max(axis=0)
        wanted[moved > 0.005 * elastic.size] = 5.0
    return wanted
