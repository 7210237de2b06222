"""What an examination is told beforehand, and every threshold with its reason."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.paths.auto import INBETWEEN_PAYS
from elastomorph.physics import Material

SIDES: tuple[tuple[str, str], ...] = (
    ("_L", "_R"),
    ("_l", "_r"),
    (".L", ".R"),
    (".l", ".r"),
    ("Left", "Right"),
    ("_left", "_right"),
    ("_lf", "_rt"),
    ("L_", "R_"),
    ("l_", "r_"),
    ("left_", "right_"),
)
"""Endings and beginnings that tell sides; those that end in an underscore are beginnings."""


@dataclass(frozen=True)
class Thresholds:
    """From where on to report. Lengths are fractions of D, the largest distance in the neutral."""

    # A target that moves no vertex farther does nothing; two targets that differ no more are the
    # same. A file with six digits rounds by a tenth of this.
    nothing: float = 1e-5
    # A polygon whose area is at most this part of its longest edge squared has none; one that keeps
    # at most this part of its area has lost it.
    area: float = 1e-6
    # The stillest quarter of the vertices of a target may move so far before one asks whether the
    # head moved; scans are stabilised to about this.
    head: float = 5e-4
    # A rigid motion is one of the head if it leaves less than this part of what the stillest
    # quarter moves: it leaves 0.001 of a sculpted target, while of scans that differ smoothly by
    # 0.1 % of D without any such motion it leaves 0.24 and more.
    steadier: float = 0.2
    # A vertex jumps that leaves the median of its neighbours by more than this part of its mean
    # edge,
    jump: float = 0.5
    jump_alone: float = 5.0  # and by more than this many times what they differ among themselves,
    # and if the product of both, in mean edges and in such differences, is larger than this: a
    # short leap counts only where the neighbours agree well. Corners of lashes reach 4 in a blink,
    # vertices left behind 10 and more.
    jump_clearly: float = 6.0
    # and by more than this many times what the smoothest quarter of the vertices leaves theirs: of
    # a million vertices with normal noise none leaves it by 5.1 times that.
    jump_noise: float = 8.0
    # A target has another unit if a third of the distances between near vertices is larger or
    # smaller by more than this factor. No expression does that: even a jaw that drops leaves half
    # of them as they are.
    scale: float = 1.2
    # A file with this part of its vertices at the origin holds displacements: every expression of
    # three rigs leaves more than a third of the vertices where they are.
    resting: float = 0.1
    deltas: float = 0.5  # displacements are smaller than this; no shape is
    # A target is noisy if all but a quarter of its vertices leave the mean of their neighbours by
    # more than this part of an edge, from where on shading shows it. Of 150 targets of three rigs
    # none has more than 0.00001; noise of 0.01 % of D gives a fine mesh 0.015.
    noise: float = 0.01
    noise_alone: float = 3.0  # and by this many times what is usual among the targets
    # A target contains another one if this share of its motion is in it, unchanged. No two targets
    # of two rigs share as much as a thousandth.
    baked: float = 0.1
    # Half of the edges of a target may be this many times longer; the most that an expression does
    # to half of a face is a few percent.
    torn: float = 2.0
    asymmetry: float = 0.1  # largest difference of a mirrored pair, as a part of the larger motion,
    asymmetry_of_d: float = 1e-3  # and as a fraction of D; both must be exceeded
    # A pair differs so much, as a part of its motion, that it is no longer a note.
    one_sided: float = 0.5
    # A linear path off its rotation path by more than this at t = 0.5 deserves an in-between.
    bend: float = INBETWEEN_PAYS


@dataclass(frozen=True)
class BeamSettings:
    """What a beam is made of and how it is solved."""

    material: Material  # m, c and k
    order: int = 2  # R of the load t^R
    closure: str = "limit"  # time law of a curve's mean


@dataclass(frozen=True, eq=False)
class ExaminationSettings:
    """What is known about a rig before it is examined.

    Attributes:
        seeds: Pairs (vertex of the neutral, vertex of the targets) for targets in another order.
        sides: How names of targets tell left and right.
        still: (N,) vertices that no target should move; targets are aligned to them.
        steady: Whether to take out the motion of the head where one is found.
        beam: A material to try on the curves of the face.
        thresholds: From where on to report.
    """

    seeds: tuple[tuple[int, int], ...] = ()
    sides: tuple[tuple[str, str], ...] = SIDES
    still: NDArray[np.int64] | None = None
    steady: bool = False
    beam: BeamSettings | None = None
    thresholds: Thresholds = field(default_factory=Thresholds)

    def require_vertices(self, neutral: Mesh, file: str) -> None:
        """Check that the vertices named are there.

        Raises:
            ParameterError: The neutral has no such vertex, or there are too few to align to.
        """
        wanted = np.array([pair[0] for pair in self.seeds], dtype=np.int64)
        if self.still is not None:
            wanted = np.concatenate([wanted, self.still])
            if len(np.unique(self.still)) < 3:
                raise ParameterError("--align needs three vertices or more that are not on a line")
        bad = wanted[(wanted >= len(neutral.vertices)) | (wanted < 0)]
        if bad.size:
            raise ParameterError(
                f"{file} has no vertex {int(bad[0]):,}, only 0 to {len(neutral.vertices) - 1:,}"
            )
