"""How fast faces come: the rig beside the paper's own figure and what bounds any method."""

from __future__ import annotations

import timeit
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import extract_curves
from elastomorph.model.mesh import Mesh
from elastomorph.paths import Beam, Method, prepare
from elastomorph.physics import mean_response, modal_response
from elastomorph.physics.beam import ModeTransform
from elastomorph.rig import Rig
from elastomorph.rig.sliders import spread_rows, weight_combinations

PAPER_VERTICES = 5071
PAPER_SECONDS = {259: 2.46, 7775: 72.748}
"""The paper's times for so many faces of `PAPER_VERTICES` vertices (Sec. 5)."""
PAPER_MILLISECONDS = 1e3 * PAPER_SECONDS[7775] / 7775
"""The paper's time for one of its 7775 faces."""

_DIRECT_FACES = 40


class FaceSpeed(NamedTuple):
    """One way to make faces, the shortest time it took for one, and how that was measured."""

    name: str
    seconds_a_face: float
    note: str = ""


class DirectBlend:
    """Eqs. 39 and 40 face by face: blend the constants of every mode, then sum the series."""

    def __init__(self, neutral: Mesh, targets: Sequence[Mesh], method: Method) -> None:
        members: dict[tuple[bool, int], list[NDArray[np.int32]]] = {}
        for curve in extract_curves(neutral):
            members.setdefault((curve.closed, len(curve)), []).append(curve.vertices)
        shapes = np.stack([mesh.vertices for mesh in targets])
        load, material = method.external_load, method.material
        self._count = len(neutral.vertices)
        self._groups = []
        for (closed, size), vertices in members.items():
            transform = ModeTransform(size, closed)
            indices = np.stack(vertices)
            laws = np.zeros((transform.count, load.order + 1))
            laws[0] = mean_response(method.closure, load, material)
            stiffness = transform.stiffness(material.rigidity)[1:]
            laws[1:, : load.order] = modal_response(stiffness, load, material)
            start = transform.forward(neutral.vertices[indices])
            change = transform.forward(shapes[:, indices] - neutral.vertices[indices])
            self._groups.append((indices, transform, laws, start, change))

    def face(self, weights: NDArray[np.float64], t: float) -> NDArray[np.float64]:
        """(V, 3) one face: V₀ + Σ ζ_j (w^j(t) - V₀)."""
        positions = np.empty((self._count, 3))
        for indices, transform, laws, start, change in self._groups:
            law = laws @ t ** np.arange(1, laws.shape[1] + 1)
            modes = start + law[:, None] * np.tensordot(weights, change, axes=1)
            positions[indices] = transform.inverse(modes)
        return positions


def face_speeds(
    neutral: Mesh,
    targets: Sequence[Mesh],
    *,
    method: str = "beam:3",
    levels: int = 6,
    t: float = 0.5,
    repeats: int = 5,
    say: Callable[[str], None] = lambda _: None,
) -> tuple[int, list[FaceSpeed]]:
    """Time the paper's experiment: every combination of weights of some expressions.

    Returns how many faces were made, of ``levels`` values of each weight, and a row for each way.
    Bends count at any ``t`` but 0 and 1; of ``repeats`` runs the shortest counts.
    """
    rows = weight_combinations(len(targets), levels)
    note = f"{PAPER_VERTICES:,} vertices, its own laptop"
    found = [FaceSpeed("the paper", PAPER_MILLISECONDS / 1e3, note)]
    found += [
        FaceSpeed(f"the paper, {faces} faces", seconds / faces, note)
        for faces, seconds in PAPER_SECONDS.items()
        if faces < len(rows)
    ]
    for name, task, faces, note in _ways(neutral, targets, method, rows, t):
        if "PyTorch" not in name or find_spec("torch") is not None:
            say(name)
            seconds = min(timeit.repeat(task, number=1, repeat=repeats))
            found.append(FaceSpeed(name, seconds / faces, note))
    return len(rows), found


def _ways(
    neutral: Mesh, targets: Sequence[Mesh], method: str, rows: NDArray[np.float64], t: float
) -> list[tuple[str, Callable[[], object], int, str]]:
    """What is timed: a name, what to run, how many faces that makes, and how."""
    rig = _rig(neutral, targets, method)
    count = len(rows)
    out = np.empty((count, *neutral.vertices.shape), dtype=np.float32)
    other = np.zeros_like(out)
    own = Method.parse(method)
    # Eq. 39 is of beams: beside another method stands the beam of the load that both have.
    shared = ("order", "load", "closure", "material")
    beam = Beam(**{option: getattr(own, option) for option in shared if own.has(option)})
    direct = DirectBlend(neutral, targets, beam)
    some = rows[:_DIRECT_FACES]
    matrix = rig.fields.matrix(np.float32)
    coefficients = np.full((count, len(matrix)), 0.1, dtype=np.float32)
    linear = _rig(neutral, targets, "linear")
    bends = sum(len(morph.bends) for morph in rig.morphs.values())
    sizes = f"float32, {len(targets)} targets and {bends} bends"
    bare = out.reshape(count, -1)
    ways: dict[str, tuple[Callable[[], object], int, str]] = {
        "Eq. 39 face by face": (
            lambda: [direct.face(weights, t) for weights in some],
            len(some),
            f"float64, {_DIRECT_FACES} faces",
        ),
        "rig.batch": (lambda: rig.batch(rows, t, out), count, sizes),
        "rig.batch, PyTorch": (lambda: rig.batch(rows, t, out, backend="torch"), count, sizes),
        "bare numpy.matmul": (
            lambda: np.matmul(coefficients, matrix, out=bare),
            count,
            "the same shapes",
        ),
        "linear blendshapes": (
            lambda: linear.batch(rows, t, out),
            count,
            "rig.batch without bends",
        ),
        "memory copy": (lambda: np.copyto(out, other), count, "of the same output"),
    }
    few = min(PAPER_SECONDS)
    if few < count:
        chosen = rows[spread_rows(count, few)]
        ways[f"rig.batch, {few} faces"] = (
            lambda: rig.batch(chosen, t, out[:few]),
            few,
            "spread evenly over all of them",
        )
    return [(name, *way) for name, way in ways.items()]


def _rig(neutral: Mesh, targets: Sequence[Mesh], method: str) -> Rig:
    to = prepare(neutral, method)
    return Rig(neutral, {str(number): to(mesh) for number, mesh in enumerate(targets)})
