"""How far each vertex of registered poses may be trusted: ``confidence.npz`` beside the poses.

One array a pose, by the name of the pose, which is that of its file without suffix: (V,) float32
from 0, not to be trusted, to 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import is_file, is_folder, require_name
from elastomorph.io.npz.members import open_npz, write_arrays
from elastomorph.numbers import as_numbers

NAME = "confidence.npz"


def confidence_beside(pattern: str | Path) -> Path | None:
    """The file of confidences in the folder of numbered mesh files, if it is there.

    Args:
        pattern: Frames as `read_sequence` takes them. An archive that holds all of them has none
            beside it.
    """
    require_name(pattern)
    path = Path(pattern)
    if is_folder(path):
        path /= NAME
    elif is_file(path) or is_file(str(path).rpartition("#")[0] or path):  # take.glb#NAME
        return None
    else:
        path = path.parent / NAME
    return path if is_file(path) else None


def read_confidence(
    path: str | Path, vertices: int | None = None
) -> dict[str, NDArray[np.float32]]:
    """The confidence of each pose by its name, (V,) float32 from 0 to 1.

    Args:
        path: The archive.
        vertices: V, where it is known.

    Raises:
        FileError: The file cannot be read.
        FormatError: It is no archive of such arrays, or one has another length.
    """
    found = {}
    with open_npz(path) as members:
        if not members.names:
            raise FormatError(path, "it holds no array; expected one for each pose")
        for name in sorted(members.names):
            values: NDArray[Any] = members.array(name, "f", (vertices,))
            try:
                found[name] = require_shares(values, name).astype(np.float32)
            except ParameterError as error:
                raise FormatError(path, str(error)) from None
            vertices = len(values)
    return found


def write_confidence(path: str | Path, poses: Mapping[str, ArrayLike]) -> None:
    """Write the confidence of each pose by its name, (V,) numbers from 0 to 1, whole or not at all.

    Raises:
        FileError: The file cannot be written.
        ParameterError: There is no pose, or numbers are not from 0 to 1, or of different lengths.
    """
    arrays = {
        name: require_shares(as_numbers(values, f"the confidence of {name!r}"), name)
        for name, values in poses.items()
    }
    if not arrays or len({own.shape for own in arrays.values()}) > 1:
        lengths = ", ".join(f"{name} {len(own):,}" for name, own in arrays.items())
        raise ParameterError(
            "confidences need at least one pose, and one number for each vertex in all of them; "
            f"found {lengths or 'none'}"
        )
    write_arrays(path, {name: own.astype(np.float32) for name, own in arrays.items()})


def require_shares(values: NDArray[Any], name: str) -> NDArray[Any]:
    """(V,) numbers from 0 to 1, or a ParameterError that says which is none."""
    if values.ndim != 1:
        raise ParameterError(
            f"the confidence of {name!r} needs one number for each vertex, found the shape "
            f"{values.shape}"
        )
    with np.errstate(invalid="ignore"):
        wrong = np.flatnonzero(~((values >= 0) & (values <= 1)))
    if len(wrong):
        raise ParameterError(
            f"the confidence of {name!r} must be numbers from 0 to 1, found "
            f"{float(values[wrong[0]]):g} for vertex {wrong[0]:,}"
        )
    return values
