"""The solved cameras of one pose, what was found of its surface on the way, and their file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera
from elastomorph.errors import FormatError
from elastomorph.io.atomic import opened, replacing

__all__ = ["SolvedPose", "load_solved", "save_solved"]

_VERSION = 1
_ARRAYS = {"lens": (4,), "rotations": (3, 3), "translations": (3,), "sizes": (2,)}


@dataclass(frozen=True, eq=False)
class SolvedPose:
    """Cameras and points of one pose, in a frame and a unit of their own.

    Attributes:
        cameras: those found, in the order of the photographs' names.
        points: (N, 3) seen by at least three photographs.
        descriptors: (N, 128) float32 of length 1, mean look of each point.
        reprojection: photograph → mean distance of its features from where their points are
            seen, px.
        rejected: photograph → why it is not used.
        lenses: photograph → what took it; the same text, the same lens.
        remarks: sentences about what is unusual without being an error.
    """

    cameras: tuple[Camera, ...]
    points: NDArray[np.float64]
    descriptors: NDArray[np.float32]
    reprojection: Mapping[str, float]
    rejected: Mapping[str, str] = field(default_factory=dict)
    lenses: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    def camera(self, name: str) -> Camera | None:
        """The camera of a photograph, None where it is not used."""
        return next((camera for camera in self.cameras if camera.name == name), None)


def save_solved(path: str | Path, solved: SolvedPose) -> None:
    """Write a solved pose to an ``.npz`` file, whole or not at all.

    Raises:
        FileError: It cannot be written.
    """
    words = {
        "version": _VERSION,
        "names": [camera.name for camera in solved.cameras],
        "reprojection": dict(solved.reprojection),
        "rejected": dict(solved.rejected),
        "lenses": dict(solved.lenses),
        "remarks": list(solved.remarks),
    }
    lens = [(c.focal, c.centre[0], c.centre[1], c.radial) for c in solved.cameras]
    count = len(solved.cameras)
    with replacing(path) as file:
        np.savez(
            file,
            words=np.array(json.dumps(words)),
            sizes=np.array([c.size for c in solved.cameras], dtype=np.int64).reshape(count, 2),
            lens=np.array(lens, dtype=np.float64).reshape(count, 4),
            rotations=np.array([c.rotation for c in solved.cameras]).reshape(count, 3, 3),
            translations=np.array([c.translation for c in solved.cameras]).reshape(count, 3),
            points=solved.points,
            descriptors=solved.descriptors.astype(np.float32),
        )


def load_solved(path: str | Path) -> SolvedPose:
    """Read what `save_solved` wrote.

    Raises:
        FileError: It cannot be read.
        FormatError: It is no such file.
    """
    try:
        with opened(path) as file, np.load(file, allow_pickle=False) as found:
            words = json.loads(str(found["words"]))
            arrays = {name: np.asarray(found[name]) for name in (*_ARRAYS, "points", "descriptors")}
        names = list(words["names"])
        for name, shape in _ARRAYS.items():
            if arrays[name].shape != (len(names), *shape):
                raise ValueError(f"{name} has shape {arrays[name].shape}")
        points, descriptors = arrays["points"], arrays["descriptors"]
        if points.shape != (len(points), 3) or descriptors.shape != (len(points), 128):
            raise ValueError("points and descriptors do not fit each other")
        if words["version"] != _VERSION:
            raise ValueError(f"it has version {words['version']}, expected {_VERSION}")
        cameras = tuple(
            Camera(
                str(name),
                (int(size[0]), int(size[1])),
                float(lens[0]),
                lens[1:3],
                float(lens[3]),
                rotation,
                translation,
            )
            for name, size, lens, rotation, translation in zip(
                names,
                arrays["sizes"],
                arrays["lens"],
                arrays["rotations"],
                arrays["translations"],
                strict=True,
            )
        )
        return SolvedPose(
            cameras,
            points,
            descriptors,
            {str(k): float(v) for k, v in words["reprojection"].items()},
            {str(k): str(v) for k, v in words["rejected"].items()},
            {str(k): str(v) for k, v in words["lenses"].items()},
            tuple(str(remark) for remark in words["remarks"]),
        )
    except (KeyError, ValueError, TypeError, AttributeError, EOFError, BadZipFile) as problem:
        raise FormatError(
            path, f"these are no solved cameras ({problem}); delete it and they are solved again"
        ) from problem
