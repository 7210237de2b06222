"""Elastic beams: every curve obeys the equation of motion, solved in closed form (Eqs. 31-33)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

import elastomorph.paths.options as options
from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.model.surface import surface_operators
from elastomorph.paths.method import Prepared
from elastomorph.paths.straight import Loaded
from elastomorph.physics import BASES, STIFFNESSES, BeamModes, Material
from elastomorph.physics.plate import PlateModes


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


# Elastic plates: the surface itself obeys the equation of motion, without curves.


@dataclass(frozen=True)
class Plate(Loaded):
    """The whole surface is an elastic plate.

    Attributes:
        order: R of the load t^R, from 1 to 20.
        load: Any polynomial load instead of t^R.
        closure: Time law of the mean of a connected piece (a tooth, an eye).
        harmonics: Modes above this number follow the limit law; all are solved by default.
        material: m, c, k. Lengths are in √area of the neutral, so that they mean the same at any
            scale.
    """

    name = "plate"
    path = "the whole surface an elastic plate between the two shapes"
    on_surfaces = True

    closure: str = options.closure()
    harmonics: int | None = options.harmonics()
    material: Material = options.material()

    def prepare(
        self,
        neutral: Mesh,
        curves: CurveNetwork | None = None,
        *,
        rigidity: ArrayLike | None = None,
        pinned: ArrayLike | None = None,
    ) -> Prepared:
        """As `Method.prepare`; curves are not used, and the neutral is factored once.

        Args:
            neutral: The mesh at t = 0, with polygons.
            curves: Not used.
            rigidity: A factor of ``material.rigidity`` everywhere, or (V,) painted for each
                vertex; above 0, within a ratio of a million.
            pinned: Vertex indices, or (V,) bool: these follow the limit law p(t)/p(1) exactly, and
                so do vertices on no polygon. A piece with a pinned vertex has no mean of its own.

        Raises:
            MeshError: The neutral has no polygon with an area.
            ParameterError: A rigidity or a pinned vertex is out of range.
            ResonanceError: The material is singular for this load.
        """
        count = len(neutral.vertices)
        surface = surface_operators(neutral)
        modes = PlateModes.prepare(
            surface.laplacian,
            surface.mass,
            surface.component_of,
            self.material,
            self.external_load,
            closure=self.closure,
            rigidity=_painted(rigidity, count),
            pinned=_pinned(pinned, count),
            harmonics=self.harmonics,
        )
        return self.modal_path(neutral, modes.bends)


def _painted(rigidity: ArrayLike | None, count: int) -> NDArray[np.float64] | None:
    if rigidity is None:
        return None
    try:
        factors = np.asarray(rigidity, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(f"rigidity must be numbers, found {rigidity!r}") from None
    return np.full(count, float(factors)) if factors.ndim == 0 else factors


def _pinned(pinned: ArrayLike | None, count: int) -> NDArray[np.bool_] | None:
    """(V,) which vertices are pinned, from indices or from a mask."""
    if pinned is None:
        return None
    chosen = np.asarray(pinned)
    if chosen.dtype == bool:
        if chosen.shape != (count,):
            raise ParameterError(
                f"pinned as a mask needs {count:,} values, one a vertex, found {chosen.shape}"
            )
        return chosen
    mask = np.zeros(count, dtype=bool)
    if chosen.size:
        if chosen.ndim != 1 or not np.issubdtype(chosen.dtype, np.integer):
            raise ParameterError(f"pinned must be a list of vertex indices, found {pinned!r}")
        if chosen.min() < 0 or chosen.max() >= count:
            raise ParameterError(
                f"pinned vertices must lie between 0 and {count - 1:,}, found {chosen.min()} to "
                f"{chosen.max()}"
            )
        mask[chosen] = True
    return mask
