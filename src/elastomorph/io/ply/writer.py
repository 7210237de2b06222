"""Writes PLY: positions bit for bit, and polygons."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.io.atomic import replacing
from elastomorph.io.ply.header import ENCODINGS
from elastomorph.model.mesh import Mesh

__all__ = ["write_ply"]

Encoding = Literal["ascii", "binary_little_endian", "binary_big_endian"]


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
        *(f"property double {axis}" for axis in "xyz"),
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


def _interleaved(
    counts: NDArray[np.integer], indices: NDArray[np.integer], offsets: NDArray[np.int64]
) -> bytes:
    """Each polygon's count, then its indices, as they stand in the file."""
    raw = indices.view(np.uint8).reshape(-1, indices.itemsize)
    before = np.repeat(offsets[:-1] * indices.itemsize, counts.itemsize)
    return np.insert(raw.ravel(), before, counts.view(np.uint8)).tobytes()
