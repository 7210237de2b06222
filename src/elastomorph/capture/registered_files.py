"""The files of registered scans: all of them, or none."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from elastomorph.capture.registered import Registered
from elastomorph.io.atomic import is_folder, made_folder, replacing_path
from elastomorph.io.npz.confidence import NAME, write_confidence
from elastomorph.io.registry import write

__all__ = ["FIGURES", "described", "write_registered"]

FIGURES = "register.json"
_VERSION = 1


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
