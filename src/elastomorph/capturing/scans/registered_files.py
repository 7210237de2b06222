"""The files of registered scans: all of them, or none."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

from elastomorph.capturing.work.registered import Registered
from elastomorph.errors import FileError
from elastomorph.io.atomic import is_folder, made_folder, replacing_path
from elastomorph.io.npz.confidence import NAME, write_confidence
from elastomorph.io.registry import write

__all__ = ["FIGURES", "described", "require_place", "write_registered"]

FIGURES = "register.json"
_VERSION = 1


def require_place(folder: str | Path, names: Iterable[str], inputs: Iterable[Path]) -> None:
    """Refuse a folder for poses before they are made, without making it.

    Args:
        folder: Where they are to be.
        names: Of the poses.
        inputs: Files that no pose is to be written over.

    Raises:
        FileError: It is a file, cannot be written in, or a pose would be written over an input.
    """
    place = Path(folder)
    kept = list(inputs)
    for file in (place / f"{name}.obj" for name in names):
        if over := next((own for own in kept if _same(file, own)), None):
            raise FileError(
                file,
                f"the pose would be written over the input {over}; name another output, or add "
                "--overwrite",
            )
    there = next((own for own in (place, *place.absolute().parents) if own.exists()), place)
    if not is_folder(there):
        raise FileError(place, f"{there} is a file; name a folder for the results")
    try:
        TemporaryFile(dir=there).close()
    except OSError as error:
        raise FileError(
            place, f"{there} cannot be written in ({error.strerror}); name another output"
        ) from error


def _same(file: Path, other: Path) -> bool:
    try:
        return file.samefile(other)
    except OSError:  # one of them is not there
        return False


def write_registered(folder: str | Path, poses: Mapping[str, Registered]) -> list[Path]:
    """Write ``POSE.obj``, ``confidence.npz`` and ``register.json`` into a folder, all or none.

    Raises:
        FileError: A file cannot be written, or is one of those that were read.
    """
    there = is_folder(folder)
    place = made_folder(folder)
    files = [*(place / f"{name}.obj" for name in poses), place / NAME, place / FIGURES]
    try:
        with ExitStack() as stack:
            *meshes, confidence, figures = [
                stack.enter_context(replacing_path(file)) for file in files
            ]
            for file, pose in zip(meshes, poses.values(), strict=True):
                write(file, pose)
            write_confidence(confidence, {name: own.confidence for name, own in poses.items()})
            text = json.dumps(described(poses), indent=1, ensure_ascii=False, allow_nan=False)
            figures.write_text(text + "\n", encoding="utf-8")
    except BaseException:
        if not there:
            with suppress(OSError):
                place.rmdir()
        raise
    return files


def described(poses: Mapping[str, Registered]) -> dict[str, Any]:
    """What was measured of each pose, as in ``register.json``."""
    return {"version": _VERSION, "poses": {name: dict(own.figures) for name, own in poses.items()}}
