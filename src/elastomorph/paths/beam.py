"""Elastic beams: every curve obeys the equation of motion, solved in closed form (Eqs. 31-33)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import elastomorph.paths.options as options
from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.model.mesh import Mesh
from elastomorph.paths.loaded import Loaded
from elastomorph.paths.method import Prepared
from elastomorph.physics import BASES, STIFFNESSES, BeamModes, Material


@dataclass(frozen=True)
class Beam(Loaded):
    """Every curve is an elastic beam (Eqs. 31-33, for a load of any order).

    Attributes:
        order: R of the load t^R, from 1 to 20.
        load: Any polynomial load instead of t^R.
        closure: Time law of the mean of a curve, see `elastomorph.physics.mean_response`.
        basis: Modes of open curves, ``cosine`` or the paper's ``fourier``.
        stiffness: ``uniform``: u from 0 to 1 along every curve. ``length``: short curves are
            stiffer, B_n over (L/D)⁴.
        harmonics: Modes above this number follow the limit law; all are solved by default.
        material: m, c, k.
    """

    name = "beam"
    path = "each curve an elastic beam between the two shapes (Eqs. 31–33)"
    on_curves = True

    closure: str = options.closure()
    basis: str = options.choice("cosine", BASES, "modes of open curves: cosine or fourier")
    stiffness: str = options.choice(
        "uniform",
        STIFFNESSES,
        "uniform, or length: short curves are stiffer",
        label=lambda by: f"by {by}",
    )
    harmonics: int | None = options.harmonics()
    material: Material = options.material()

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """As `Method.prepare`, with the curves of `extract_curves` where none are given.

        Vertices on no curve follow the limit law.

        Raises:
            ResonanceError: The material is singular for this load.
        """
        if curves is None:
            curves = extract_curves(neutral)
        modes = BeamModes.prepare(
            [(curve.vertices, curve.closed) for curve in curves],
            self.material,
            self.external_load,
            closure=self.closure,
            basis=self.basis,
            harmonics=self.harmonics,
            lengths=_lengths(neutral, curves) if self.stiffness == "length" else None,
        )
        return self.modal_path(neutral, modes.bends)


def _lengths(neutral: Mesh, curves: CurveNetwork) -> NDArray[np.float64]:
    """(curves,) length of each curve on the neutral, over D."""
    lengths = np.empty(len(curves))
    for number, curve in enumerate(curves):
        points = neutral.vertices[curve.vertices]
        if curve.closed:
            points = np.concatenate([points, points[:1]])
        lengths[number] = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    return lengths / (neutral.diameter or 1.0)
