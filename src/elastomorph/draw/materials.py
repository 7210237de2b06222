"""What the parts of a head look like, told from the names their author gave them."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.components import component_of
from elastomorph.model.mesh import FaceLabels, Mesh

__all__ = ["LOOKS", "Look", "part_of_name", "parts_of"]

RGB = tuple[float, float, float]


@dataclass(frozen=True)
class Look:
    """How one part reflects light.

    Attributes:
        colour: Red, green, blue from 0 to 1.
        shine: Strength of the highlight from 0 to 1.
        polish: Sharpness of the highlight, the exponent of Phong's model.
    """

    colour: RGB
    shine: float = 0.08
    polish: float = 12.0


LOOKS: dict[str, Look] = {
    "skin": Look((0.84, 0.72, 0.65), 0.10, 14.0),
    "lips": Look((0.76, 0.50, 0.47), 0.18, 24.0),
    "brow": Look((0.36, 0.26, 0.21), 0.05),
    "lash": Look((0.30, 0.22, 0.19), 0.0),
    "hair": Look((0.33, 0.25, 0.20), 0.10),
    "sclera": Look((0.93, 0.92, 0.90), 0.35, 60.0),
    "iris": Look((0.38, 0.46, 0.50), 0.45, 60.0),
    "pupil": Look((0.05, 0.05, 0.06), 0.60, 60.0),
    "teeth": Look((0.94, 0.92, 0.87), 0.35, 40.0),
    "gum": Look((0.72, 0.42, 0.42), 0.25, 30.0),
    "tongue": Look((0.74, 0.43, 0.43), 0.15, 20.0),
    "mouth": Look((0.42, 0.21, 0.21), 0.05),
    "nostril": Look((0.44, 0.27, 0.24), 0.05),
}
"""The look of each part that is drawn.

"hidden" is none of them: pieces of their own that only an image or a game engine can shade,
such as cards of lashes and shells of wetness or shadow round the eye.
"""

_SIDE = r"(_(l|r|left|right|upper|lower|mesh|geo|mat))*"
_WORDS = (
    (
        "hidden",
        "occlusion|eye_?blend|lacrimal|tears?|tear_?line|meniscus|eye_?shadow|eye_?wet|fluid|cornea",
    ),
    ("pupil", "pupils?"),
    ("iris", "iris|irises"),
    ("sclera", "scleras?|eye_?whites?|eye_?balls?"),
    ("lash", "(eye_?)?lash(es)?"),
    ("brow", "(eye_?)?brows?"),
    ("lips", "lips?"),
    ("teeth", "teeth|tooth"),
    ("gum", "gums?"),
    ("tongue", "tongue"),
    ("mouth", rf"mouth(_?(socket|bag|inner|inside|interior|cavity))?{_SIDE}$|oral|throat"),
    ("nostril", "nostrils?"),
    ("hair", "hair|scalp|beard"),
    ("sclera", f"eyes?{_SIDE}$"),
)
"""Whole words, the telling ones first: "lacrimal fluid of the eye" is no eye."""


def part_of_name(name: str) -> str:
    """The part of a head that a material or group name speaks of; skin where it says nothing.

    Args:
        name: Such as ``M_ScleraLeft``, ``lower lip`` or ``Eye_occlusion.001``.
    """
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name)
    words = re.sub(r"[\W\d_]+", "_", words).strip("_").lower()
    for part, pattern in _WORDS:
        if re.search(f"(^|_)({pattern})(_|$)", words):
            return part
    return "skin"


def parts_of(mesh: Mesh) -> dict[str, NDArray[np.int64]]:
    """The polygons of each part of a head, by the names of its materials, else of its groups.

    Returns:
        Part (a key of `LOOKS`, or "hidden") to (F_part,) polygon numbers, each polygon in one part.
    """
    parts = _parts(mesh.materials, len(mesh.faces))
    by_group = _parts(mesh.groups, len(mesh.faces))
    # A material may say only "skin" or "default" where the group says "teeth".
    parts = np.where(parts == "skin", by_group, parts)
    for name, otherwise in (("hidden", "skin"), ("lash", "lash")):
        doubtful = parts == name
        if doubtful.any():
            attached = _touching(mesh, doubtful)
            parts[doubtful] = "hidden"
            parts[attached] = otherwise
    return {str(part): np.flatnonzero(parts == part) for part in np.unique(parts)}


def _parts(labels: FaceLabels | None, count: int) -> NDArray[np.str_]:
    if labels is None or not labels.names:
        return np.full(count, "skin", dtype="<U8")
    known = np.array([*(part_of_name(name) for name in labels.names), "skin"], dtype="<U8")
    return np.asarray(known[labels.of_face])


def _touching(mesh: Mesh, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of the chosen polygons belong to a piece that shares vertices with the others."""
    faces = mesh.faces
    inside = chosen[faces.corner_faces]
    size = len(mesh.vertices)
    start, end = faces.indices[inside], faces.indices[faces.next_corners[inside]]
    piece = component_of(size, np.stack([start, end], axis=1))
    shared = np.zeros(size, dtype=bool)
    others = faces.indices[~inside]
    shared[piece[others]] = True
    return np.asarray(chosen & shared[piece[faces.indices[faces.offsets[:-1]]]])
