"""What the parts of a head look like, told from the names their author gave them.

Eyes that have their irises only in an image, or behind a glass cornea, are painted with one.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.pictures import RGB, imported
from elastomorph.errors import warn
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import FaceLabels, Material, Mesh, Texture, Wrap
from elastomorph.model.polygons import Polygons, polygon_normals


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


# Images of materials as pixels, and where each corner of a surface lies in them.
#
# Pillow reads the head of a file first: an image of more pixels than `MOST_PIXELS` is not
# decoded, and one larger than a picture can show is made smaller at once.

MOST_PIXELS = 8192**2
"""Of an image that is decoded: 256 MB for a moment."""
LARGEST = 2048
"""Pixels on a side of what is kept of it."""
_FORMATS = ("PNG", "JPEG", "WEBP")


def pixels_of(material: Material) -> tuple[NDArray[np.uint8] | None, str]:
    """(H, W, 4) sRGB and opacity of a material, its colour and its image; and why there are none.

    Light is multiplied where it is linear, so the colour of a material tints its image as in any
    other renderer.
    """
    image, problem = _decoded(material.texture) if material.texture is not None else (None, "")
    if image is None:
        return None, problem
    for channel, factor in enumerate(material.colour):
        if factor != 1.0:
            levels = np.arange(256) / 255
            shown = levels * factor if channel == 3 else encoded(linear(levels) * factor)
            image[..., channel] = np.rint(255 * shown).astype(np.uint8)[image[..., channel]]
    return image, ""


def warn_of(problems: Iterable[tuple[str, str]], where: str) -> None:
    """One warning for all (material, problem) pairs of a mesh whose images cannot be shown."""
    found = list(problems)
    if not found:
        return
    name, problem = found[0]
    others = f" and {len(found) - 1} more" if len(found) > 1 else ""
    warn(
        f"{where}: the texture of {name[:60]!r}{others} cannot be shown ({problem}); only the "
        "colour of the material is"
    )


def places_in(texture: Texture, coordinates: NDArray[np.float64]) -> NDArray[np.float64]:
    """(C, 2) where corners lie in an image, counted from its left and bottom, as the texture says.

    The (C, 2) coordinates are those of the mesh.
    """
    u, v = (coordinates * [1, -1] + [0, 1]).T
    across, down = u * texture.scale[0], v * texture.scale[1]
    cosine, sine = np.cos(texture.rotation), np.sin(texture.rotation)
    x = texture.offset[0] + cosine * across + sine * down
    y = texture.offset[1] - sine * across + cosine * down
    return np.stack([x, 1.0 - y], axis=1)


def linear(shown: NDArray[np.float64]) -> NDArray[np.float64]:
    """Light of sRGB from 0 to 1."""
    return np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)


def encoded(light: NDArray[np.float64]) -> NDArray[np.float64]:
    """The sRGB from 0 to 1 of light."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def _decoded(texture: Texture) -> tuple[NDArray[np.uint8] | None, str]:
    if not texture.image:
        return None, texture.problem or "it is empty"
    pillow = imported("PIL.Image")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of its size and of odd headers: both are handled here
            with pillow.open(BytesIO(texture.image), formats=_FORMATS) as image:
                width, height = image.size
                if width * height > MOST_PIXELS:
                    return None, f"it has {width:,} × {height:,} pixels"
                image.draft("RGB", (LARGEST, LARGEST))  # a large JPEG is decoded smaller
                whole = image.convert("RGBA")
                whole.thumbnail((LARGEST, LARGEST))
                return np.array(whole), ""
    except pillow.DecompressionBombError:
        return None, "it has too many pixels"
    except Exception as error:  # Pillow raises many kinds, some of them for the same damage
        if isinstance(error, pillow.UnidentifiedImageError):  # its words name an object in memory
            return None, "it is no PNG, JPEG or WebP image"
        return None, f"it is damaged: {error}"


# Normals of the corners of polygons: smooth skin, and edges that stay edges.


def corner_pairs(
    faces: Polygons, places: NDArray[np.int64] | None = None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(P,) corners and (P,) corners at the same vertex, all pairs of them, each with itself.

    The places, (C,) numbers, may say of more than one vertex that they are the same.
    """
    vertices = faces.indices if places is None else places
    order = np.argsort(vertices, kind="stable")
    valence = np.bincount(vertices)
    own = valence[vertices[order]]
    begin = (np.cumsum(valence) - valence)[vertices[order]]
    step = np.arange(own.sum()) - np.repeat(np.cumsum(own) - own, own)
    return np.repeat(order, own), order[np.repeat(begin, own) + step]


class CornerNormals:
    """Finds the normals of every corner of some polygons, pose after pose.

    A corner averages the normals of the polygons around its vertex, weighted by area, but only of
    those that its own polygon meets at less than the crease angle. So a cheek is smooth and the
    edge of a tooth, a lid or a torn lip stays an edge.

    Args:
        faces: The polygons.
        pairs: Corners that are at one place, see `corner_pairs`.
        smooth: (P,) pairs that are smooth whatever their angle.
        crease: In degrees.
    """

    def __init__(
        self,
        faces: Polygons,
        pairs: tuple[NDArray[np.int64], NDArray[np.int64]],
        smooth: NDArray[np.bool_] | None = None,
        *,
        crease: float = 70.0,
    ) -> None:
        from scipy.sparse import csr_array

        self._faces = faces
        self._least = np.cos(np.radians(crease))
        order = np.argsort(pairs[0], kind="stable")
        receiving, giving = (corners[order] for corners in pairs)
        own, other = faces.corner_faces[receiving], faces.corner_faces[giving]
        self._smooth = None if smooth is None else smooth[order]
        # Two polygons meet at several corners, seen from both sides, and at one angle.
        keys = np.minimum(own, other) * len(faces) + np.maximum(own, other)
        keys, self._meeting = np.unique(keys, return_inverse=True)
        self._meets = np.divmod(keys, max(len(faces), 1))
        counts = np.bincount(receiving, minlength=faces.indices.size)
        begins = np.concatenate([[0], np.cumsum(counts)])
        shape = (faces.indices.size, len(faces))
        self._sums = csr_array((np.ones(len(other)), other, begins), shape=shape)

    def of(self, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
        """(C, 3) unit normals at (V, 3) positions; (0, 0, 1) at polygons without area."""
        of_face = polygon_normals(vertices, self._faces)
        units = _units(of_face)
        one, other = (units[numbers] for numbers in self._meets)
        alike = (np.einsum("ij,ij->i", one, other) > self._least)[self._meeting]
        self._sums.data[:] = alike if self._smooth is None else alike | self._smooth
        normals = _units(self._sums @ of_face)
        normals[~normals.any(axis=1)] = (0.0, 0.0, 1.0)
        return normals


def _units(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) vectors of length 1, those of no length as they are."""
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return vectors / np.where(lengths > 0, lengths, 1.0)[:, None]


# What the surface of a mesh looks like: one dress for each material, with its image.
#
# Where the file says what its materials look like, that; else the looks of the parts that their
# names speak of. Exporters cut vertices apart where texture coordinates end. For light and shade
# such a seam is none: corners at one place of the neutral count as corners of one vertex.

_SMOOTH = 0.15
"""Roughness below which a surface has a small, bright highlight, whatever its name."""
_MOST_ALIKE = 64
"""Corners at one place, beyond which it is no seam; their pairs would take too long."""


@dataclass(frozen=True, eq=False)
class Dress:
    """What some polygons look like.

    Attributes:
        polygons: (F_dress,) their numbers, rising.
        look: Colour, where there is no image, and highlight.
        image: (H, W, 3 or 4) sRGB and opacity, the first row at 0, if any.
        places: (C_dress, 2) where the corners of the polygons lie in the image, from 0 to 1.
        wrap: What is beside the image.
        smooth: Whether colours between its pixels are mixed.
        material: What the file says of opacity, sides and light, if anything.
    """

    polygons: NDArray[np.int64]
    look: Look
    image: NDArray[np.uint8] | None = None
    places: NDArray[np.float64] | None = None
    wrap: Wrap = "clamp"
    smooth: bool = True
    material: Material | None = None


def dresses_of(mesh: Mesh) -> list[Dress]:
    """What is to be drawn of a mesh, each polygon once at most.

    With an appearance every material is, white where nothing is said of it; an image that cannot be
    shown is warned of once. Without one, all parts are but the hidden ones.
    """
    if mesh.appearance is None:
        return _plain(mesh)
    labels = np.full(len(mesh.faces), -1) if mesh.materials is None else mesh.materials.of_face
    names = () if mesh.materials is None else mesh.materials.names
    dresses, problems = [], []
    for label in np.unique(labels).tolist():
        name = names[label] if label >= 0 else ""
        own = mesh.appearance.get(name)
        dress, problem = _dress(mesh, np.flatnonzero(labels == label), name, own)
        dresses.append(dress)
        if problem:
            problems.append((name, problem))
    warn_of(problems, mesh.name)
    return dresses


def welded_corners(mesh: Mesh) -> NDArray[np.int64]:
    """(C,) a number for the place of each corner of the polygons: the same at one place."""
    same: NDArray[np.int64] = np.unique(mesh.vertices, axis=0, return_inverse=True)[1].reshape(-1)
    corners = same[mesh.faces.indices]
    crowded = np.bincount(corners)[corners] > _MOST_ALIKE
    return np.where(crowded, len(same) + mesh.faces.indices, corners)


def _plain(mesh: Mesh) -> list[Dress]:
    parts = parts_of(mesh)
    drawn = {
        name: Dress(numbers, LOOKS[name]) for name, numbers in parts.items() if name != "hidden"
    }
    if "sclera" in drawn:
        white = parts["sclera"]
        own = [parts[name] for name in ("iris", "pupil") if name in parts]
        places = iris_coordinates(mesh, white, np.concatenate([white[:0], *own]))
        drawn["sclera"] = Dress(white, LOOKS["sclera"], eye_image(), places)
    return list(drawn.values())


def _dress(
    mesh: Mesh, polygons: NDArray[np.int64], name: str, material: Material | None
) -> tuple[Dress, str]:
    """The dress of one material, and why it lacks its image."""
    own = material or Material()
    kind = LOOKS.get(part_of_name(name), LOOKS["skin"])
    red, green, blue = encoded(np.array(own.colour[:3])).tolist()
    shine, polish = kind.shine, kind.polish
    if own.finish is not None and own.finish.roughness < _SMOOTH:  # as wet as an eye
        shine, polish = 0.9, 150.0
    look = Look((red, green, blue), shine, polish)
    image, problem = (None, "") if mesh.uv is None else pixels_of(own)
    if image is None or own.texture is None:
        return Dress(polygons, look, material=own), problem
    places = _places(mesh, polygons, own.texture)
    if own.opacity == "opaque":
        image[..., 3] = 255
    image, places, wrap = _wrapped(own.texture, image, places)
    smooth = own.texture.smooth
    return Dress(polygons, look, image[::-1], places, wrap, smooth, own), problem


def _places(mesh: Mesh, numbers: NDArray[np.int64], texture: Texture) -> NDArray[np.float64]:
    """(C_part, 2) where the corners of a part lie in its image, from the left and the bottom."""
    if mesh.uv is None:
        return np.zeros((0, 2))
    used = mesh.uv.corners[np.isin(mesh.faces.corner_faces, numbers)]
    if not len(mesh.uv.coordinates):
        return np.zeros((len(used), 2))
    found = mesh.uv.coordinates[np.maximum(used, 0), :2]
    return places_in(texture, np.where(used[:, None] < 0, 0.0, found))


def _wrapped(
    texture: Texture, image: NDArray[np.uint8], places: NDArray[np.float64]
) -> tuple[NDArray[np.uint8], NDArray[np.float64], Wrap]:
    """Image and places for a renderer that wraps both directions alike."""
    if texture.wrap[0] == texture.wrap[1]:
        return image, places, texture.wrap[0]
    for direction, wrap in enumerate(texture.wrap):
        if wrap == "mirror":
            axis = 1 - direction
            image = np.concatenate([image, np.flip(image, axis)], axis)
            places = places * ([0.5, 1] if direction == 0 else [1, 0.5])
            if direction == 1:  # rows count from the top, places from the bottom
                places = places + [0, 0.5]
        if wrap == "clamp":
            edge = 0.5 / image.shape[1 - direction]
            places = places.copy()
            places[:, direction] = np.clip(places[:, direction], edge, 1 - edge)
    return image, places, "repeat"
