"""What was captured, and its files."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.models import write_bundler, write_colmap
from elastomorph.capturing.geometry import Camera
from elastomorph.capturing.neutral import Painted
from elastomorph.capturing.work.registered import Registered
from elastomorph.errors import CaptureError
from elastomorph.io.atomic import made_folder, replacing
from elastomorph.io.npz.confidence import NAME as CONFIDENCE
from elastomorph.io.npz.confidence import write_confidence
from elastomorph.io.registry import write
from elastomorph.model.mesh import FaceLabels, Material, Texture
from elastomorph.rig import Rig

__all__ = ["CAMERAS", "CONFIDENCE", "FIGURES", "Captured", "write_captured"]

FIGURES = "capture.json"
CAMERAS = "cameras"
_SKIN = "skin"
_VERSION = 1


@dataclass(frozen=True, eq=False)
class Captured:
    """Poses of one topology, the cameras they were seen by, and what was measured.

    Attributes:
        poses: Pose → its mesh with the template's vertices, in the template's units, the head
            where it is in the neutral; empty where only cameras were asked for.
        cameras: Pose → the cameras of its photographs, in the same frame and units; those of
            cameras alone are in a frame and units of their own.
        photographs: Pose → photograph → file.
        neutral: Name of the pose that is the neutral.
        figures: What was measured, as in ``capture.json``.
        points: Pose → (N, 3) of the surface that its photographs show, in the frame of the cameras.
        textures: Material → what the photographs of the neutral show in the texture coordinates of
            the template; '' where it has no materials.
    """

    poses: Mapping[str, Registered]
    cameras: Mapping[str, tuple[Camera, ...]]
    photographs: Mapping[str, Mapping[str, Path]]
    neutral: str
    figures: Mapping[str, Any] = field(default_factory=dict)
    points: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    textures: Mapping[str, Painted] = field(default_factory=dict)

    def __repr__(self) -> str:
        count = sum(map(len, self.cameras.values()))
        return f"Captured({len(self.poses)} poses, {count} cameras)"


def write_captured(folder: Path, captured: Captured) -> list[Path]:
    """Write poses, their confidence and the figures, each file whole or not at all.

    Raises:
        FileError: A file cannot be written.
    """
    files = []
    for name, pose in captured.poses.items():
        files.append(folder / f"{name}.obj")
        write(files[-1], pose)
    if captured.poses:
        files.append(folder / CONFIDENCE)
        write_confidence(files[-1], {name: p.confidence for name, p in captured.poses.items()})
    files += _write_textures(folder, captured)
    for name, cameras in captured.cameras.items():
        _write_cameras(folder / CAMERAS, name, cameras, captured.points.get(name, np.zeros((0, 3))))
        files.append(folder / CAMERAS / name)
    files.append(folder / FIGURES)
    content = {
        "version": _VERSION,
        "neutral": captured.neutral,
        **as_json(captured.figures),
        "cameras": {
            pose: {
                camera.name: {
                    "file": _seen_from(folder, captured.photographs[pose][camera.name]),
                    **_described(camera),
                }
                for camera in cameras
            }
            for pose, cameras in captured.cameras.items()
        },
    }
    with replacing(files[-1]) as file:
        text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
        file.write(text.encode() + b"\n")
    return files


def textured(mesh: Registered, name: str, textures: Mapping[str, Painted]) -> Registered:
    """A pose whose materials show textures, if there are any, by the library of a name."""
    if not textures:
        return mesh
    none = FaceLabels((_SKIN,), np.zeros(len(mesh.faces), dtype=np.int32))
    images = {
        own or _SKIN: Material(texture=Texture(_png(painted.image), _file(name, own)))
        for own, painted in textures.items()
    }
    found = object.__new__(Registered)
    vars(found).update(
        vars(mesh),
        materials=mesh.materials or none,
        material_library=f"{name}.mtl",
        appearance={**(mesh.appearance or {}), **images},
    )
    return found


def _write_textures(folder: Path, captured: Captured) -> list[Path]:
    """Images, masks of what was seen, their library, and the neutral with all of it as GLB."""
    if not captured.textures:
        return []
    name, pose = captured.neutral, captured.poses[captured.neutral]
    contents = {}
    for own, painted in captured.textures.items():
        contents[_file(name, own)] = _png(painted.image)
        contents[_file(name, own, "_seen")] = _png(painted.seen * np.uint8(255))
    lines = []
    for own in pose.materials.names if pose.materials is not None else ():
        lines += [f"newmtl {own}", "Kd 1 1 1"]
        key = own if own in captured.textures else ""
        lines += [f"map_Kd {_file(name, key)}"] if key in captured.textures else []
    contents[f"{name}.mtl"] = "".join(f"{line}\n" for line in lines).encode()
    for file, content in contents.items():
        with replacing(folder / file) as opened:
            opened.write(content)
    write(folder / f"{name}.glb", Rig(pose, {}))
    return [folder / file for file in (*contents, f"{name}.glb")]


def _file(name: str, material: str, what: str = "") -> str:
    """The name of the image of a material."""
    plain = re.sub(r"[^\w.-]+", "_", material)
    return f"{name}_{plain}{what}.png" if plain else f"{name}{what}.png"


def _png(pixels: NDArray[np.uint8]) -> bytes:
    import cv2

    good, content = cv2.imencode(".png", pixels[..., ::-1] if pixels.ndim == 3 else pixels)
    if not good:
        raise CaptureError("OpenCV could not write a PNG")
    return content.tobytes()


def _write_cameras(
    folder: Path, name: str, cameras: Sequence[Camera], points: NDArray[np.float64]
) -> None:
    """As COLMAP has them, and as Bundler does where it can."""
    write_colmap(made_folder(folder) / name, cameras, points)
    with suppress(CaptureError):
        write_bundler(folder / f"{name}.out", cameras, points)


def as_json(value: Any) -> Any:
    """Figures as JSON has them: what is no number is null."""
    if isinstance(value, Mapping):
        return {str(key): as_json(own) for key, own in value.items()}
    if isinstance(value, list | tuple):
        return [as_json(own) for own in value]
    if isinstance(value, np.ndarray):
        return as_json(value.tolist())
    if isinstance(value, np.generic):
        return as_json(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


def _seen_from(folder: Path, file: Path) -> str:
    """A file as it is named from a folder: where a machine keeps both is nobody's business."""
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:  # on another drive of Windows
        return str(file)


def _described(camera: Camera) -> dict[str, Any]:
    return {
        "size": list(camera.size),
        "focal": camera.focal,
        "centre": camera.centre.tolist(),
        "radial": camera.radial,
        "rotation": camera.rotation.tolist(),
        "translation": camera.translation.tolist(),
    }
