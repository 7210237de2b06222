"""The polygon mesh every other part works on: immutable, in the order its author gave it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import MeshError, ParameterError, TopologyError
from elastomorph.model.geometry import largest_distance
from elastomorph.model.polygons import Polygons
from elastomorph.numbers import as_numbers, first_few

# What the materials of a mesh look like: base colours, textures, opacity, finish.

Wrap = Literal["repeat", "mirror", "clamp"]
Opacity = Literal["opaque", "mask", "blend"]
Layer = Literal["bumps", "glow", "finish", "creases", "shade"]

WHITE = (1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False, repr=False)
class Texture:
    """An image on a surface, by the texture coordinates of the mesh.

    Where a point of the surface has the coordinates (u, v), v from the bottom of the image, it
    shows the image at ``offset + R(rotation) · scale · (u, 1 - v)``, counted from the top.

    Attributes:
        image: The content of an image file, not decoded; empty where there is none to be had.
        name: What the image is called, for messages.
        problem: Why there is no image.
        wrap: What is beside the image, across and down.
        offset: Where the transform puts the corner of the image.
        rotation: In radians, counter-clockwise as seen on the image.
        scale: By how much coordinates are multiplied, across and down.
        smooth: Whether colours between pixels are mixed.
    """

    image: bytes
    name: str
    problem: str = ""
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)
    smooth: bool = True

    def __repr__(self) -> str:
        return f"Texture({self.name!r}, {len(self.image):,} bytes)"


@dataclass(frozen=True)
class Toon:
    """Light and shade as two flat colours with an edge between: MToon, of VRM.

    Attributes:
        shade: The colour in shade, linear; that in light is the base colour.
        shift: What is added to the cosine between surface and light.
        toony: How sharp the edge is: 1 for a line, 0 for a slope over all cosines.
        covers: Whether what blends hides what is behind it and drawn later.
        queue: What blends is drawn in this order, lower numbers first.
    """

    shade: tuple[float, float, float] = (0.0, 0.0, 0.0)
    shift: float = 0.0
    toony: float = 0.9
    covers: bool = False
    queue: int = 0


@dataclass(frozen=True)
class Finish:
    """How a surface takes light, beside its base colour.

    Attributes:
        roughness: From 0, a mirror, to 1.
        metal: 1 where it reflects in its own colour and in no other way.
        glow: Light of its own, linear red, green and blue.
        bump: How high the bumps are.
        crease: How dark the creases are, to 1.
        layers: Images, which numbers and colours are multiplied with: ``bumps`` is a normal map,
            ``glow`` in sRGB, ``finish`` has roughness in green and metal in blue, ``creases`` are
            in red, ``shade`` is that of a toon, in sRGB.
        toon: Where light and shade are flat.
    """

    roughness: float = 1.0
    metal: float = 0.0
    glow: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bump: float = 1.0
    crease: float = 1.0
    layers: Mapping[Layer, Texture] = field(default_factory=dict, hash=False)
    toon: Toon | None = None


@dataclass(frozen=True)
class Material:
    """How a surface looks in even light.

    Attributes:
        colour: Red, green, blue and opacity from 0 to 1, the colours linear as light is; what the
            texture is multiplied with.
        texture: The base colour, in sRGB, if it is an image.
        opacity: ``opaque``; ``mask`` shows what reaches the cutoff and nothing of the rest;
            ``blend`` lets shine through what is behind.
        cutoff: The least opacity that a mask shows.
        double_sided: Whether it is seen from behind too.
        unlit: Whether light and shade leave it as it is.
        finish: How it takes light beside that, as the viewer shows it.
    """

    colour: tuple[float, float, float, float] = WHITE
    texture: Texture | None = None
    opacity: Opacity = "opaque"
    cutoff: float = 0.5
    double_sided: bool = False
    unlit: bool = False
    finish: Finish | None = None

    @property
    def plain(self) -> bool:
        """Whether it is grey all over, as materials are that nobody has looked after."""
        red, green, blue, alpha = self.colour
        return self.texture is None and red == green == blue and alpha == 1.0


LARGEST = 1e75
"""The largest coordinate of a mesh: products of four lengths, as in a squared area, are numbers."""

_MOST_SHOWN = 12


@dataclass(frozen=True, eq=False)
class UVMap:
    """Texture coordinates and which of them each polygon corner uses.

    Attributes:
        coordinates: (T, 2) or (T, 3) float64.
        corners: (C,) int32, an index into ``coordinates`` for each corner of ``Mesh.faces``,
            or -1 where a corner has none.
    """

    coordinates: NDArray[np.float64]
    corners: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class FaceLabels:
    """One name for each polygon: its material, or its group.

    Attributes:
        names: The names, in order of first use.
        of_face: (F,) int32, an index into ``names`` for each polygon, or -1 for none.
    """

    names: tuple[str, ...]
    of_face: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Source:
    """Where a mesh was read from, for messages.

    Attributes:
        path: The file as the user named it.
        face_lines: (F,) line number of each polygon, where the format has lines.
        encoding: How the names of labels and the material library stand in a text file, so that
            it can be written again with the same bytes.
        split: Whether its format repeats a vertex wherever its texture coordinate or normal ends.
    """

    path: str
    face_lines: NDArray[np.int32] | None = None
    encoding: Literal["utf-8", "latin-1"] = "utf-8"
    split: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """Vertices and polygons. Nothing reorders, merges or triangulates them.

    Attributes:
        vertices: (V, 3) float64, read-only. Any unit of length.
        faces: Polygons of three or more vertices; empty for a set of markers.
        uv: Texture coordinates, if any.
        materials: Material of each polygon, if any.
        groups: Group of each polygon, if any.
        material_library: The material file an OBJ names, if any.
        source: The file it came from, if any.
        appearance: What its materials look like, by their names, where the file says so.
        copyright: Whose it is and its licence, in one line; files that are written say so.

    Raises:
        MeshError: Coordinates are not finite (V, 3) numbers up to `LARGEST` with V ≥ 1, or a
            polygon names a vertex that does not exist.
    """

    vertices: NDArray[np.float64]
    faces: Polygons = field(default_factory=lambda: Polygons([], [0]))
    uv: UVMap | None = None
    materials: FaceLabels | None = None
    groups: FaceLabels | None = None
    material_library: str | None = None
    source: Source | None = None
    appearance: Mapping[str, Material] | None = None
    copyright: str = ""

    def __init__(
        self,
        vertices: ArrayLike,
        faces: Polygons | ArrayLike | Sequence[Sequence[int]] = (),
        uv: UVMap | None = None,
        materials: FaceLabels | None = None,
        groups: FaceLabels | None = None,
        material_library: str | None = None,
        source: Source | None = None,
        appearance: Mapping[str, Material] | None = None,
        copyright: str = "",
    ) -> None:
        own = as_vertices(vertices)
        polygons = Polygons.of(faces)
        if polygons.indices.size:
            bad = (polygons.indices >= len(own)) | (polygons.indices < 0)
            if bad.any():
                corner = int(np.argmax(bad))
                raise MeshError(
                    f"polygon {polygons.corner_faces[corner]} names vertex "
                    f"{polygons.indices[corner]}, but the mesh has {len(own):,} vertices "
                    f"(0 to {len(own) - 1:,})"
                )
        for labels in (materials, groups):
            if labels is not None and labels.of_face.shape != (len(polygons),):
                raise MeshError("materials and groups need one entry for each polygon")
        if uv is not None and uv.corners.shape != polygons.indices.shape:
            raise MeshError("texture coordinates need one entry for each polygon corner")
        vars(self).update(  # frozen, so that nothing can be set by its name
            vertices=own, faces=polygons, uv=uv, materials=materials, groups=groups
        )
        vars(self).update(material_library=material_library, source=source)
        vars(self).update(appearance=appearance, copyright=copyright)

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices):,} vertices, {len(self.faces):,} polygons)"

    @property
    def name(self) -> str:
        """The file the mesh came from, or a plain word where there is none."""
        return self.source.path if self.source else "mesh"

    def with_vertices(self, vertices: ArrayLike) -> Mesh:
        """The same polygons and labels at other positions.

        Args:
            vertices: (V, 3), as many as the mesh has.

        Raises:
            MeshError: Another number of vertices, or coordinates that are not finite.
        """
        own = as_vertices(vertices)
        if own.shape != self.vertices.shape:
            raise MeshError(f"expected {len(self.vertices):,} vertices, found {len(own):,}")
        copy = object.__new__(Mesh)
        vars(copy).update(vars(self), vertices=own)  # polygons were checked; edges stay true
        vars(copy).pop("diameter", None)
        return copy

    @cached_property
    def edges(self) -> NDArray[np.int32]:
        """(E, 2) int32: every edge once, smaller index first, in ascending order."""
        start = self.faces.indices.astype(np.int64)
        end = start[self.faces.next_corners] if start.size else start
        low, high = np.minimum(start, end), np.maximum(start, end)
        # Sorting and comparing neighbours is several times faster than np.unique on large meshes.
        keys = np.sort((low * len(self.vertices) + high)[low != high])
        keys = keys[np.append(True, keys[1:] != keys[:-1])] if keys.size else keys
        return np.stack(np.divmod(keys, len(self.vertices)), axis=1).astype(np.int32)

    @cached_property
    def diameter(self) -> float:
        """D of Eq. 35: the largest distance between two vertices."""
        return largest_distance(self.vertices)


def as_vertices(vertices: ArrayLike) -> NDArray[np.float64]:
    """A read-only float64 copy of (V, 3) coordinates, V ≥ 1 and none beyond `LARGEST`."""
    try:
        own = np.array(as_numbers(vertices, "vertices"))
    except ParameterError as error:
        raise MeshError(f"{error}; they have the shape (V, 3)") from None
    if own.ndim != 2 or own.shape[1] != 3 or len(own) == 0:
        raise MeshError(f"vertices must have shape (V, 3) with V ≥ 1, found {own.shape}")
    usable = (np.abs(own) <= LARGEST).all(axis=1)
    if not usable.all():
        first = int(np.argmin(usable))
        raise MeshError(
            f"vertex {first} has the coordinates {own[first].tolist()}; every coordinate must be "
            f"a finite number, at most {LARGEST:g} ({int((~usable).sum())} vertices are not)"
        )
    own.flags.writeable = False
    return own


def part_of(mesh: Mesh, vertices: NDArray[np.integer]) -> Mesh:
    """The polygons between some of the vertices, which are numbered anew, with their labels."""
    new_index = np.full(len(mesh.vertices), -1)
    new_index[vertices] = np.arange(len(vertices))
    kept = [number for number, face in enumerate(mesh.faces) if (new_index[face] >= 0).all()]
    faces = [new_index[mesh.faces[number]] for number in kept]
    materials, groups = (
        None if own is None else FaceLabels(own.names, own.of_face[kept])
        for own in (mesh.materials, mesh.groups)
    )
    return Mesh(mesh.vertices[vertices], faces, materials=materials, groups=groups)


def require_mesh(value: object, what: str) -> None:
    """Raise MeshError where something is no mesh; of a file's name it says to read the file."""
    if not isinstance(value, Mesh):
        file = isinstance(value, str | PathLike)
        read = f"{str(value)!r}; read the file first: em.read({str(value)!r})"
        raise MeshError(f"{what} must be a Mesh, found {read if file else type(value).__name__}")


def require_same_topology(neutral: Mesh, target: Mesh) -> None:
    """Raise TopologyError, with the first polygon that differs, where two meshes do not match."""
    require_mesh(neutral, "the neutral")
    require_mesh(target, "the target")
    if len(neutral.vertices) != len(target.vertices):
        found = (
            f"{target.name} has {len(target.vertices):,} vertices, {neutral.name} has "
            f"{len(neutral.vertices):,}"
        )
    elif neutral.faces != target.faces:
        found = f"{target.name} and {neutral.name} have different polygons"
    else:
        return
    raise TopologyError(
        f"{found}: {_first_difference(neutral, target)}. A target must have the vertices and "
        "polygons of its neutral, in the same order"
    )


def _first_difference(neutral: Mesh, target: Mesh) -> str:
    ours, theirs = neutral.faces, target.faces
    for face in range(min(len(ours), len(theirs))):
        if not np.array_equal(ours[face], theirs[face]):
            line = ""
            if target.source is not None and target.source.face_lines is not None:
                line = f" (line {target.source.face_lines[face]:,})"
            return (
                f"the first polygon that differs is {face:,}{line}, "
                f"{_corners_shown(theirs[face])} instead of {_corners_shown(ours[face])}"
            )
    if len(ours) != len(theirs):
        return f"{len(theirs):,} polygons instead of {len(ours):,}"
    return "the polygons are the same"


def _corners_shown(polygon: NDArray[np.int32]) -> str:
    """The corners of a polygon, at most the first twelve of them."""
    return f"[{first_few(polygon.tolist(), _MOST_SHOWN)}]"
