"""What the parts of a head look like, told from the names their author gave them.

Eyes that have their irises only in an image, or behind a glass cornea, are painted with one.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.pictures import RGB
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import FaceLabels, Mesh


@dataclass(frozen=True)
class Look:
    """How one part reflects light: its colour, the highlight from 0 to 1, its Phong exponent."""

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
    "clothes": Look((0.46, 0.48, 0.52), 0.05),
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
    (
        "clothes",
        "outfit|cloth(es|ing)?|garment|(t_?)?shirt|jacket|coat|suit|dress|tops|pants|trousers|jeans|"
        "skirt|shoes?|boots?|foot_?wear|socks?|gloves?|hat|helmet|head_?wear|hood|scarf|tie|"
        "(eye_?)?glasses|goggles|eye_?wear|ear_?rings?|necklace|accessor(y|ies)",
    ),
    ("sclera", f"eyes?{_SIDE}$"),
)
"""Whole words, the telling ones first: "lacrimal fluid of the eye" is no eye."""

SPAN = 0.75
"""The image of the eye spans this many radii of the eyeball to each side of its middle."""
IRIS, PUPIL = 0.47, 0.18
"""Radius of iris and pupil over the radius of the eyeball (human: about 5.9 and 2.3 of 12 mm)."""
ROUND = 0.75
"""Smallest over largest side of the box round a shell that may be an eyeball."""

WHITE = np.array([0.94, 0.93, 0.915])
IRIS_RIM, IRIS_MIDDLE, IRIS_HEART = np.array(
    [[0.16, 0.19, 0.21], [0.37, 0.44, 0.47], [0.50, 0.50, 0.43]]
)
PUPIL_BLACK = np.array([0.035, 0.035, 0.04])


def part_of_name(name: str) -> str:
    """The part that a name such as ``M_ScleraLeft`` or ``lower lip`` speaks of; skin by default."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name)
    words = re.sub(r"[\W\d_]+", "_", words).strip("_").lower()
    for part, pattern in _WORDS:
        if re.search(f"(^|_)({pattern})(_|$)", words):
            return part
    return "skin"


def parts_of(mesh: Mesh) -> dict[str, NDArray[np.int64]]:
    """The polygons of each part of a head, by the names of its materials, else of its groups.

    A part is a key of `LOOKS`, or "hidden", with (F_part,) polygon numbers; each polygon is in one.
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
    piece = _pieces(mesh, np.flatnonzero(inside))
    shared = np.zeros(len(mesh.vertices), dtype=bool)
    shared[piece[faces.indices[~inside]]] = True
    return np.asarray(chosen & shared[piece[faces.indices[faces.offsets[:-1]]]])


def iris_coordinates(
    mesh: Mesh, shell: NDArray[np.int64], inner: NDArray[np.int64]
) -> NDArray[np.float64]:
    """(C_shell, 2) where each corner of the eyes' white lies in `eye_image`, from 0 to 1.

    The eyes are taken to look along +Z in the mesh as it stands. What is no eyeball, or shows an
    iris of its own outside the white, is given the image's white edge. The shell is the polygon
    numbers of the white, ascending, inner those of the irises and pupils that the mesh has.
    """
    faces = mesh.faces
    corners = np.flatnonzero(np.isin(faces.corner_faces, shell))
    corner_label = _pieces(mesh, corners)[faces.indices[corners]]
    place = np.zeros((len(corners), 2))
    own = mesh.vertices[faces.indices[np.isin(faces.corner_faces, inner)]]
    for label in np.unique(corner_label):
        ball = corner_label == label
        points = mesh.vertices[faces.indices[corners[ball]]]
        low, high = points.min(axis=0), points.max(axis=0)
        sides = high - low
        if sides.min() < ROUND * sides.max():
            continue
        radius = float(sides[:2].mean()) / 2
        middle = (low + high) / 2
        middle[2] = low[2] + radius  # a cornea may bulge in front, nothing does behind
        aside = np.hypot(*(own - middle)[:, :2].T)
        before = (aside < radius / 2) & (own[:, 2] >= points[:, 2].max() - 0.01 * radius)
        if before.any():
            continue
        seen = (points - middle) / radius
        flat = np.clip(0.5 + seen[:, :2] / (2 * SPAN), 0.0, 1.0)
        place[ball] = np.where(seen[:, 2:] > 0, flat, 0.0)
    return place


def eye_image(pixels: int = 512) -> NDArray[np.uint8]:
    """(pixels, pixels, 3) picture of an iris on white, white at the edges."""
    across = (np.arange(pixels) + 0.5) / pixels * 2 * SPAN - SPAN
    x, y = np.meshgrid(across, across)
    out, turn = np.hypot(x, y), np.arctan2(y, x)
    spokes = 0.04 * np.sin(47 * turn) * np.sin(23 * turn + 1.0) + 0.03 * np.sin(71 * turn + 2.0)
    inward = np.clip((IRIS - out) / (IRIS - PUPIL), 0.0, 1.0)
    colour = _mix(IRIS_RIM, IRIS_MIDDLE, _step(inward, 0.0, 0.35))
    colour = _mix(colour, IRIS_HEART, 0.7 * _step(inward, 0.55, 1.0)) + spokes[..., None]
    colour = _mix(colour, PUPIL_BLACK, _step(-out, -PUPIL - 0.012, -PUPIL + 0.012))
    colour = _mix(colour, WHITE, _step(out, IRIS - 0.02, IRIS + 0.02))
    return np.rint(np.clip(colour, 0.0, 1.0) * 255).astype(np.uint8)


def _step(values: NDArray[np.float64], start: float, stop: float) -> NDArray[np.float64]:
    """0 below start, 1 above stop, smooth between."""
    s = np.clip((values - start) / (stop - start), 0.0, 1.0)
    return np.asarray(s * s * (3 - 2 * s))


def _mix(
    one: NDArray[np.float64], other: NDArray[np.float64], share: NDArray[np.float64]
) -> NDArray[np.float64]:
    return np.asarray(one + (other - one) * share[..., None])


def _pieces(mesh: Mesh, corners: NDArray[np.int64]) -> NDArray[np.int32]:
    """(V,) the connected part of each vertex, joined by the edges at these corners alone."""
    edges = np.stack([corners, mesh.faces.next_corners[corners]], axis=1)
    return component_of(len(mesh.vertices), mesh.faces.indices[edges])
