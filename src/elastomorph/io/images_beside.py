"""Files that a mesh or its materials name, such as images: only what lies beside them is read."""

from __future__ import annotations

from pathlib import Path

from elastomorph.errors import FileError
from elastomorph.io.atomic import read_bytes, size_of
from elastomorph.model.appearance import Texture

_LARGEST = 512 << 20


def image_beside(folder: Path, name: str) -> Texture:
    """An image in the folder of a mesh; without content, and saying why, where it cannot be had."""
    short = name.replace("\\", "/").rpartition("/")[2][:60]
    place = beside(folder, name)
    if place is None:
        return Texture(b"", short, "there is no such image in the folder of the mesh")
    if size_of(place) > _LARGEST:
        return Texture(b"", short, "it is larger than 512 MB")
    try:
        return Texture(read_bytes(place), short)
    except FileError as problem:
        return Texture(b"", short, str(problem))


def beside(folder: Path, name: str) -> Path | None:
    """A file that a library or mesh names, in the folder of the mesh or a folder in it.

    Programs also write where the file was on their machine: its last part is looked for then.
    """
    plain = name.strip().strip('"').replace("\\", "/")
    for each in dict.fromkeys((plain, plain.rpartition("/")[2])):
        try:
            found = (folder / each).resolve()
            if each and found.is_relative_to(folder.resolve()) and found.is_file():
                return found
        except (OSError, ValueError, RuntimeError):
            continue
    return None
