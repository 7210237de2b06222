"""Takes as NumPy archives (.npz), written frame by frame so that no take is too long.

The archive is a mesh file of the neutral with ``frames`` (T, V, 3) float32 and ``times`` (T,)
beside it: `read_sequence` reads the take, `read` the neutral.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.io.atomic import replacing_path
from elastomorph.io.npz import write_npz
from elastomorph.model.mesh import Mesh

__all__ = ["write_npz_take"]


def write_npz_take(
    path: str | Path, mesh: Mesh, frames: Iterable[NDArray[np.floating]], times: ArrayLike
) -> None:
    """Write a take, whole or not at all, in the memory of one frame.

    Args:
        path: The file; its folder must exist.
        mesh: The neutral, with the polygons of all frames.
        frames: T positions (V, 3); each is used before the next is asked for.
        times: (T,) seconds.

    Raises:
        FileError: The file cannot be written.
        ParameterError: There are more or fewer frames than times, or one has another shape.
    """
    when = np.asarray(times, dtype=np.float64)
    shape = mesh.vertices.shape
    with replacing_path(path) as temporary:
        write_npz(temporary, mesh)
        with temporary.open("r+b") as file:
            with zipfile.ZipFile(file, "a") as archive:
                with archive.open(zipfile.ZipInfo("times.npy"), "w") as member:
                    np.lib.format.write_array(member, when, allow_pickle=False)
                info = zipfile.ZipInfo("frames.npy")  # of itself dated 1980
                with archive.open(info, "w", force_zip64=True) as member:
                    header = {"descr": "<f4", "fortran_order": False, "shape": (len(when), *shape)}
                    np.lib.format.write_array_header_1_0(member, header)
                    count = 0
                    for frame in frames:
                        if frame.shape != shape:
                            raise ParameterError(
                                f"frame {count} has the shape {frame.shape}, expected {shape}"
                            )
                        member.write(np.ascontiguousarray(frame, dtype="<f4").tobytes())
                        count += 1
            file.flush()
            os.fsync(file.fileno())
        if count != len(when):
            raise ParameterError(f"expected {len(when):,} frames, one a time, found {count:,}")
