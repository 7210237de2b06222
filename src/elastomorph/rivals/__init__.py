"""What the paper compares with, on the same faces and in the same table: comparison, not product.

None of these is a method of a rig. Each names its source, its parameters, and what is ours
where the source leaves it open.
"""

from elastomorph.rivals.comparison import Comparison, Cost, with_rivals
from elastomorph.rivals.elastic_solid import DeformationGradients, ElasticSolid
from elastomorph.rivals.mass_spring import MassSpring
from elastomorph.rivals.pde_surface import PdeSurface
from elastomorph.rivals.rival import Rival
from elastomorph.rivals.stepped_beams import FiniteDifference, FiniteElement
from elastomorph.rivals.vertex_cubic import VertexCubic

__all__ = [
    "RIVALS",
    "Comparison",
    "Cost",
    "DeformationGradients",
    "ElasticSolid",
    "FiniteDifference",
    "FiniteElement",
    "MassSpring",
    "PdeSurface",
    "Rival",
    "VertexCubic",
    "with_rivals",
]

RIVALS: tuple[Rival, ...] = (
    VertexCubic(),
    FiniteDifference(),
    FiniteElement(),
    DeformationGradients(),
    MassSpring(),
    PdeSurface(),
    ElasticSolid("linear"),
    ElasticSolid(),
)
"""All of them as they are by default, in the order of a table."""
