"""Reads the material libraries (.mtl) that OBJ files name: base colours and their images.

A library is looked for beside its OBJ file, and images beside the library; nothing outside that
folder is read. What cannot be had is said in the texture, for whoever needs it.
"""

from __future__ import annotations

import shlex
from pathlib import Path

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import is_file, read_bytes
from elastomorph.model.appearance import Material, Texture, Wrap

__all__ = ["read_materials"]

# Options of an image that have so many numbers after them; the rest of them has one word.
_NUMBERS = {"-o": 3, "-s": 3, "-t": 3, "-mm": 2}
_MOST = 1 << 20


def read_materials(obj: str | Path, library: str) -> dict[str, Material]:
    """The materials of a library by their names, in linear colours as everywhere.

    Args:
        obj: The file that names the library.
        library: Its name there; of several in one line the first that is there and holds any.

    Raises:
        FileError: The library cannot be read.
        FormatError: It is too large to be one.
    """
    folder = Path(obj).parent
    found: dict[str, Material] = {}
    for name in (library, *library.split()):
        place = folder / name
        if not found and _inside(folder, place) and is_file(place):
            found = _materials(place)
    return found


def _materials(path: Path) -> dict[str, Material]:
    content = read_bytes(path)
    if len(content) > _MOST:
        raise FormatError(path, f"it has {len(content):,} bytes, too many for a material library")
    colours: dict[str, tuple[float, float, float, float]] = {}
    textures: dict[str, Texture] = {}
    name = None
    for line in content.decode("utf-8", "replace").splitlines():
        keyword, _, rest = line.strip().partition(" ")
        rest = rest.strip()
        if keyword == "newmtl":
            name = rest
            colours.setdefault(name, (1.0, 1.0, 1.0, 1.0))
        elif name is not None and keyword == "Kd":
            colours[name] = _colour(rest)
        elif name is not None and keyword == "map_Kd":
            textures[name] = _texture(path.parent, rest)
    return {name: Material(colour, textures.get(name)) for name, colour in colours.items()}


def _colour(text: str) -> tuple[float, float, float, float]:
    """Kd; white where it is no colour, for an image is what matters."""
    try:
        red, green, blue = (min(max(float(word), 0.0), 1.0) for word in text.split()[:3])
    except ValueError:
        return 1.0, 1.0, 1.0, 1.0
    return red, green, blue, 1.0


def _texture(folder: Path, text: str) -> Texture:
    """The image that a line names after its options."""
    wrap: Wrap = "repeat"
    words = _words(text)
    while len(words) > 1 and words[0].startswith("-"):
        option = words.pop(0)
        most = _NUMBERS.get(option, 1)
        if option == "-clamp" and words[0] == "on":
            wrap = "clamp"
        for _ in range(most):
            if len(words) < 2 or (option in _NUMBERS and not _is_number(words[0])):
                break
            words.pop(0)
    name = " ".join(words).replace("\\", "/")
    place = folder / name
    if not is_file(place):  # exporters name images by where they were on their machine
        place = folder / Path(name).name
    problem, content = "", b""
    if not name or not _inside(folder, place):
        problem = "only files in the folder of the scan are read"
    else:
        try:
            content = read_bytes(place)
        except FileError as error:
            problem = str(error).removeprefix(f"{place}: ")
    return Texture(content, Path(name).name[:60], problem, (wrap, wrap))


def _words(text: str) -> list[str]:
    try:
        return shlex.split(text, posix=True) if '"' in text else text.split()
    except ValueError:
        return text.split()


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _inside(folder: Path, place: Path) -> bool:
    """Whether a file is in a folder, wherever links lead."""
    try:
        return place.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):
        return False
