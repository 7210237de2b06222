"""The page where landmarks are placed: served until somebody has finished, or written as a file.

What the page of landmarks is to do: photographs, a template and scans to place points on.

Of surfaces it reads what is drawn, and the author's vertices.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.models import SolvedPose
from elastomorph.capturing.geometry import Camera
from elastomorph.capturing.landmarks import (
    LANDMARKS,
    Landmarks,
    known_landmarks,
    parse_landmarks,
    write_landmarks,
)
from elastomorph.capturing.photographs import find_poses, opened_photograph
from elastomorph.capturing.work.stages import WorkingFolder
from elastomorph.capturing.work.template import read_template
from elastomorph.errors import FileError, FormatError, MeshError, ParameterError
from elastomorph.io.atomic import is_folder, read_bytes, replacing, size_of
from elastomorph.io.scan_colours import dressed, vertex_colours
from elastomorph.model.mesh import Mesh, Texture
from elastomorph.model.polygons import Polygons
from elastomorph.viewer.listening import HTML, Answer, Offer, Receiver, Resource, Sent, text
from elastomorph.viewer.page import (
    alone_head,
    built_page,
    filled,
    json_block,
    require_web_page,
    served_policy,
)
from elastomorph.viewer.server import ViewerServer

_MOST_EDGES = 400_000  # more of them would cover the surface


@dataclass(frozen=True, eq=False)
class PackedSurface:
    """A surface to be sent.

    Attributes:
        content: A header in JSON with its length before it, then arrays, little-endian: positions
            about an origin, texture coordinates, the author's vertex of each of ours, triangles,
            edges, colours.
        images: Contents of the image files that its parts show, by number.
    """

    content: bytes
    images: tuple[bytes, ...]


def pack_surface(
    mesh: Mesh, *, edges: bool, colours: NDArray[np.uint8] | None = None
) -> PackedSurface:
    """A mesh with its textures.

    Args:
        mesh: With polygons.
        edges: Whether the edges of its polygons are sent too.
        colours: (V, 3) of the vertices, red first.

    Raises:
        MeshError: There are no polygons.
    """
    if not len(mesh.faces):
        raise MeshError(f"{mesh.name} has points but no polygons: there is no surface to click on")
    sources, corners, uv = _split(mesh)
    images, image_of_face = _images(mesh)
    corner_triangles = Polygons(np.arange(mesh.faces.indices.size), mesh.faces.offsets).triangles()
    image_of_triangle = image_of_face[mesh.faces.corner_faces[corner_triangles[:, 0]]]
    order = np.argsort(image_of_triangle, kind="stable")
    triangles = corners[corner_triangles[order]]
    used = mesh.vertices[mesh.faces.indices]
    origin = (used.min(axis=0) + used.max(axis=0)) / 2
    lines = _lines(mesh, sources) if edges else np.empty((0, 2), np.uint32)
    header = {
        "vertices": len(sources),
        "triangles": len(triangles),
        "edges": len(lines),
        "origin": origin.tolist(),
        "uv": uv is not None,
        "colours": colours is not None,
        "parts": _parts_by_image(image_of_triangle[order]),
    }
    arrays = [(mesh.vertices[sources] - origin).astype("<f4")]
    arrays += [] if uv is None else [uv.astype("<f4")]
    arrays += [sources.astype("<u4"), triangles.astype("<u4"), lines.astype("<u4")]
    if colours is not None:
        arrays.append(np.c_[colours, np.full(len(colours), 255)].astype(np.uint8)[sources])
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    content = struct.pack("<I", len(text)) + text + b"".join(each.tobytes() for each in arrays)
    return PackedSurface(content, images)


def _split(
    mesh: Mesh,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64] | None]:
    """Vertices once for each of their texture coordinates: of the author's, by corner, and these.

    Coordinates are those on the image, after the transform of its material; None where no image is
    shown.
    """
    indices = mesh.faces.indices.astype(np.int64)
    textures = _textures(mesh)
    if mesh.uv is None or mesh.materials is None or not any(textures):
        return np.arange(len(mesh.vertices)), indices, None
    chosen = mesh.uv.corners.astype(np.int64)
    coordinates = np.vstack([mesh.uv.coordinates[:, :2], [[0.0, 0.0]]])[chosen]
    # Materials may show the same coordinates at different places of their images.
    labels = mesh.materials.of_face[mesh.faces.corner_faces].astype(np.int64)
    for label, texture in enumerate(textures):
        if texture is not None:
            own = labels == label
            coordinates[own] = _transformed(texture, coordinates[own])
    pairs = indices * (len(mesh.uv.coordinates) + 1) + chosen
    pairs = pairs * (len(textures) + 1) + labels
    _, first, corners = np.unique(pairs, return_index=True, return_inverse=True)
    return indices[first], corners.reshape(-1), coordinates[first]


def _transformed(texture: Texture, uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where coordinates are on the image, v from its bottom."""
    cos, sin = np.cos(texture.rotation), np.sin(texture.rotation)
    from_top = np.c_[uv[:, 0], 1 - uv[:, 1]] * texture.scale
    turned = from_top @ np.array([[cos, -sin], [sin, cos]]) + texture.offset
    return np.stack([turned[:, 0], 1 - turned[:, 1]], axis=1)


def _textures(mesh: Mesh) -> list[Texture | None]:
    """The texture of each material, where its image is at hand."""
    if mesh.materials is None or not mesh.appearance:
        return []
    looks = [mesh.appearance.get(name) for name in mesh.materials.names]
    return [
        look.texture if look and look.texture and look.texture.image else None for look in looks
    ]


def _images(mesh: Mesh) -> tuple[tuple[bytes, ...], NDArray[np.int64]]:
    """The images of a mesh, each once, and which of them each polygon shows; -1 for none."""
    images: dict[bytes, int] = {}
    textures = _textures(mesh)
    number = [
        -1 if texture is None else images.setdefault(texture.image, len(images))
        for texture in textures
    ]
    of_face = np.full(len(mesh.faces), -1)
    if number and mesh.materials is not None and mesh.uv is not None:
        of_face = np.array([*number, -1])[mesh.materials.of_face]
    return tuple(images), of_face


def _parts_by_image(image_of_triangle: NDArray[np.int64]) -> list[dict[str, int]]:
    """Corners in a row that show one image."""
    starts = np.flatnonzero(np.diff(image_of_triangle, prepend=-2))
    ends = np.append(starts[1:], len(image_of_triangle))
    return [
        {
            "start": int(3 * start),
            "count": int(3 * (end - start)),
            "image": int(image_of_triangle[start]),
        }
        for start, end in zip(starts, ends, strict=True)
    ]


def _lines(mesh: Mesh, sources: NDArray[np.int64]) -> NDArray[np.int64]:
    """Edges of the polygons, between vertices of ours."""
    if len(mesh.edges) > _MOST_EDGES:
        return np.empty((0, 2), np.int64)
    own = np.zeros(len(mesh.vertices), np.int64)
    own[sources] = np.arange(len(sources))
    return own[mesh.edges]


ASKED = 3
"""Photographs that each point is asked for in."""

_SHOWN = (".jpg", ".jpeg", ".png", ".tif", ".tiff")

Kind = Literal["photograph", "template", "scan"]


@dataclass(frozen=True, eq=False)
class LandmarkPlace:
    """One thing to place points on.

    Attributes:
        kind: A photograph, the template, or a scan.
        name: Of the file, without its folder.
        pose: What a photograph is of; empty for surfaces.
        content: File of a photograph, or a surface.
        camera: That took a photograph, if it is known.
    """

    kind: Kind
    name: str
    pose: str
    content: Path | PackedSurface
    camera: Camera | None = None


@dataclass(frozen=True, eq=False)
class LandmarkTask:
    """Where points are to be placed, and those that are known already.

    Attributes:
        title: What the page is called.
        places: Photographs and surfaces, in the order of the page.
        known: Points that were placed before, also on what is not shown.
    """

    title: str
    places: tuple[LandmarkPlace, ...]
    known: Landmarks = field(default_factory=Landmarks)

    def document(self, sources: Sequence[str], images: Sequence[Sequence[str]]) -> dict[str, Any]:
        """What the page is told.

        Args:
            sources: Address of each photograph and surface.
            images: Addresses of the images of each surface.
        """
        return {
            "version": 1,
            "title": self.title,
            "names": list(LANDMARKS),
            "words": dict(LANDMARKS),
            "asked": ASKED,
            "places": [
                {
                    "kind": place.kind,
                    "name": place.name,
                    "pose": place.pose,
                    "source": source,
                    "images": list(own),
                    "camera": None if place.camera is None else _described(place.camera),
                }
                for place, source, own in zip(self.places, sources, images, strict=True)
            ],
            "known": {
                "version": 1,
                "vertices": self.known.vertices,
                "photographs": self.known.photographs,
                "points": self.known.points,
            },
        }


def landmark_task(
    files: Sequence[str | Path] = (),
    template: str | Path | None = None,
    *,
    known: Landmarks | None = None,
    cameras: Mapping[str, Sequence[Camera]] | None = None,
) -> LandmarkTask:
    """Photographs, a template and scans to place points on.

    Args:
        files: Folders of photographs, and scans: meshes of any topology.
        template: The mesh whose vertices are to be named: a file, the neutral of a rig, or
            ``built-in`` for our own head. Points that come with it are known.
        known: Points that were placed before.
        cameras: Those of the photographs by pose, where they are known.

    Raises:
        ParameterError: There is nothing to place points on, or two of one name.
        FileError: Something is not there or cannot be read.
    """
    known = known or Landmarks()
    places = [place for file in files for place in _of_file(Path(file), cameras or {})]
    if template is not None:
        mesh = dressed(read_template(template))
        _require_vertices(known.vertices, mesh)
        if not known.vertices:
            found = known_landmarks(template, mesh)
            known = replace(known, vertices=found)
        content = pack_surface(mesh, edges=True)
        places.insert(0, LandmarkPlace("template", Path(template).name, "", content))
    if not places:
        raise ParameterError(
            "there is nothing to place points on; name photographs, a scan or a template"
        )
    keys = [(place.kind, place.pose, place.name) for place in places]
    for key in keys:
        if keys.count(key) > 1:
            raise ParameterError(
                f"{key[1] or 'what is shown'} has two files called {key[2]}; rename one of them"
            )
    return LandmarkTask(_title(files, template), tuple(places), known)


def solved_cameras(working: str | Path) -> dict[str, tuple[Camera, ...]]:
    """The cameras of each pose that are solved in the working folder of a capture.

    Raises:
        FileError: There are none.
    """
    folder = WorkingFolder(Path(working))
    found: dict[str, tuple[Camera, ...]] = {}
    for file in sorted(folder.folder.glob("cameras/*.npz")):
        made = folder.known(f"cameras/{file.stem}")
        solved = None if made is None else made.read()
        if isinstance(solved, SolvedPose):
            found[file.stem] = solved.cameras
    if not found:
        raise FileError(
            working,
            "no cameras are solved in it; name the working folder of 'elastomorph capture', or "
            "place the points without it",
        )
    return found


def _of_file(path: Path, cameras: Mapping[str, Sequence[Camera]]) -> list[LandmarkPlace]:
    if not is_folder(path):
        mesh = dressed(read_template(path))
        content = pack_surface(mesh, edges=False, colours=vertex_colours(mesh))
        return [LandmarkPlace("scan", path.name, "", content)]
    poses = find_poses(path)
    if len(poses) == 1 and next(iter(poses.values()))[0].parent == path:
        # One pose of several, whose folder is its name, whatever its photographs are called.
        poses = {path.resolve().name: next(iter(poses.values()))}
    for file in (file for photographs in poses.values() for file in photographs):
        if file.suffix.lower() not in _SHOWN:
            with opened_photograph(file):
                pass  # phones' own formats are refused, with what to do
    solved = {(pose, camera.name): camera for pose, own in cameras.items() for camera in own}
    return [
        LandmarkPlace("photograph", file.name, pose, file, solved.get((pose, file.name)))
        for pose, photographs in poses.items()
        for file in photographs
    ]


def _require_vertices(vertices: Mapping[str, int], mesh: Mesh) -> None:
    for name, vertex in vertices.items():
        if vertex >= len(mesh.vertices):
            raise FormatError(
                mesh.name,
                f"the landmark {name} is vertex {vertex:,}, and this template has "
                f"{len(mesh.vertices):,} vertices; name the template that the landmarks are of",
            )


def _title(files: Sequence[str | Path], template: str | Path | None) -> str:
    names = [Path(file).resolve().name for file in files]
    names += [] if template is None else [Path(template).name]
    return " and ".join(names) if len(names) < 4 else f"{names[0]} and {len(names) - 1} others"


def _described(camera: Camera) -> dict[str, Any]:
    return {
        "focal": camera.focal,
        "centre": [float(value) for value in camera.centre],
        "radial": camera.radial,
        "rotation": [float(value) for value in camera.rotation.reshape(-1)],
        "translation": [float(value) for value in camera.translation],
    }


_PAGE = "landmarks_page"
_FINISHED = "finish"
_MOST_IN_A_PAGE = 350_000_000  # bytes; as text they are a third more
_ADDRESS = "landmarks.json"
_KINDS = {".png": "image/png"}
_NOT_SHOWN = (".tif", ".tiff")


def serve_landmarks(task: LandmarkTask, file: str | Path, port: int = 0) -> ViewerServer:
    """A server that shows the page and writes what is placed; enter it with ``with``.

    The file is written again after every change, whole. Its `wait` ends when somebody has pressed
    the button that says so.

    Args:
        task: What points are placed on.
        file: The file of landmarks.
        port: Port of 127.0.0.1; a free one for 0.

    Raises:
        ParameterError: The port is taken or not allowed.
        FileError: The page was not built.
    """
    resources: dict[str, Offer] = {}
    sources: list[str] = []
    images: list[list[str]] = []
    for number, place in enumerate(task.places):
        kind, loads, own = _parts(place)
        sources.append(f"place-{number}")
        images.append([f"place-{number}-{image}" for image in range(len(own))])
        resources[sources[-1]] = Resource(kind, loads)
        for address, image in zip(images[-1], own, strict=True):
            resources[address] = Resource(_image_kind(image), image)
    saving = {"save": _ADDRESS, "file": Path(file).name}
    page = filled(built_page(_PAGE), _block(task, sources, images, saving))
    resources[""] = Resource(HTML, page.encode(), served_policy(page))

    def receive(sent: Sent) -> Answer:
        placed = parse_landmarks(file, sent.read())
        # Those are not placed in the page, and stay what they were.
        write_landmarks(file, replace(placed, distances=task.known.distances))
        return Answer(text("saved"), finished=sent.words == _FINISHED)

    resources[_ADDRESS] = Receiver(receive)
    return ViewerServer(resources, port)


def write_landmark_page(path: str | Path, task: LandmarkTask, file: str = _ADDRESS) -> None:
    """Write the page with all photographs and surfaces in it; what is placed is downloaded.

    Args:
        path: The page, ``.html``; its folder must exist.
        task: What points are placed on.
        file: What the download is called.

    Raises:
        FormatError: The suffix is another.
        ParameterError: The photographs are more than browsers open in a page.
        FileError: The page cannot be written, or was not built.
    """
    require_web_page(path)
    total = sum(size_of(each.content) for each in task.places if isinstance(each.content, Path))
    if total > _MOST_IN_A_PAGE:
        raise ParameterError(
            f"{path}: a page with all {total / 1e6:,.0f} MB of photographs is more than browsers "
            f"open; name fewer, {_MOST_IN_A_PAGE / 1e6:,.0f} MB at most, or have it served"
        )
    sources = [f"#place-{number}" for number in range(len(task.places))]
    parts = [_parts(place) for place in task.places]
    images = [
        [f"{source}-{image}" for image in range(len(own))]
        for source, (_, _, own) in zip(sources, parts, strict=True)
    ]
    page = built_page(_PAGE)
    block = _block(task, sources, images, {"save": None, "file": file})
    before, _, after = filled(page, f"{alone_head(page)}\n{block}").partition("</head>")
    with replacing(path) as unfinished:
        unfinished.write(before.encode())
        # One after another: all photographs together may be more than there is memory.
        for source, addresses, (_, loads, own) in zip(sources, images, parts, strict=True):
            content = loads if isinstance(loads, bytes) else loads()
            for address, each in [(source, content), *zip(addresses, own, strict=True)]:
                text = base64.b64encode(each)
                opening = f'<script type="application/octet-stream" id="{address[1:]}">'
                unfinished.write(opening.encode() + text + b"</script>\n")
        unfinished.write(f"</head>{after}".encode())


def _parts(place: LandmarkPlace) -> tuple[str, Any, tuple[bytes, ...]]:
    """Kind of a place, its content or what loads it, and the images that belong to it."""
    if isinstance(place.content, PackedSurface):
        return "application/octet-stream", place.content.content, place.content.images
    suffix = place.content.suffix.lower()
    loads = _as_jpeg if suffix in _NOT_SHOWN else read_bytes
    return _KINDS.get(suffix, "image/jpeg"), partial(loads, place.content), ()


def _as_jpeg(photograph: Path) -> bytes:
    """A photograph in a format that browsers do not show, pixel for pixel."""
    from PIL import Image

    from elastomorph.capturing.photographs import read_upright

    content = BytesIO()
    Image.fromarray(read_upright(photograph)).save(content, "JPEG", quality=95, subsampling=0)
    return content.getvalue()


def _image_kind(content: bytes) -> str:
    return "image/png" if content.startswith(b"\x89PNG") else "image/jpeg"


def _block(
    task: LandmarkTask,
    sources: Sequence[str],
    images: Sequence[Sequence[str]],
    saving: Mapping[str, str | None],
) -> str:
    document = {**task.document(sources, images), **saving}
    return json_block("elastomorph-landmarks", json.dumps(document, allow_nan=False))
