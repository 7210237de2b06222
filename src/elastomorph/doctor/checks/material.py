"""Is a material at resonance on the curves of this face?"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from elastomorph.curves import extract_curves
from elastomorph.doctor.findings import Finding, finding
from elastomorph.errors import ResonanceError, TimeLawWarning
from elastomorph.model.mesh import Mesh
from elastomorph.physics import BeamModes, Load, Material

__all__ = ["BeamSettings", "examine_material"]


@dataclass(frozen=True)
class BeamSettings:
    """What a beam is made of and how it is solved.

    Attributes:
        material: m, c and k.
        order: R of the load t^R.
        closure: Time law of a curve's mean.
    """

    material: Material
    order: int = 2
    closure: str = "limit"


def examine_material(neutral: Mesh, file: str, beam: BeamSettings) -> list[Finding]:
    """Try the material on every mode of every curve of the neutral.

    Raises:
        ParameterError: An order or a closure that does not exist.
    """
    curves = [
        (np.asarray(curve.vertices), curve.closed) for curve in extract_curves(neutral).curves
    ]
    load = Load.power(beam.order)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", TimeLawWarning)
        try:
            BeamModes.prepare(curves, beam.material, load, closure=beam.closure)
        except ResonanceError as error:
            return [finding("resonant-material", file, str(error))]
    messages = dict.fromkeys(
        str(w.message) for w in caught if issubclass(w.category, TimeLawWarning)
    )
    return [finding("overshooting-material", file, message) for message in messages]
