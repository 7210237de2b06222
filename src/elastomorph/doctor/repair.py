"""Writes a repaired copy of a rig, and proves it: every repaired file is read back and compared."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastomorph.doctor.examination import Examination
from elastomorph.errors import FileError, ParameterError
from elastomorph.io import read, write
from elastomorph.io.atomic import read_bytes, replacing
from elastomorph.mesh import require_same_topology

__all__ = ["Repair", "repair"]


@dataclass(frozen=True)
class Repair:
    """What was written.

    Attributes:
        folder: Where.
        repaired: File and what was done to it; each was read back and is right.
        copied: Files that were right already, copied byte for byte.
        left_out: Files that could not be repaired.
    """

    folder: str
    repaired: tuple[tuple[str, tuple[str, ...]], ...]
    copied: tuple[str, ...]
    left_out: tuple[str, ...]


def repair(examination: Examination, folder: str | Path) -> Repair:
    """Write the rig as it should be into another folder; the files examined are never touched.

    Args:
        examination: What was found.
        folder: Made if it does not exist; the folder it lies in must.

    Raises:
        FileError: A file cannot be written, or does not read back as it was written.
        FormatError: A label or a texture coordinate cannot be written in the format of the file.
        ParameterError: The folder holds a file examined, or two files have one name.
    """
    place = Path(folder)
    files = [examination.neutral, *examination.targets]
    names = [Path(file).name for file in files]
    twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        raise ParameterError(f"two files are called {twice}; they cannot both go to {place}")
    for file in files:
        if place.exists() and place.resolve() == Path(file).resolve().parent:
            raise ParameterError(
                f"--repair {place} is the folder of {file}; name another, so that nothing is lost"
            )
    if not place.is_dir():
        try:
            place.mkdir()
        except OSError as error:
            raise FileError(place, f"the folder cannot be made: {error.strerror}") from error
    neutral = read(examination.neutral)
    repaired, copied = [], []
    for file in files:
        goes_to = place / Path(file).name
        if file in examination.beyond_repair:
            continue
        if file not in examination.repaired:
            with replacing(goes_to) as copy:
                copy.write(read_bytes(file))
            copied.append(file)
            continue
        mended = examination.repaired[file]
        write(goes_to, mended.mesh)
        again = read(goes_to)
        require_same_topology(neutral, again)
        if not np.array_equal(again.vertices, mended.mesh.vertices):
            raise FileError(goes_to, "the file does not read back as it was written")
        repaired.append((file, mended.done))
    return Repair(str(place), tuple(repaired), tuple(copied), examination.beyond_repair)
