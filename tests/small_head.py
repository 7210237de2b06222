"""A stylized head of 5,308 vertices with 52 shapes: small, and fixed, so that figures stay true.

Centimetres, +Y up, +Z out of the face; the left of the character ("_L") is +x. Positions are whole
multiples of ``unit``, a power of two of a centimetre. Faces other than the neutral are kept as the
vertices of the left half that they move and how far, and the same of their mirror images.
"""

from __future__ import annotations

import atexit
import shutil
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

import elastomorph as em
from elastomorph.model.mesh import FaceLabels, Mesh
from elastomorph.model.polygons import Polygons
from elastomorph.model.sequence import MeshSequence
from elastomorph.rig.build import bare_rig
from foreign_files import write_foreign_glb

__all__ = [
    "bare_head",
    "expressions",
    "head",
    "landmarks",
    "recorded_motion",
    "rig_file",
    "shapes",
    "straight",
    "tracked_points",
]

_FILE = Path(__file__).parent / "data" / "small_head.npz"

# Jaw from the right ear to the left, brows, nose, eyes, lips, as face trackers number them.
_TRACKED = (
    2434, 2499, 2552, 2726, 2836, 2921, 2978, 3005, 912, 914, 918, 859, 762, 652, 1695,
    377, 305, 2409, 3458, 3456, 3453, 3450, 1395, 1424, 1401, 1429, 303, 318, 360, 418,
    476, 3696, 3689, 603, 605, 1632, 3616, 3613, 3608, 3525, 3626, 3622, 1548, 1553, 1558,
    1563, 1567, 1571, 4086, 4044, 4026, 1997, 1980, 2000, 2042, 1974, 1975, 1977, 4023, 4039,
    4087, 4077, 2035, 2036, 2028, 2036, 2035, 4093,
)  # fmt: skip


@cache
def head() -> Mesh:
    """Return the neutral, the same mesh on every call.

    Polygon groups name the skin, the scalp, brows, lids, lips, the mouth bag, teeth and the parts
    of the eyeballs.
    """
    with np.load(_FILE) as stored:
        return Mesh(
            stored["neutral"] * stored["unit"],
            Polygons(stored["corners"], np.append(0, np.cumsum(stored["sizes"], dtype=np.int64))),
            groups=FaceLabels(
                names=tuple(stored["group_names"].tolist()),
                of_face=stored["group_of_polygon"].astype(np.int32),
            ),
        )


def shapes() -> dict[str, Mesh]:
    """Return the single blendshapes at full strength, by names such as ``eyeBlink_L``."""
    return dict(_faces()["shape"])


def expressions() -> dict[str, Mesh]:
    """Return the five expressions of the paper: sad, angry, confused, grinning and puff."""
    return dict(_faces()["expression"])


@cache
def recorded_motion() -> MeshSequence:
    """Return eleven poses, from the neutral into a wide laugh, at times 0, 0.1, … 1.

    The jaw opens by 23° about the axis along x through (0, −0.9, 1.2), which glides forwards and
    down by up to 0.35 and 0.105 cm; the lower teeth follow rigidly. Each lid vertex turns about
    the centre of its eyeball. The first frame is ``head()``, bit for bit.
    """
    frames = [head(), *_faces()["frame"].values()]
    positions = np.stack([each.vertices for each in frames])
    return MeshSequence(head(), positions, np.arange(len(frames)) / 10.0)


def landmarks() -> dict[str, int]:
    """Return the vertices of the fifteen landmarks that people click."""
    return {
        "nose_tip": 476,
        "right_eye_outer": 3617,
        "right_eye_inner": 3630,
        "left_eye_inner": 1575,
        "left_eye_outer": 1562,
        "nose_bridge": 318,
        "right_nostril": 2684,
        "left_nostril": 574,
        "mouth_right": 4016,
        "mouth_left": 1968,
        "upper_lip": 1959,
        "lower_lip": 1977,
        "chin": 912,
        "right_jaw": 2864,
        "left_jaw": 763,
    }


def tracked_points() -> dict[str, int]:
    """Return the vertices of the 68 points of face trackers, by number."""
    return {str(number): vertex for number, vertex in enumerate(_TRACKED)}


def straight(*names: str) -> em.Rig:
    """Return the head with straight paths to some of its shapes."""
    return em.Rig(head(), {name: shapes()[name] for name in names}, method="linear")


@cache
def bare_head() -> em.Rig:
    """Return the shapes and expressions as a rig of which no path is known yet."""
    return bare_rig(head(), {**shapes(), **expressions()})


@cache
def rig_file() -> Path:
    """Return a GLB file of `bare_head`, as other programs write it, written once per process."""
    folder = Path(mkdtemp(prefix="small_head_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return write_foreign_glb(folder / "small_head.glb", bare_head())


@cache
def _faces() -> dict[str, dict[str, Mesh]]:
    """Return meshes by kind (shape, expression or frame) and name."""
    neutral = head()
    with np.load(_FILE) as stored:
        ends = np.cumsum(stored["counts"], dtype=np.int64)[:-1]
        moved, partner = np.split(stored["moved"], ends), stored["partner"]
        deltas = np.split(stored["deltas"] * stored["unit"], ends)
        columns = [stored[name].tolist() for name in ("kinds", "names", "halves")]
    found: dict[str, dict[str, Mesh]] = {}
    for kind, name, (left, right) in zip(*columns, strict=True):
        moves = np.zeros_like(neutral.vertices)
        moves[partner[moved[right]]] = deltas[right] * [-1.0, 1.0, 1.0]
        moves[moved[left]] = deltas[left]
        found.setdefault(kind, {})[name] = neutral.with_vertices(neutral.vertices + moves)
    return found
