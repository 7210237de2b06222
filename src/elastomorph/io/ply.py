"""Stanford PLY: vertices and polygons, as ASCII or binary of either byte order.

Only positions and polygons are read and written. Colours, normals, texture coordinates and
whatever else a file holds are passed over; materials and groups have no place in PLY.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import read_bytes, replacing
from elastomorph.io.ply_header import ENCODINGS, PlyHeader, read_header
from elastomorph.io.ply_rows import Column, read_columns
from elastomorph.io.untrusted import naming_file
from elastomorph.model.mesh import Mesh, Source
from elastomorph.model.polygons import Polygons

__all__ = ["read_ply", "write_ply"]

_CORNERS = ["vertex_indices", "vertex_index"]
_AXES = ["x", "y", "z"]
_LARGEST_INDEX = int(np.iinfo(np.int32).max)

Encoding = Literal["ascii", "binary_little_endian", "binary_big_endian"]


def read_ply(path: str | Path) -> Mesh:
    """The mesh in a PLY file.

    Args:
        path: The file. Without an element ``face`` it is a set of points.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: The content is not PLY, was cut off, or is not a mesh.
    """
    content = read_bytes(path)
    header = read_header(path, content)
    _require_mesh(path, header)
    columns = read_columns(path, content, header, {"vertex": _AXES, "face": _CORNERS})
    empty = Column(np.empty(0), np.empty(0, dtype=np.int64))
    axes = [columns.get(("vertex", axis), empty).values for axis in _AXES]
    faces = next((columns[key] for name in _CORNERS if (key := ("face", name)) in columns), empty)
    indices = faces.values
    if indices.size and (int(indices.min()) < 0 or int(indices.max()) > _LARGEST_INDEX):
        raise FormatError(path, "a polygon names a vertex below 0 or far beyond the last one")
    with naming_file(path):
        return Mesh(
            np.stack(axes, axis=1).astype(np.float64),
            Polygons(indices, np.concatenate([[0], np.cumsum(faces.sizes)])),
            source=Source(str(path)),
        )


def write_ply(path: str | Path, mesh: Mesh, encoding: Encoding = "binary_little_endian") -> None:
    """Write the vertices and polygons of a mesh as PLY, coordinates bit for bit.

    Args:
        path: The file; its folder must exist. A file that is there is replaced at once.
        mesh: The mesh. Its texture coordinates, materials and groups are not written.
        encoding: ``ascii``, ``binary_little_endian`` or ``binary_big_endian``. Positions are
            float64 (``double``), indices int32.

    Raises:
        FileError: The file cannot be written.
        ParameterError: Another encoding.
    """
    if encoding not in ENCODINGS:
        raise ParameterError(f"expected one of {', '.join(ENCODINGS)}, found {encoding!r}")
    sizes = mesh.faces.sizes
    count = "uchar" if sizes.max(initial=0) <= 255 else "int"
    header = [
        "ply",
        f"format {encoding} 1.0",
        f"element vertex {len(mesh.vertices)}",
        *(f"property double {axis}" for axis in _AXES),
        f"element face {len(mesh.faces)}",
        f"property list {count} int vertex_indices",
        "end_header\n",
    ]
    order = ENCODINGS[encoding]
    if order:
        counts = sizes.astype(np.dtype(order + ("u1" if count == "uchar" else "i4")))
        indices = mesh.faces.indices.astype(np.dtype(order + "i4"))
        positions = mesh.vertices.astype(np.dtype(order + "f8")).tobytes()
        body = positions + _interleaved(counts, indices, mesh.faces.offsets)
    else:
        rows = [f"{x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist()]
        rows += [f"{len(face)} {' '.join(map(str, face.tolist()))}\n" for face in mesh.faces]
        body = "".join(rows).encode("ascii")
    with replacing(path) as file:
        file.write("\n".join(header).encode("ascii") + body)


def _require_mesh(path: str | Path, header: PlyHeader) -> None:
    elements = {element.name: element for element in reversed(header.elements)}
    if "vertex" not in elements or not elements["vertex"].length:
        raise FormatError(path, "there are no vertices: the header announces no 'element vertex'")
    vertex = elements["vertex"].by_name
    for axis in _AXES:
        if axis not in vertex or vertex[axis].count is not None:
            raise FormatError(path, f"the vertices have no property '{axis}' that is a number")
    if "tristrips" in elements and elements["tristrips"].length:
        raise FormatError(
            path, "its polygons are triangle strips, which is not supported; export polygons"
        )
    if "face" in elements and elements["face"].length:
        face = elements["face"].by_name
        corners = next((face[name] for name in _CORNERS if name in face), None)
        if corners is None or corners.count is None or corners.kind.kind not in "iu":
            raise FormatError(
                path, "the faces have no list of whole numbers called 'vertex_indices'"
            )


def _interleaved(
    counts: NDArray[np.integer], indices: NDArray[np.integer], offsets: NDArray[np.int64]
) -> bytes:
    """Each polygon's count, then its indices, as they stand in the file."""
    before = np.arange(len(counts)) * counts.itemsize + offsets[:-1] * indices.itemsize
    corners = np.arange(indices.size) * indices.itemsize
    corners += np.repeat(np.arange(1, len(counts) + 1) * counts.itemsize, np.diff(offsets))
    body = np.empty(counts.nbytes + indices.nbytes, dtype=np.uint8)
    for places, values in ((before, counts), (corners, indices)):
        body[places[:, None] + np.arange(values.itemsize)] = values.view(np.uint8).reshape(
            -1, values.itemsize
        )
    return body.tobytes()
