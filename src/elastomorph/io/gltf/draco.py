"""Vertices and triangles packed with Draco: KHR_draco_mesh_compression.

A primitive names a stream, and by numbers its attributes in the stream; its accessors say what they
are, but have no bytes. Morph targets are no part of it: theirs are plain, in the order of the
vertices in the stream. Draco breaks or takes any amount of memory on damaged streams, so all those
of a file are unpacked in a process of its own.
"""

from __future__ import annotations

import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FileError, FormatError, MissingExtraError
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.io.npz.members import NpzMembers, write_arrays

EXTENSION = "KHR_draco_mesh_compression"

_TRIANGLES = "triangles"
_DRACO = IsolatedReader(
    worker="elastomorph.io.gltf.draco_worker",
    library="Draco",
    advice="export it again without compression",
)


def draco_values(file: GltfFile, number: int) -> NDArray[Any] | None:
    """(count, width) what Draco holds of an accessor without bytes; None for other ones."""
    if file.draco is None:
        file.draco = _all_values(file)
    return file.draco.get(number)


def _all_values(file: GltfFile) -> dict[int, NDArray[Any]]:
    """What Draco holds, by the numbers of the accessors that stand for it."""
    places: dict[int, tuple[int, str]] = {}  # of an accessor: its stream, and its name there
    streams: dict[int, memoryview] = {}  # by the number of its view
    for primitive in _primitives(file):
        of = "a primitive packed with Draco"
        own = file.object_in(file.object_in(primitive, "extensions", of), EXTENSION, of)
        numbers = file.object_in(own, "attributes", of)
        accessors = file.object_in(primitive, "attributes", of)
        named = {
            accessors[key]: str(file.whole_in(numbers, key, of))
            for key in numbers
            if type(accessors.get(key)) is int
        }
        if type(primitive.get("indices")) is not int:
            file.refuse(f"{of} has no indices")
        named[primitive["indices"]] = _TRIANGLES
        bare = [n for n in named if "bufferView" not in file.item("accessors", n, of)]
        if not bare:
            continue  # a plain copy is there too
        stream: Any = own.get("bufferView")
        streams[stream], _ = file.view(stream, of)
        for accessor in bare:
            places.setdefault(accessor, (stream, named[accessor]))
    return _unpacked(file, streams, places) if streams else {}


def _primitives(file: GltfFile) -> list[dict[str, Any]]:
    """All primitives of the document that name the extension."""
    return [
        primitive
        for mesh in file.items("meshes")
        if isinstance(mesh, dict)
        for primitive in file.list_in(mesh, "primitives", "a mesh")
        if isinstance(primitive, dict)
        and EXTENSION in file.object_in(primitive, "extensions", "a primitive")
    ]


def _unpacked(
    file: GltfFile, streams: dict[int, memoryview], places: dict[int, tuple[int, str]]
) -> dict[int, NDArray[Any]]:
    """The values of accessors, out of all streams together."""
    if find_spec("DracoPy") is None:
        raise MissingExtraError("DracoPy", "gltf")
    with tempfile.TemporaryDirectory(prefix="elastomorph-") as folder:
        packed = Path(folder) / "streams.npz"
        write_arrays(packed, {f"{n}": np.frombuffer(own, "u1") for n, own in streams.items()})
        try:
            with extracted(_DRACO, packed) as members:
                return {
                    accessor: _member(file, members, stream, name)
                    for accessor, (stream, name) in places.items()
                }
        except FileError as error:
            if error.path != packed:
                raise
            problem = str(error).removeprefix(f"{packed}: ")
            raise type(error)(file.path, problem) from error


def _member(file: GltfFile, members: NpzMembers, stream: int, name: str) -> NDArray[Any]:
    """(N, width) an attribute of a stream, or (N, 1) the corners of its triangles."""
    key = f"{stream}.{name}"
    if key not in members.names:
        raise FormatError(
            file.path,
            f"buffer view {stream}, packed with Draco, has no attribute {name[:40]}; the file is "
            "damaged or was written wrongly",
        )
    found = members.array(key, "fiu", (None, None))
    return found.reshape(-1, 1) if name == _TRIANGLES else found
