"""``pde-surface``: patches of a second-order equation between curves, interpolated linearly.

After Fu, Bian, Chaudhry, Wang, You and Zhang, *PDE Surface-Represented Facial Blendshapes*
(Mathematics 9, 2905, 2021), the paper's [37]. Vertices are grouped between extracted boundary
curves; with u across a group and v along it, each group is the surface in closed form of

    ∂²S/∂u² + a² ∂²S/∂v² = 0,        S(0, v) = C₀(v),        S(1, v) = C₁(v)

whose boundary curves are Fourier series. For a wave e^{2πinv} and ω = 2πna

    Sₙ(u) = (sinh ω(1 - u) C₀ₙ + sinh ωu C₁ₙ) / sinh ω,        S₀(u) = (1 - u) C₀₀ + u C₁₀

and the face on the way is (1 - t) S(neutral) + t S(target). A vertex within a group is where the
surface has it, so neutral and target themselves are missed: that is the paper's objection (Sec.
4.3).

Ours, where the source leaves it open: the curves are those of `extract_curves`; curves side by side
whose vertices are joined one to one are a strip, in which every other is a boundary, and its ends;
other curves are boundaries alone. v is even in the vertices, cosines along open curves; u of a
curve is its mean share of the way across on the neutral; a is the width of a group over its length,
so that the equation is Laplace's on the face's own measure. All harmonics are kept: boundary curves
are exact. With that and a single row between boundaries it is as favourable as it can be.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence
from elastomorph.physics.beam import ModeTransform
from elastomorph.rivals.rival import Faces, Rival


@dataclass(frozen=True)
class PdeSurface(Rival):
    """Patches of a second-order equation between curves, interpolated linearly.

    Attributes:
        within: Curves of a strip between one boundary and the next.
        harmonics: Waves above this number are left out; none by default.
    """

    name = "pde-surface"
    source = "Fu and others 2021, [37]"
    on_surfaces = True

    within: int = 1
    harmonics: int | None = None

    def faces(
        self, recording: MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        """The face at each time."""
        groups = []
        for rows, closed in strips(recording.mesh, curves):
            edges = [*range(0, len(rows) - 1, self.within + 1), len(rows) - 1]
            parts = [rows[first : last + 1] for first, last in pairwise(edges)] or [rows]
            groups += [(part, closed) for part in parts]
        start, end = (self._on_surfaces(face, recording.mesh, groups) for face in recording.frames)
        for time in times:
            yield (1.0 - time) * start + time * end

    def _on_surfaces(
        self, face: NDArray[np.float64], neutral: Mesh, groups: list[tuple[NDArray[np.int64], bool]]
    ) -> NDArray[np.float64]:
        """(V, 3) the vertices of a face on the surfaces of its groups."""
        found = face.copy()
        for rows, closed in groups:
            shares, ratio = _measures(neutral.vertices[rows], closed)
            ends = face[rows[[0, -1]]]
            found[rows] = surface(ends[0], ends[1], shares, ratio, closed, self.harmonics)
        return found


def surface(
    first: NDArray[np.float64],
    last: NDArray[np.float64],
    u: NDArray[np.float64],
    ratio: float,
    closed: bool,
    harmonics: int | None = None,
) -> NDArray[np.float64]:
    """(U, M, 3) the surface between two (M, 3) curves at each u and the v of their vertices."""
    transform = ModeTransform(len(first), closed)
    numbers = np.arange(transform.count)
    wave = ratio * np.pi * numbers * (2.0 if closed else 1.0)
    part = np.stack([u, 1.0 - u])[..., None]
    # sinh ωu / sinh ω without overflow, and its limit u at ω = 0.
    with np.errstate(invalid="ignore"):
        fall = np.exp(-wave * (1.0 - part)) - np.exp(-wave * (1.0 + part))
        weights = np.where(wave > 0, fall / -np.expm1(-2.0 * wave), part)
    if harmonics is not None:
        weights[..., numbers > harmonics] = 0.0
    modes = weights[0, ..., None] * transform.forward(last)
    modes = modes + weights[1, ..., None] * transform.forward(first)
    return transform.inverse(modes)


def strips(mesh: Mesh, curves: CurveNetwork) -> list[tuple[NDArray[np.int64], bool]]:
    """(R, M) vertices of R curves side by side, aligned, and whether they are closed."""
    beside = _beside(mesh, curves)
    left = set(range(len(curves)))
    found = []
    # From the ends of strips; what is left after that runs round in a circle.
    order = sorted(left, key=lambda number: (len(beside[number]) > 1, number))
    for number in order:
        if number not in left:
            continue
        left.remove(number)
        rows = [np.asarray(curves[number].vertices, dtype=np.int64)]
        here = number
        while following := [other for other in beside[here] if other in left]:
            partner = beside[here][following[0]]
            rows.append(partner[rows[-1]])
            here = following[0]
            left.remove(here)
        found.append((np.stack(rows), bool(curves[number].closed)))
    return found


def _beside(mesh: Mesh, curves: CurveNetwork) -> dict[int, dict[int, NDArray[np.int64]]]:
    """By curve, those whose vertices edges join one to one to its own, with (V,) partners."""
    of, edges = curves.curve_of, mesh.edges
    across = edges[(of[edges[:, 0]] != of[edges[:, 1]]) & (of[edges] >= 0).all(axis=1)]
    joining: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
    for one, other in across.tolist():
        first, second = (one, other) if of[one] < of[other] else (other, one)
        joining[int(of[first]), int(of[second])].append((first, second))
    found: dict[int, dict[int, NDArray[np.int64]]] = defaultdict(dict)
    for (one, other), pairs in joining.items():
        ends = np.array(pairs).T
        alike = curves[one].closed == curves[other].closed
        sizes = {len(curves[one]), len(curves[other]), *(len(np.unique(own)) for own in ends)}
        if not alike or sizes != {len(pairs)} or max(len(found[one]), len(found[other])) > 1:
            continue
        for here, there, own, others in ((one, other, *ends), (other, one, *ends[::-1])):
            partner = np.full(len(of), -1, dtype=np.int64)
            partner[own] = others
            found[here][there] = partner
    return found


def _measures(rows: NDArray[np.float64], closed: bool) -> tuple[NDArray[np.float64], float]:
    """(R,) mean share of the way across, and the width of a strip over its length."""
    gaps = np.linalg.norm(np.diff(rows, axis=0), axis=2).mean(axis=1)
    width = float(gaps.sum())
    if not width > 0:
        return np.linspace(0.0, 1.0, len(rows)) if len(rows) > 1 else np.zeros(1), 0.0
    along = np.concatenate([rows, rows[:, :1]], axis=1) if closed else rows
    length = float(np.linalg.norm(np.diff(along, axis=1), axis=2).sum(axis=1).mean())
    return np.concatenate([[0.0], np.cumsum(gaps) / width]), width / length if length else 0.0
