"""The equation of motion of an elastic curve and its solutions. Nothing here knows a mesh."""

from elastomorph.physics.beam import BASES, STIFFNESSES, BeamModes
from elastomorph.physics.equation import Load, Material
from elastomorph.physics.response import CLOSURES, Closure, mean_response, modal_response

__all__ = [
    "BASES",
    "CLOSURES",
    "STIFFNESSES",
    "BeamModes",
    "Closure",
    "Load",
    "Material",
    "mean_response",
    "modal_response",
]
