"""What a layer of bends goes over: a file with its meshes, its blend shapes, and their places."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.atomic import opened
from elastomorph.io.isolated import IsolatedReader
from elastomorph.io.joined_rig import Placing, RigPart
from elastomorph.io.npz.members import NpzMembers
from elastomorph.io.usd.exact import path_from_json
from elastomorph.io.usd.reader import ADVICE, members_of, parts_of, rig_of
from elastomorph.io.usd.scene import FoundMesh, FoundShape, found_meshes
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig

_READER = IsolatedReader("elastomorph.io.usd.layer_worker", "USD", ADVICE)


@dataclass(frozen=True, eq=False)
class OriginalShape:
    """A blend shape of the file."""

    name: str  # Of its morph in the rig
    prim: str  # Path of its prim
    place: str  # The same, inside the variants that it depends on
    unlisted: tuple[tuple[str, str], ...]  # Prims and variant sets that a layer must name
    variants: tuple[str, ...]  # As ``set=choice``
    instance: str | None  # The instance that it lies in
    found: FoundShape
    normals: NDArray[np.float64] | None  # (N, 3) offsets of the normals, where it has any

    @property
    def has_path(self) -> bool:
        """Whether it has in-betweens, or a bent path that elastomorph wrote."""
        path = path_from_json(self.found.path or "")
        return bool(len(self.found.weights)) or (path is not None and bool(path.curves))


@dataclass(frozen=True, eq=False)
class OriginalMesh:
    """A mesh of the file, and what it is of the rig."""

    path: str  # Of its prim
    mesh: Mesh  # As it is stored
    held: NDArray[np.float64] | None  # (N, 4, 3) what joints do to each point, if they differ
    part: RigPart  # Where these hold it at rest
    vertices: slice  # Of the rig
    shapes: tuple[OriginalShape, ...]

    @property
    def place(self) -> Placing:
        """From where its joints hold it to the rig."""
        return self.part.place

    def own(self, fields: NDArray[np.float64], points: NDArray[np.int64]) -> NDArray[np.float64]:
        """(K, N, 3) fields of the rig on these points, in the space of the mesh."""
        # a mesh that is scaled to a plane or a line has no inverse, but a nearest one
        found = fields
        if not self.place.is_identity:
            found = fields @ np.linalg.pinv(self.place.linear).T
        if self.held is not None:
            turns = np.linalg.pinv(self.held[points, :3])
            found = np.einsum("kni,nij->knj", found, turns)
        return np.array(found)


@dataclass(frozen=True, eq=False)
class OriginalFile:
    """The file that a layer of bends goes over."""

    path: Path
    digest: str  # SHA-256 of its content
    files: tuple[Path, ...]  # That it is composed of, itself the first
    header: str  # A layer, as text, of what a stage takes from its root layer alone
    meshes: tuple[OriginalMesh, ...]
    rig: Rig


def read_original(path: str | Path) -> OriginalFile:
    """The original in a file, or of a layer of bends that lies over it.

    Errors are those of `elastomorph.io.usd.reader.read_usd`, and a FormatError for a layer whose
    original is gone, or that holds more than bends.
    """
    with members_of(path, (), _READER) as members:
        content = json.loads(members.array("layer", "u", (None,)).tobytes())
        with _noted(Path(content["original"])) as original:
            found = found_meshes(path, members)
            parts = parts_of(path, found, members.budget)
            rig = rig_of(path, found, parts, members.budget)
            return OriginalFile(
                original,
                content["digest"],
                tuple(Path(name) for name in content["files"]),
                content["header"],
                tuple(_meshes(path, members, found, parts, content["meshes"])),
                rig,
            )


def original_of(path: str | Path) -> tuple[Path, tuple[Path, ...]]:
    """The file that a layer of bends lies over, and all files that it is composed of."""
    with members_of(path, ("files",), _READER) as members:
        content = json.loads(members.array("layer", "u", (None,)).tobytes())
    return Path(content["original"]), tuple(Path(name) for name in content["files"])


@contextmanager
def _noted(path: Path) -> Iterator[Path]:
    """The path of a file that counts as read."""
    with opened(path):
        yield path


def _meshes(
    path: str | Path,
    members: NpzMembers,
    found: list[FoundMesh],
    parts: list[RigPart],
    entries: list[dict[str, Any]],
) -> Iterator[OriginalMesh]:
    start = 0
    for i, (one, part, entry) in enumerate(zip(found, parts, entries, strict=True)):
        count = len(part.mesh.vertices)
        shapes = []
        for k, (name, own) in enumerate(zip(part.morphs, entry["shapes"], strict=True)):
            shape = one.shape(k, count)
            normals = None
            if f"{i}_shape_{k}_normals" in members.names:
                normals = members.array(f"{i}_shape_{k}_normals", "f", (None, 3))
                if normals.shape != shape.offsets[0].shape or not np.isfinite(normals).all():
                    raise FormatError(
                        path,
                        f"the normalOffsets of {own['prim']} do not fit its offsets; the file is "
                        "damaged or was written wrongly",
                    )
                normals = normals.astype(np.float64)
            lists = tuple((prim, name) for prim, name in own["unlisted"])
            shapes.append(
                OriginalShape(
                    name,
                    own["prim"],
                    own["place"],
                    lists,
                    tuple(own["variants"]),
                    own["instance"],
                    shape,
                    normals,
                )
            )
        vertices = slice(start, start + count)
        yield OriginalMesh(entry["path"], one.mesh, one.held, part, vertices, tuple(shapes))
        start += count
