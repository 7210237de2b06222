"""Which function reads and writes which file: one table a kind of thing, found by suffix.

A format joins by one line in a table. Its modules are imported when a file of it is first met, so
a program that reads OBJ files never loads the rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Generic, TypeVar

from elastomorph.errors import FormatError, ParameterError
from elastomorph.mesh import Mesh
from elastomorph.sequence import MeshSequence

__all__ = ["MESH_FORMATS", "Format", "format_of", "known_suffixes", "read", "write"]

T = TypeVar("T")


@dataclass(frozen=True)
class Format(Generic[T]):
    """How things of one kind are read from and written to files of one format.

    Attributes:
        name: What people call the format.
        suffixes: The suffixes its files have, in lower case, with the dot.
        read: Path to thing.
        write: Path and thing to nothing, through `atomic.replacing`.
    """

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[str | Path], T]
    write: Callable[[str | Path, T], None]


def _later(module: str, function: str) -> Callable[..., Any]:
    def call(*arguments: Any) -> Any:
        return getattr(import_module(f"elastomorph.io.{module}"), function)(*arguments)

    return call


MESH_FORMATS: tuple[Format[Mesh], ...] = (
    Format("Wavefront OBJ", (".obj",), _later("obj", "read_obj"), _later("obj", "write_obj")),
    Format("Stanford PLY", (".ply",), _later("ply", "read_ply"), _later("ply", "write_ply")),
    Format("NumPy archive", (".npz",), _later("npz", "read_npz"), _later("npz", "write_npz")),
)


def known_suffixes(formats: tuple[Format[Any], ...]) -> tuple[str, ...]:
    """The suffixes of a table, in its order."""
    return tuple(suffix for known in formats for suffix in known.suffixes)


def format_of(path: str | Path, formats: tuple[Format[T], ...]) -> Format[T]:
    """The format that the suffix of a path names; capitals do not matter.

    Raises:
        FormatError: The table has no such suffix.
    """
    suffix = Path(path).suffix.lower()
    for known in formats:
        if suffix in known.suffixes:
            return known
    found = f"unknown suffix '{suffix}'" if suffix else "the name has no suffix"
    expected = ", ".join(known_suffixes(formats))
    raise FormatError(path, f"{found}; expected one of {expected}")


def read(path: str | Path) -> Mesh:
    """The mesh in a file, in the vertex and polygon order of the file.

    Args:
        path: A file whose suffix names its format: .obj, .ply or .npz.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: The suffix is unknown, or the content is not what the format allows.
    """
    return format_of(path, MESH_FORMATS).read(path)


def write(path: str | Path, mesh: Mesh) -> None:
    """Write a mesh, whole or not at all; positions come back bit for bit.

    Args:
        path: The file; its suffix names the format and its folder must exist.
        mesh: The mesh. PLY keeps vertices and polygons; OBJ and NPZ keep everything.

    Raises:
        FormatError: The suffix is unknown, or the format cannot hold this mesh.
        FileError: The file cannot be written.
        ParameterError: Not a mesh.
    """
    if isinstance(mesh, MeshSequence):
        raise ParameterError("this is a sequence of frames; write it with write_sequence")
    if not isinstance(mesh, Mesh):
        raise ParameterError(f"expected a Mesh to write, found {type(mesh).__name__}")
    format_of(path, MESH_FORMATS).write(path, mesh)
