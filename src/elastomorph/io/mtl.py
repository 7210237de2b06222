"""What the materials of an OBJ look like: its library (MTL) and the images beside it.

Only files in the folder of the mesh, or in folders within, are read. Of a library only base
colours, their images and opacity count; scanners write little more.

Files that a mesh or its materials name, such as images: only what lies beside them is read.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from elastomorph.errors import FileError
from elastomorph.io.atomic import read_bytes, size_of
from elastomorph.model.mesh import FaceLabels, Material, Mesh, Texture, Wrap

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


_LARGEST_LIBRARY = 16 << 20
_NUMBERS = {"-s": 3, "-o": 3, "-t": 3, "-mm": 2}  # numbers behind an option, at most
_WORDS = ("-blendu", "-blendv", "-cc", "-clamp", "-boost", "-texres", "-bm", "-imfchan", "-type")


def with_looks(mesh: Mesh) -> Mesh:
    """A mesh with what its materials look like, where the library that its OBJ names is there.

    An image that cannot be had is a `Texture` without content, which says why.

    Args:
        mesh: As `read_obj` gives it; any other is returned as it is.
    """
    library = library_of(mesh)
    if library is None or mesh.source is None or size_of(library) > _LARGEST_LIBRARY:
        return mesh
    try:
        text = read_bytes(library).decode(mesh.source.encoding, "replace")
    except FileError:
        return mesh
    stated = list(_materials(text))
    labels = mesh.materials
    if labels is None and len(stated) == 1:  # of one material nobody needs to say where it is
        labels = FaceLabels((stated[0][0],), np.zeros(len(mesh.faces), dtype=np.int32))
    folder, images = Path(mesh.source.path).parent, dict[str, Texture]()
    found = {
        name: _material(folder, statements, images)
        for name, statements in stated
        if labels is not None and name in labels.names
    }
    if all(material.plain for material in found.values()):
        return mesh
    return Mesh(
        mesh.vertices,
        mesh.faces,
        mesh.uv,
        labels,
        mesh.groups,
        mesh.material_library,
        mesh.source,
        found,
    )


def library_of(mesh: Mesh) -> Path | None:
    """The library that the OBJ of a mesh names, if it is there.

    Some files name several in one line: the first of them that is there counts.
    """
    if mesh.source is None or not mesh.material_library:
        return None
    folder, named = Path(mesh.source.path).parent, mesh.material_library
    places = (beside(folder, name) for name in dict.fromkeys((named, *named.split())))
    return next((place for place in places if place is not None), None)


def _materials(text: str) -> Iterator[tuple[str, list[list[str]]]]:
    """The name of each material and the words of its lines."""
    name, statements = "", list[list[str]]()
    for line in text.splitlines():
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0] == "newmtl":
            if name:
                yield name, statements
            name, statements = line.strip()[len("newmtl") :].strip(), []
        else:
            statements.append(words)
    if name:
        yield name, statements


def _material(
    folder: Path, statements: Sequence[Sequence[str]], images: dict[str, Texture]
) -> Material:
    colour, opacity = (1.0, 1.0, 1.0), 1.0
    texture: Texture | None = None
    for word, *values in statements:
        numbers = _leading_numbers(values)
        if word == "Kd" and numbers:
            colour = (numbers[0], numbers[min(1, len(numbers) - 1)], numbers[-1])
        elif word == "d" and numbers:
            opacity = numbers[0]
        elif word == "Tr" and numbers:
            opacity = 1 - numbers[0]
        elif word == "map_Kd" and values:
            texture = _texture(folder, values, images)
    # Programs multiply an image with the colour beside it or do not; most write 0.8 of white.
    seen = (1.0, 1.0, 1.0) if texture is not None else colour
    red, green, blue = (_linear(min(max(value, 0.0), 1.0)) for value in seen)
    alpha = min(max(opacity, 0.0), 1.0)
    return Material((red, green, blue, alpha), texture, "opaque" if alpha == 1 else "blend")


def _texture(folder: Path, words: Sequence[str], images: dict[str, Texture]) -> Texture:
    """The image that the words behind ``map_Kd`` name, with its options."""
    scale, offset, wrap = [1.0, 1.0], [0.0, 0.0], "repeat"
    rest = list(words)
    while len(rest) > 1 and rest[0] in (*_NUMBERS, *_WORDS):
        option, rest = rest[0], rest[1:]
        if option in _NUMBERS:
            numbers = _leading_numbers(rest[: min(_NUMBERS[option], len(rest) - 1)])
            rest = rest[len(numbers) :]
            if option == "-s":
                scale = (numbers + [1.0, 1.0][len(numbers) :])[:2]
            elif option == "-o":
                offset = (numbers + [0.0, 0.0][len(numbers) :])[:2]
        else:
            wrap = "clamp" if (option, rest[0]) == ("-clamp", "on") else wrap
            rest = rest[1:]
    name = " ".join(rest)
    if name not in images:
        images[name] = image_beside(folder, name)
    image = images[name]
    sides: tuple[Wrap, Wrap] = ("clamp", "clamp") if wrap == "clamp" else ("repeat", "repeat")
    # Here coordinates count from the top of the image, in a library from its bottom.
    return Texture(
        image.image,
        image.name,
        image.problem,
        sides,
        (offset[0], 1 - scale[1] - offset[1]),
        0.0,
        (scale[0], scale[1]),
    )


def _leading_numbers(words: Sequence[str]) -> list[float]:
    numbers: list[float] = []
    for word in words:
        try:
            value = float(word)
        except ValueError:
            break
        if not math.isfinite(value):
            break
        numbers.append(value)
    return numbers


def _linear(shown: float) -> float:
    """Light of sRGB: colours of a library are as screens show them."""
    return shown / 12.92 if shown <= 0.04045 else float(((shown + 0.055) / 1.055) ** 2.4)
