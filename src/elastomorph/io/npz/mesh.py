"""NumPy archives (.npz): meshes and recorded motion, complete and bit for bit.

A mesh is stored as ``vertices`` (V, 3), ``face_indices`` (C,) and ``face_offsets`` (F + 1,), and
where it has them ``uv_coordinates`` (T, 2 or 3) and ``uv_corners`` (C,), ``material_names`` and
``material_of_face`` (F,), ``group_names`` and ``group_of_face`` (F,), ``material_library``,
``copyright``, and ``name_encoding`` where names were Latin-1. A sequence has ``frames``
(T, V, 3), ``times`` (T,), ``names`` and ``missing`` in place of ``vertices``. Polygons may be left
out, and a sequence may leave out all but its frames. `elastomorph.io.sequences` reads archives of
markers. Many faces in one file, .npy or .npz, are written block by block.
"""

from __future__ import annotations

import math
import os
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Literal

import numpy as np
from numpy.lib import format as npy
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import replacing, replacing_path, require_room
from elastomorph.io.npz.members import NpzMembers, open_npz, write_arrays
from elastomorph.io.untrusted import naming_file
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.model.polygons import Polygons
from elastomorph.model.sequence import MeshSequence

Blocks = Iterable[NDArray[np.floating]]


def write_face_array(
    path: str | Path,
    blocks: Blocks,
    shape: tuple[int, int, int],
    *,
    beside: Mapping[str, NDArray[np.generic]] | None = None,
) -> None:
    """Write (S, V, 3) float32 faces that come in (s, V, 3) blocks, one in memory at a time.

    ``.npy`` takes the faces alone, ``.npz`` the faces as ``vertices``, not compressed, and beside
    them further arrays by name, such as the weights.
    """
    suffix = Path(path).suffix.lower()
    require_room(path, 4 * math.prod(shape), f"{shape[0]:,} faces of {shape[1]:,} vertices")
    if suffix == ".npy":
        with replacing(path) as file:
            _write_npy(path, file, blocks, shape)
    elif suffix == ".npz":
        with replacing(path) as file, zipfile.ZipFile(file, "w") as archive:
            for name, array in (beside or {}).items():
                with archive.open(f"{name}.npy", "w") as member:
                    npy.write_array(member, np.asarray(array), allow_pickle=False)
            with archive.open("vertices.npy", "w", force_zip64=True) as member:
                _write_npy(path, member, blocks, shape)
    else:
        raise FormatError(path, f"many faces go into .npy or .npz, not into '{suffix}'")


def _write_npy(
    path: str | Path, file: IO[bytes], blocks: Blocks, shape: tuple[int, int, int]
) -> None:
    npy.write_array_header_2_0(file, _header(shape))
    written = 0
    for block in blocks:
        if block.shape[1:] != shape[1:]:
            raise FormatError(path, f"a block has shape {block.shape}, expected (…, {shape[1]}, 3)")
        file.write(np.ascontiguousarray(block, dtype="<f4").data)
        written += len(block)
    if written != shape[0]:
        raise FormatError(path, f"{written:,} faces came, {shape[0]:,} were expected")


def write_npz_take(
    path: str | Path,
    mesh: Mesh,
    frames: Blocks,
    times: ArrayLike,
    *,
    names: Sequence[str] = (),
    kind: str = "<f4",
) -> None:
    """Write a take, whole or not at all, in the memory of one frame.

    The archive is a mesh file of the neutral with ``frames`` (T, V, 3), float32 or of the kind
    given, ``times`` (T,) and the names of frames that have any: `read_sequence` reads the take,
    `read` the neutral. Each frame is used before the next is asked for.
    """
    beside = {"times": np.asarray(times, dtype=np.float64)}
    beside |= {"names": np.array(names, dtype=np.str_)} if names else {}
    shape = mesh.vertices.shape
    whole = (len(beside["times"]), *shape)
    size = np.dtype(kind).itemsize * math.prod(whole)
    require_room(path, size, f"{whole[0]:,} frames of {whole[1]:,} vertices")
    with replacing_path(path) as temporary:
        write_npz(temporary, mesh)
        count = 0
        with temporary.open("r+b") as file:
            with zipfile.ZipFile(file, "a") as archive:
                for name, array in beside.items():
                    with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w") as member:
                        npy.write_array(member, array, allow_pickle=False)
                info = zipfile.ZipInfo("frames.npy")  # of itself dated 1980
                with archive.open(info, "w", force_zip64=True) as member:
                    npy.write_array_header_1_0(member, _header(whole, kind))
                    for count, frame in enumerate(frames, start=1):
                        if frame.shape != shape:
                            problem = f"has the shape {frame.shape}, expected {shape}"
                            raise ParameterError(f"frame {count - 1} {problem}")
                        member.write(np.ascontiguousarray(frame, dtype=kind).tobytes())
            file.flush()
            os.fsync(file.fileno())
        if count != whole[0]:
            raise ParameterError(f"expected {whole[0]:,} frames, one a time, found {count:,}")


def _header(shape: tuple[int, ...], kind: str = "<f4") -> dict[str, object]:
    return {"descr": kind, "fortran_order": False, "shape": shape}


def read_npz(path: str | Path) -> Mesh:
    """The mesh in an archive."""
    with open_npz(path) as members:
        if "vertices" not in members.names and "frames" in members.names:
            raise FormatError(
                path,
                "this holds a recorded motion, not one mesh; name it where a recording is "
                "asked for",
            )
        vertices = members.array("vertices", "fiu", (None, 3))
        return mesh_of(members, vertices)


def write_npz(path: str | Path, mesh: Mesh) -> None:
    """Write a mesh with all that belongs to it."""
    write_arrays(path, {"vertices": mesh.vertices, **surface_arrays(mesh)})


def read_npz_sequence(path: str | Path) -> MeshSequence:
    """The recorded motion in an archive."""
    with open_npz(path) as members:
        if "frames" not in members.names and "vertices" in members.names:
            raise FormatError(path, "this holds one mesh, not a recorded motion; name it as a mesh")
        frames = members.array("frames", "fiu", (None, None, 3))
        count = len(frames)
        if count < 2:
            raise FormatError(path, f"a motion needs at least 2 frames, found {count}")
        times = members.array("times", "fiu", (count,)) if "times" in members.names else None
        names = members.texts("names", count) if "names" in members.names else []
        missing = members.texts("missing") if "missing" in members.names else []
        mesh = mesh_of(members, frames[0])
    with naming_file(path):
        if times is not None and not np.isfinite(float(times[-1]) - float(times[0])):
            raise FormatError(path, "its times are not finite numbers, or too far apart")
        frames = frames.astype(np.float64, order="C", copy=False)
        frames.flags.writeable = False  # a motion takes such frames as they are
        return MeshSequence(mesh, frames, times, names, missing)


def write_npz_sequence(path: str | Path, sequence: MeshSequence) -> None:
    """Write a recorded motion with the mesh it moves."""
    motion = {
        "frames": sequence.frames,
        "times": sequence.times,
        "names": np.array(sequence.names, dtype=np.str_),
        "missing": np.array(sequence.missing, dtype=np.str_),
    }
    write_arrays(path, {**motion, **surface_arrays(sequence.mesh)})


def surface_arrays(mesh: Mesh) -> dict[str, NDArray[Any]]:
    """The arrays of all but the positions."""
    arrays: dict[str, NDArray[Any]] = {
        "face_indices": mesh.faces.indices,
        "face_offsets": mesh.faces.offsets,
    }
    if mesh.uv is not None:
        arrays |= {"uv_coordinates": mesh.uv.coordinates, "uv_corners": mesh.uv.corners}
    for kind, labels in (("material", mesh.materials), ("group", mesh.groups)):
        if labels is not None:
            arrays[f"{kind}_names"] = np.array(labels.names, dtype=np.str_)
            arrays[f"{kind}_of_face"] = labels.of_face
    if mesh.material_library is not None:
        arrays["material_library"] = np.array(mesh.material_library)
    if mesh.copyright:
        arrays["copyright"] = np.array(mesh.copyright)
    if mesh.source is not None and mesh.source.encoding != "utf-8":
        arrays["name_encoding"] = np.array(mesh.source.encoding)
    return arrays


def mesh_of(members: NpzMembers, vertices: NDArray[Any], source: str | Path | None = None) -> Mesh:
    """The mesh of (V, 3) positions and the polygons and labels of an archive."""
    path, names = members.path, members.names
    faces = Polygons([], [0])
    if "face_indices" in names or "face_offsets" in names:
        indices = members.whole("face_indices", (None,), 0, len(vertices) - 1)
        offsets = members.whole("face_offsets", (None,), 0, len(indices))
        with naming_file(path):
            faces = Polygons(indices, offsets)
    uv = None
    if "uv_coordinates" in names or "uv_corners" in names:
        coordinates = members.array("uv_coordinates", "fiu", (None, None))
        if coordinates.shape[1] not in (2, 3) or not np.isfinite(coordinates).all():
            raise FormatError(
                path, "the array 'uv_coordinates' must be (T, 2) or (T, 3) finite numbers"
            )
        corners = members.whole("uv_corners", (len(faces.indices),), -1, len(coordinates) - 1)
        uv = UVMap(coordinates.astype(np.float64), corners.astype(np.int32))
    library = None
    if "material_library" in names:
        library = str(members.array("material_library", "U", ()))
    owner = str(members.array("copyright", "U", ())) if "copyright" in names else ""
    encoding: Literal["utf-8", "latin-1"] = "utf-8"
    if "name_encoding" in names and members.array("name_encoding", "U", ()) == "latin-1":
        encoding = "latin-1"
    with naming_file(path):
        return Mesh(
            vertices,
            faces,
            uv=uv,
            materials=_labels(members, "material", len(faces)),
            groups=_labels(members, "group", len(faces)),
            material_library=library,
            source=Source(str(source or path), encoding=encoding),
            copyright=owner,
        )


def _labels(members: NpzMembers, kind: str, faces: int) -> FaceLabels | None:
    if f"{kind}_of_face" not in members.names:
        return None
    names = members.texts(f"{kind}_names")
    of_face = members.whole(f"{kind}_of_face", (faces,), -1, len(names) - 1)
    return FaceLabels(tuple(names), of_face.astype(np.int32))
