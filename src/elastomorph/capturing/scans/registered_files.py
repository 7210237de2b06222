"""The face that scans are given, without seams, and the files of what is registered.

Those of a pose are written together, or none of them. Poses that an earlier run left in the folder
stay, with their confidence and what was measured.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from shutil import rmtree
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Surface
from elastomorph.capturing.landmarks import known_landmarks
from elastomorph.capturing.scans.correspondence import outer
from elastomorph.capturing.scans.expressions import Expressions
from elastomorph.capturing.work.registered import Registered
from elastomorph.capturing.work.template import mesh_or_rig
from elastomorph.errors import CaptureError, FileError, FormatError
from elastomorph.io.atomic import (
    is_file,
    is_folder,
    made_folder,
    read_bytes,
    replacing_path,
    require_folder,
    same_file,
    unnoted,
)
from elastomorph.io.npz.confidence import NAME, read_confidence, write_confidence
from elastomorph.io.registry import read, write
from elastomorph.model.geometry import component_of, moved_extent, sides_of
from elastomorph.model.mesh import Mesh
from elastomorph.model.surface import triangulate
from elastomorph.paths.welding import Welding
from elastomorph.rig import Rig

Points = NDArray[np.float64]

# A part of at least this much of the largest one's area is skin; eyes, brows and lashes are less.
_SKIN = 0.15


@dataclass(frozen=True, eq=False)
class Face:
    """A template, prepared.

    Attributes:
        mesh: As it was given; the poses have its vertices and polygons.
        place: (V,) which vertex of the face without seams each of its vertices is.
        first: (W,) a vertex of the mesh for each of the face.
        vertices: (W, 3).
        triangles: (T, 3).
        size: Extent of what its targets move, or of all of it: the unit of errors.
        skin: (W,) which vertices a scan can show: outside, and of the largest parts.
        expressions: Its targets, if it is a rig.
        landmarks: Landmark → vertex, where they come with it.
    """

    mesh: Mesh
    place: NDArray[np.int64]
    first: NDArray[np.int64]
    vertices: Points
    triangles: NDArray[np.int64]
    size: float
    skin: NDArray[np.bool_]
    expressions: Expressions | None
    landmarks: Mapping[str, int]

    def vertices_of(self, landmarks: Mapping[str, int], where: str) -> Mapping[str, int]:
        """Landmark → vertex of the face, from those of the mesh, or what comes with it.

        Raises:
            FormatError: The mesh has no such vertex.
        """
        count = len(self.mesh.vertices)
        for name, vertex in landmarks.items():
            if vertex >= count:
                raise FormatError(
                    where,
                    f"{name} is vertex {vertex:,} of a template with {count:,}: the landmarks were"
                    " placed on another template",
                )
        own = landmarks or self.landmarks
        return {name: int(self.place[vertex]) for name, vertex in own.items()}


def read_face(source: str | Path | Mesh | Rig) -> Face:
    """A template from a file, a folder of meshes, ``built-in``, a mesh or a rig.

    Raises:
        FileError: It is missing or cannot be read.
        CaptureError: It has no surface.
    """
    given = source if isinstance(source, Mesh | Rig) else mesh_or_rig(source)
    mesh = given.neutral if isinstance(given, Rig) else given
    deltas = {name: given[name].delta for name in given.targets} if isinstance(given, Rig) else {}
    if not len(mesh.faces):
        raise CaptureError(f"the template {mesh.name} has no polygons: a template is a surface")
    targets = [mesh.vertices + delta for delta in deltas.values()]
    # Moved as a whole, every vertex counts; what no target tells apart at one place is one.
    welding = Welding.of(mesh, [*targets, mesh.vertices + mesh.diameter])
    work, first = welding.neutral, welding.first
    triangles = triangulate(work)[0].astype(np.int64)
    surface = Surface(work.vertices, triangles)
    expressions = None
    if deltas:
        own = np.array([delta[first] for delta in deltas.values()])
        expressions = Expressions(tuple(deltas), own)
    known = mesh.name if isinstance(source, Mesh | Rig) else source
    return Face(
        mesh,
        welding.place,
        first,
        work.vertices,
        triangles,
        moved_extent(mesh.vertices, targets) or mesh.diameter,
        outer(surface) & _skin(surface),
        expressions,
        known_landmarks(known, mesh),
    )


def _skin(surface: Surface) -> NDArray[np.bool_]:
    """(W,) vertices of the large parts."""
    count, own = len(surface.vertices), surface.triangles
    part = component_of(count, sides_of(own))
    areas = np.linalg.norm(surface.face_normals, axis=1)
    area = np.bincount(part[own[:, 0]], areas, minlength=int(part.max()) + 1)
    return np.asarray((area > _SKIN * area.max())[part])


FIGURES = "register.json"
_VERSION = 1
# What a run that has not ended yet keeps of each pose, and the next one reads if it never ends.
_KEPT = ".register"


def require_place(
    folder: str | Path, names: Iterable[str], inputs: Iterable[Path], template: str | Path
) -> None:
    """Refuse a folder for poses before they are made, without making it.

    Args:
        folder: Where they are to be.
        names: Of the poses.
        inputs: Files that no pose is to be written over.
        template: Whose vertices they are to have, as the poses of an earlier run there have.

    Raises:
        FileError: It is a file, cannot be written in, or a pose would be written over an input.
        FormatError: What an earlier run left there is damaged, or of another template.
    """
    place = Path(folder)
    if is_file(place / NAME) or is_folder(place / _KEPT):
        _earlier(place, len(read_face(template).mesh.vertices))
    kept = list(inputs)
    for file in (place / f"{name}.obj" for name in names):
        if over := next((own for own in kept if same_file(file, own)), None):
            raise FileError(
                file,
                f"the pose would be written over the input {over}; name another output, or add "
                "--overwrite",
            )
    require_folder(place)


def keep_pose(folder: str | Path, name: str, pose: Registered) -> None:
    """Write ``POSE.obj`` as soon as it is finished, with what `write_figures` gathers; or neither.

    Raises:
        FileError: A file cannot be written, or is one of those that were read.
    """
    there = is_folder(folder)
    place = made_folder(folder)
    try:
        files = place / f"{name}.obj", made_folder(place / _KEPT) / f"{name}.json"
        with ExitStack() as stack:
            mesh, record = (stack.enter_context(replacing_path(file)) for file in files)
            write(mesh, pose)
            _write_json(
                record,
                {**described({name: pose}), "confidence": {name: pose.confidence.tolist()}},
            )
    except BaseException:
        if not there:
            for folder in (place / _KEPT, place):
                with suppress(OSError):
                    folder.rmdir()
        raise


def write_figures(folder: str | Path, poses: Mapping[str, Registered]) -> None:
    """Write ``confidence.npz`` and ``register.json`` of kept poses, both or none.

    They are written once a run: rewritten at each of N poses they would take N² of time.

    Raises:
        FileError: A file cannot be written, or is one of those that were read.
        FormatError: What an earlier run left there is damaged, or of another template.
    """
    place = Path(folder)
    known, measured = _earlier(place, len(next(iter(poses.values())).vertices))
    known |= {name: own.confidence for name, own in poses.items()}
    facts = described(poses)
    facts["poses"] = {**measured, **facts["poses"]}
    with replacing_path(place / NAME) as confidence, replacing_path(place / FIGURES) as figures:
        write_confidence(confidence, known)
        _write_json(figures, facts)
    rmtree(place / _KEPT, ignore_errors=True)


def written_to(folder: str | Path, names: Iterable[str]) -> list[Path]:
    """The files of poses in a folder."""
    place = Path(folder)
    return [*(place / f"{name}.obj" for name in names), place / NAME, place / FIGURES]


def read_registered(folder: str | Path, template: Mesh) -> dict[str, Registered]:
    """The poses that an earlier run left in a folder, with what was measured of them.

    Raises:
        FormatError: They are damaged, or of another template.
    """
    confidence, measured = _earlier(Path(folder), len(template.vertices))
    found = {}
    with unnoted():
        for name, figures in measured.items():
            mesh = read(Path(folder) / f"{name}.obj")
            if len(mesh.vertices) == len(template.vertices):
                own = confidence[name]
                found[name] = Registered.of(template, mesh.vertices, own, figures)
    return found


def digest_of(*content: Any) -> str:
    """What tells arrays, texts and numbers from any others."""
    digest = hashlib.sha256()
    for own in content:
        if isinstance(own, np.ndarray):
            digest.update(f"{own.shape} {own.dtype}".encode() + np.ascontiguousarray(own).tobytes())
        else:
            digest.update(repr(own).encode() + b"\0")
    return digest.hexdigest()


def described(poses: Mapping[str, Registered]) -> dict[str, Any]:
    """What was measured of each pose, as in ``register.json``."""
    return {"version": _VERSION, "poses": {name: dict(own.figures) for name, own in poses.items()}}


def _earlier(
    place: Path, vertices: int
) -> tuple[dict[str, NDArray[np.floating]], dict[str, dict[str, Any]]]:
    """The confidence of the poses that are in a folder already, and what was measured of them."""
    file, measured = place / NAME, dict[str, Any]()
    confidence: dict[str, NDArray[np.floating]] = {}
    with unnoted():  # what is added to is no input
        if is_file(file):
            confidence.update(read_confidence(file))
        # A run that was killed has left a file for each of its poses.
        for path in (place / FIGURES, *sorted((place / _KEPT).glob("*.json"))):
            try:
                found = json.loads(read_bytes(path)) if is_file(path) else {"poses": {}}
                measured |= found["poses"]
                for name, values in found.get("confidence", {}).items():
                    confidence[name] = np.array(values, dtype=np.float32)
            except (ValueError, KeyError, TypeError, AttributeError) as problem:
                raise FormatError(
                    path,
                    "it is not what 'elastomorph register' writes: remove it, or name another"
                    " folder",
                ) from problem
    own = {name: values for name, values in confidence.items() if is_file(place / f"{name}.obj")}
    if other := next((name for name, values in own.items() if len(values) != vertices), None):
        raise FormatError(
            file,
            f"it has {len(own[other]):,} vertices for {other}, and the template has {vertices:,}:"
            " name another folder",
        )
    return own, {name: facts for name, facts in measured.items() if name in own}


def _write_json(path: Path, facts: Mapping[str, Any]) -> None:
    text = json.dumps(facts, indent=1, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")
