"""Where results go, looked at before any work; nothing is made there until all else is known."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from os import PathLike
from pathlib import Path

from elastomorph.capturing.work.captured import CAMERAS, CONFIDENCE, FIGURES
from elastomorph.capturing.work.template import Template
from elastomorph.errors import FileError, ParameterError
from elastomorph.io.atomic import require_folder, same_file

WORKING = ".capture"

_BYTES_BEFORE, _BYTES_A_POSE = 100 << 20, 40 << 20


def folder_named(named: object, what: str) -> Path:
    """A folder that is named by an argument.

    Raises:
        ParameterError: It names none.
    """
    if not isinstance(named, str | PathLike) or str(named) == "":
        raise ParameterError(f"{what} must name a folder, found {named!r}")
    return Path(named)


def require_place(
    output: Path, working: Path, poses: Mapping[str, object], template: Template | None
) -> None:
    """Refuse folders that cannot be written in, hold something else, or have too little room.

    Args:
        output: Of the result.
        working: Of what stages leave.
        poses: What is written of each.
        template: That is not written over.

    Raises:
        FileError: And what to do.
    """
    source = None if template is None else template.mesh.source
    for file in () if source is None else _meshes(output, poses):
        if source is not None and same_file(file, source.path):
            raise FileError(
                file,
                "it is the template, over which the pose would be written; name another output",
            )
    require_folder(output)
    _require_own(output, working, poses)
    needed = _BYTES_BEFORE + _BYTES_A_POSE * len(poses)
    free = shutil.disk_usage(require_folder(working)).free
    if free < needed:
        raise FileError(
            working,
            f"{free >> 20:,} MiB are free on its disk, about {needed >> 20:,} are needed: make "
            "room, or name another working folder",
        )


def _require_own(output: Path, working: Path, poses: Mapping[str, object]) -> None:
    """Refuse an output in which files of something else are, or would be written over."""
    there = (file for file in output.glob("*.obj") if not file.name.startswith("."))
    strange = sorted(file.name for file in there if file.stem not in poses)
    if strange:
        raise FileError(
            output,
            f"{strange[0]} is already there and is none of the poses; delete it, or name another "
            "output",
        )
    if working.exists() or (output / FIGURES).exists():  # of an earlier run
        return
    for file in (*_meshes(output, poses), output / CONFIDENCE, output / CAMERAS):
        if file.exists():
            raise FileError(
                file,
                "it is already there and not from a capture; move it away, or name another output",
            )


def _meshes(output: Path, poses: Mapping[str, object]) -> list[Path]:
    return [output / f"{pose}{suffix}" for suffix in (".obj", ".glb", ".mtl") for pose in poses]
