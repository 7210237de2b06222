"""Data sets with pictures, written as what programs that train networks read.

``folder`` has a picture and a JSON file a face, ``coco`` the pictures and one file of annotations
with boxes and key points, ``webdataset`` tar files of a thousand faces each.
"""

from __future__ import annotations

import io
import json
import tarfile
from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.materials import parts_of
from elastomorph.draw.pictures import as_png
from elastomorph.errors import FileError, ParameterError
from elastomorph.io.atomic import made_folder, replacing
from elastomorph.model.geometry import fit_rotation, least_motion
from elastomorph.rig.rig import Rig

if TYPE_CHECKING:
    from elastomorph.farm.reading.faces import FaceSet

LAYOUTS = ("webdataset", "coco", "folder")
"""What `export_faces` writes."""

_AT_ONCE = 64
_SHARD = 1000
_EYE = ("sclera", "iris", "pupil")


def export_faces(
    faces: FaceSet,
    path: str | Path,
    to: str,
    *,
    progress: Callable[[str], object] = lambda _: None,
) -> list[Path]:
    """Write the pictures of a data set with their labels for training code.

    Labels of a face: ``weights`` of the sliders by name; ``box``, left, top, width and height in
    pixels of what the targets move; ``landmarks`` by name, x and y in pixels and 1 where they are
    seen; ``gaze`` of each eye whose ball is known by its material, a unit vector in the camera's
    axes; ``head``, ``camera`` and ``intrinsics`` as in the data set. Depth, normals and parts lie
    beside the picture, as they are stored. In all formats a face has one name, its number.

    Args:
        faces: A data set with pictures, finished.
        path: A folder, made where it is missing; it must be empty.
        to: ``webdataset``, ``coco`` or ``folder``.
        progress: Told how far it is.

    Returns:
        The files that say what there is: shards, annotations, or the JSON files.

    Raises:
        ParameterError: There is no such format, or the data set holds no pictures.
        FormatError: Some faces are not made yet.
        FileError: The folder is not empty, or cannot be written.
    """
    if to not in LAYOUTS:
        raise ParameterError(f"faces are exported to {', '.join(LAYOUTS)}, found {to!r}")
    samples = _samples(faces, progress)
    samples = chain([next(samples)], samples)  # what cannot be read makes no folder
    folder = made_folder(path)
    if any(folder.iterdir()):
        raise FileError(path, "there is something in this folder; name an empty or a new one")
    return {"folder": _folder, "coco": _coco, "webdataset": _webdataset}[to](folder, samples)


_Sample = tuple[str, dict[str, Any], dict[str, bytes]]


def _samples(faces: FaceSet, progress: Callable[[str], object]) -> Iterator[_Sample]:
    """Name, labels, and files by suffix of each face."""
    images = faces.as_images()
    if "colour" not in images.arrays:
        raise ParameterError("the pictures of this data set have no colour, so there is no picture")
    unit, count = faces.data.plan.unit, len(faces)
    faces.codes[np.minimum(np.arange(unit - 1, count + unit - 1, unit), count - 1)]  # all are made
    marks = images.arrays.get("landmarks")
    names = [] if marks is None else list(marks.attributes["names"])
    face, eyes = _moving(faces.rig), _eyes(faces.rig)

    def each() -> Iterator[_Sample]:
        for start in range(0, len(faces), _AT_ONCE):
            rows = slice(start, min(start + _AT_ONCE, len(faces)))
            block, positions = images[rows], faces[rows].astype(np.float64)
            for i, vertices in enumerate(positions):
                own = {name: values[i] for name, values in block.items()}
                labels = _labels(faces.rig, names, own, vertices, face, eyes)
                yield f"{start + i:09d}", {"face": start + i, **labels}, _files(own)
            progress(f"{rows.stop:,} of {len(faces):,} faces written")

    return each()


def _labels(
    rig: Rig,
    names: list[str],
    own: Mapping[str, NDArray[Any]],
    vertices: NDArray[np.float64],
    face: NDArray[np.int64],
    eyes: Mapping[str, NDArray[np.int64]],
) -> dict[str, Any]:
    height, width = own["colour"].shape[:2]
    seen = vertices[face]
    for step in ("head", "camera"):
        seen = seen @ own[step][:, :3].T + own[step][:, 3]
    points = seen @ own["intrinsics"].T
    points = points[:, :2] / points[:, 2:]
    # The middle of the first pixel is at 0, so the picture reaches from -½ to its size - ½.
    low, high = (
        np.clip(end + 0.5, 0, [width, height]) for end in (points.min(axis=0), points.max(axis=0))
    )
    turn = own["camera"][:, :3] @ own["head"][:, :3]
    gaze = {
        side: turn @ fit_rotation(rig.neutral.vertices[eye], vertices[eye])[0] @ [0.0, 0.0, 1.0]
        for side, eye in eyes.items()
    }
    return {
        "width": width,
        "height": height,
        "weights": dict(zip(rig.names, own["weights"].tolist(), strict=True)),
        "box": [*low.tolist(), *(high - low).tolist()],
        "landmarks": dict(zip(names, own["landmarks"].tolist(), strict=True)) if names else {},
        "gaze": {side: way.tolist() for side, way in gaze.items()},
        **{name: own[name].tolist() for name in ("head", "camera", "intrinsics")},
    }


def _moving(rig: Rig) -> NDArray[np.int64]:
    """The vertices of the face: what its targets move."""
    rest = rig.neutral.vertices
    most = np.zeros(len(rest))
    for morph in rig.morphs.values():
        np.maximum(most, np.linalg.norm(morph.delta, axis=1), out=most)
    targets = (morph.target.vertices for morph in rig.morphs.values())
    return np.flatnonzero(most > least_motion(rest, targets))


def _eyes(rig: Rig) -> dict[str, NDArray[np.int64]]:
    """The vertices of each eyeball, by the side of the person: left is +x."""
    mesh, parts = rig.neutral, parts_of(rig.neutral)
    polygons = np.concatenate([parts.get(name, np.zeros(0, np.int64)) for name in _EYE])
    vertices = np.unique(mesh.faces.indices[np.isin(mesh.faces.corner_faces, polygons)])
    if not len(vertices):
        return {}
    across = mesh.vertices[vertices, 0]
    across = across - (across.min() + across.max()) / 2
    sides = {"left": vertices[across > 0], "right": vertices[across < 0]}
    return {side: np.asarray(own, np.int64) for side, own in sides.items() if len(own) >= 4}


def _files(own: Mapping[str, NDArray[Any]]) -> dict[str, bytes]:
    found = {"png": as_png(own["colour"])}
    for name in ("depth", "normals", "parts"):
        if name in own:
            file = io.BytesIO()
            np.save(file, own[name])
            found[f"{name}.npy"] = file.getvalue()
    return found


def _folder(folder: Path, samples: Iterator[_Sample]) -> list[Path]:
    written = []
    for name, labels, files in samples:
        for suffix, content in files.items():
            _write(folder / f"{name}.{suffix}", content)
        written.append(_write(folder / f"{name}.json", json.dumps(labels).encode()))
    return written


def _coco(folder: Path, samples: Iterator[_Sample]) -> list[Path]:
    """As cocodataset.org describes key points: 2 is seen, 1 hidden, 0 outside of the picture."""
    images, annotations = [], []
    names: list[str] = []
    for name, labels, files in samples:
        for suffix, content in files.items():
            _write(made_folder(folder / "images") / f"{name}.{suffix}", content)
        number, (_, _, width, height) = labels["face"] + 1, labels["box"]
        names = list(labels["landmarks"])
        points = [
            [x + 0.5, y + 0.5, 1 + int(seen)]
            if 0 <= x + 0.5 <= labels["width"] and 0 <= y + 0.5 <= labels["height"]
            else [0, 0, 0]
            for x, y, seen in labels["landmarks"].values()
        ]
        images.append(
            {"id": number, "file_name": f"{name}.png"}
            | {side: labels[side] for side in ("width", "height")}
        )
        annotations.append(
            {"id": number, "image_id": number, "category_id": 1, "iscrowd": 0}
            | {"bbox": labels["box"], "area": width * height}
            | {"keypoints": [value for point in points for value in point]}
            | {"num_keypoints": sum(point[2] > 0 for point in points)}
            | {name: labels[name] for name in ("weights", "gaze", "head", "camera", "intrinsics")}
        )
    category = {"id": 1, "name": "face", "keypoints": names, "skeleton": []}
    table = {"images": images, "annotations": annotations, "categories": [category]}
    return [_write(folder / "annotations.json", json.dumps(table).encode())]


def _webdataset(folder: Path, samples: Iterator[_Sample]) -> list[Path]:
    written: list[Path] = []
    ended = object()
    first: Any = next(samples, ended)
    while first is not ended:
        file = folder / f"faces-{len(written):06d}.tar"
        with replacing(file) as output, tarfile.open(fileobj=output, mode="w") as tar:
            for _ in range(_SHARD):
                name, labels, files = first
                for suffix, content in (*files.items(), ("json", json.dumps(labels).encode())):
                    entry = tarfile.TarInfo(f"{name}.{suffix}")
                    entry.size = len(content)
                    tar.addfile(entry, io.BytesIO(content))
                first = next(samples, ended)
                if first is ended:
                    break
        written.append(file)
    return written


def _write(file: Path, content: bytes) -> Path:
    with replacing(file) as output:
        output.write(content)
    return file
