"""Writes a repaired copy of a rig, and proves it: what would be written is read and examined again.

A repair that does not take away what it was made for, or brings something new, is not written.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastomorph.doctor.examining import examine
from elastomorph.doctor.findings import Examination, Finding
from elastomorph.doctor.settings import ExaminationSettings
from elastomorph.errors import FileError, ParameterError
from elastomorph.io import read, write
from elastomorph.io.atomic import read_bytes, replacing, temporary_name
from elastomorph.model.mesh import Mesh

_SUFFIX = ".obj"
# What only a comparison with other targets tells is not asked of a file alone.
_AMONG_OTHERS = frozenset({"noise"})


@dataclass(frozen=True)
class Repair:
    """What was written."""

    folder: str  # where
    # File and what was done to it; each was read back and examined again.
    repaired: tuple[tuple[str, tuple[str, ...]], ...]
    # Files that were right already, copied byte for byte; the meshes of a rig, written as OBJ.
    copied: tuple[str, ...]
    left_out: tuple[str, ...]  # files that could not be repaired
    refused: tuple[tuple[str, str], ...] = ()  # file and why its repair was not written


def repair(examination: Examination, folder: str | Path) -> Repair:
    """Write the rig as it should be into another folder; the files examined are never touched.

    Args:
        examination: What was found. The neutral and targets of a rig file are written as OBJ.
        folder: Made if it does not exist; the folder it lies in must.

    Raises:
        FileError: A file cannot be written, or does not read back as it was written.
        FormatError: A label or a texture coordinate cannot be written in the format of the file.
        ParameterError: The folder holds a file examined, two files have one name, the neutral is
            beyond repair, or there is nothing to repair in a rig.
    """
    place = Path(folder)
    names = _names(examination, place)
    if examination.neutral in examination.beyond_repair:
        raise ParameterError(
            f"{examination.neutral} does not fit its targets and cannot be repaired, so there is "
            "no rig to write; mend it first"
        )
    if examination.meshes and not examination.repaired:
        raise ParameterError(
            f"there is nothing to repair in {examination.neutral}, so nothing is written"
        )
    file, meshes = examination.neutral, examination.meshes
    mended = examination.repaired.get(file)
    neutral = mended.mesh if mended else meshes[file] if meshes else read(file)
    if not place.is_dir():
        try:
            place.mkdir()
        except OSError as error:
            raise FileError(place, f"the folder cannot be made: {error.strerror}") from error
    repaired, copied, refused = [], [], []
    for file, name in names.items():
        mended = examination.repaired.get(file)
        if file in examination.beyond_repair:
            continue
        if mended is None:
            if meshes:
                write(place / name, meshes[file])
            else:
                with replacing(place / name) as copy:
                    copy.write(read_bytes(file))
            copied.append(file)
        elif why_not := _written(mended.mesh, place / name, neutral, examination, file):
            refused.append((file, why_not))
        else:
            repaired.append((file, mended.done))
    left_out = examination.beyond_repair
    return Repair(str(place), tuple(repaired), tuple(copied), left_out, tuple(refused))


def _names(examination: Examination, place: Path) -> dict[str, str]:
    """What each file is called in the new folder."""
    files = (examination.neutral, *examination.targets)
    names = [Path(file).name for file in files]
    if examination.meshes:
        names = [f"{name}{_SUFFIX}" for name in ("neutral", *examination.targets)]
        bad = next((name for name in names if Path(name).name != name or "\0" in name), None)
        if bad is not None:
            raise ParameterError(
                f"the target {bad.removesuffix(_SUFFIX)!r} of {examination.neutral} cannot be the "
                "name of a file; rename it in the rig"
            )
    twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        raise ParameterError(f"two files are called {twice}; they cannot both go to {place}")
    for file in files if place.exists() and not examination.meshes else ():
        if place.resolve() == Path(file).resolve().parent:
            raise ParameterError(
                f"--repair {place} is the folder of {file}; name another, so that nothing is lost"
            )
    return dict(zip(files, names, strict=True))


def _written(mesh: Mesh, goes_to: Path, neutral: Mesh, examination: Examination, file: str) -> str:
    """Write a mesh if what is read back is sound; otherwise say why not."""
    trial = temporary_name(goes_to)
    try:
        write(trial, mesh)
        again = read(trial)
        if not np.array_equal(again.vertices, mesh.vertices) or again.faces != mesh.faces:
            raise FileError(goes_to, "the file does not read back as it was written")
        if file != examination.neutral:
            settings = ExaminationSettings(thresholds=examination.settings.thresholds)
            found = examine(neutral, [(file, again)], settings).findings
            worse = _worse([f for f in found if f.file == file], examination, file)
            if worse is not None:
                return f"it would still be found to have {worse.title} ({worse.message})"
        trial.replace(goes_to)
    finally:
        trial.unlink(missing_ok=True)
    return ""


def _worse(found: Iterable[Finding], examination: Examination, file: str) -> Finding | None:
    """What is still wrong with a file after its repair, or was not wrong before."""
    before = {
        f.name: len(f.vertices)
        for f in examination.findings
        if f.file == file and f.severity != "error"
    }
    for one in found:
        if one.name in _AMONG_OTHERS:
            continue
        meant = one.name == "moves-the-head" and examination.settings.steady
        if one.severity == "error" or meant or len(one.vertices) > before.get(one.name, -1):
            return one
    return None
