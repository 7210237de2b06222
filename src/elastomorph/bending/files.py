"""The files of a character: read whole, written whole, with all that they bring along."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

from elastomorph.bending.undo import is_bent, undone
from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import made_folder, read_bytes, replacing, same_file
from elastomorph.io.gltf.container import GltfFile, glb_chunks, open_gltf

_LARGEST = 2**32 - 1


@dataclass(frozen=True, eq=False)
class Character:
    """A .glb, .vrm or .gltf file.

    Attributes:
        file: Its document and buffers.
        was_bent: Whether bends were taken out of it.
    """

    file: GltfFile
    was_bent: bool = False

    @classmethod
    def read(cls, path: str | Path) -> Character:
        """The character in a file; of a bent one the original."""
        return cls.of(open_gltf(path))

    @classmethod
    def of(cls, file: GltfFile) -> Character:
        """The character in a file that is open; of a bent one the original."""
        if "extras" in file.document and not isinstance(file.document["extras"], dict):
            file.refuse("'extras' of the document are no object, so nothing can be kept in them")
        if not is_bent(file):
            return cls(file)
        document, chunk = undone(file)
        return cls(GltfFile(file.path, document, chunk, file.size, file.rest), was_bent=True)

    @property
    def is_glb(self) -> bool:
        """Whether it is one file of chunks, as .glb and .vrm are."""
        return self.file.is_glb

    @property
    def chunk(self) -> bytes | None:
        """Its binary chunk, if it has any."""
        return self.file.chunk

    @property
    def rest(self) -> bytes:
        """Other chunks, which no one but their author understands."""
        return self.file.rest or b""

    @property
    def binary_is_buffer_0(self) -> bool:
        """Whether the first buffer is the binary chunk, or may become it."""
        buffers = self.file.items("buffers")
        return self.is_glb and not (
            buffers and isinstance(buffers[0], dict) and "uri" in buffers[0]
        )


def require_output(character: Character, output: str | Path) -> None:
    """Refuse the character itself, and a name that is not of the kind that it is.

    A file that was bent before may be bent anew in its place: its original is within.
    """
    if not character.was_bent and same_file(output, character.file.path):
        raise FileError(
            output,
            "this is the character itself, which is never written over; name another output",
        )
    known = (".glb", ".vrm") if character.is_glb else (".gltf",)
    if Path(output).suffix.lower() not in known:
        raise FormatError(
            output,
            f"{character.file.path} keeps its format, so name an output with the suffix "
            f"{' or '.join(known)}",
        )


def write_character(
    character: Character,
    output: str | Path,
    document: dict[str, Any],
    chunk: bytes | None,
    beside: dict[str, bytes],
) -> None:
    """Write a character as another file.

    Args:
        character: Where the document comes from; files that it refers to go with it.
        output: The file.
        document: The document.
        chunk: The binary chunk, None for none.
        beside: Further files, by their names in the folder of the output.
    """
    folder = Path(output).parent
    brought = dict(_brought(character, folder))
    for name, content in brought.items():
        place = folder / name
        if place.is_file() and read_bytes(place) != content:
            raise FileError(
                place,
                f"there is another file of a name that {character.file.path} refers to; name an "
                "output in a folder of its own, or beside the character",
            )
    for name, content in (brought | beside).items():
        place = folder / name
        if place.parent != folder and folder.is_dir():
            made_folder(place.parent)
        with replacing(place) as file:
            file.write(content)
    chunks = _chunks(character, document, chunk)
    if character.is_glb and sum(map(len, chunks)) > _LARGEST:
        raise FormatError(output, "a GLB file holds less than 4 GiB; bend fewer targets")
    with replacing(output) as file:
        file.writelines(chunks)


def written_glb(character: Character, document: dict[str, Any], chunk: bytes | None) -> bytes:
    """A character in one file of chunks, as another with this document."""
    return b"".join(_chunks(character, document, chunk))


def _chunks(character: Character, document: dict[str, Any], chunk: bytes | None) -> list[bytes]:
    text = json.dumps(document, separators=(",", ":"), ensure_ascii=False).encode()
    return glb_chunks(text, chunk, character.rest) if character.is_glb else [text]


def referred(file: GltfFile) -> list[str]:
    """The names of the files beside it that a document refers to, each once."""
    entries = [own for kind in ("buffers", "images") for own in file.items(kind)]
    uris = [own.get("uri") for own in entries if isinstance(own, dict)]
    names = (unquote(uri) for uri in uris if isinstance(uri, str) and ":" not in uri)
    return list(dict.fromkeys(names))


def _brought(character: Character, folder: Path) -> Iterator[tuple[str, bytes]]:
    """Files that a character refers to, where the output goes to another folder."""
    home = Path(character.file.path).parent
    if home.resolve() == folder.resolve():
        return
    for name in referred(character.file):
        parts = name.replace("\\", "/").split("/")
        outside = name.startswith(("/", "\\")) or ".." in parts or "\0" in name
        if outside or not (home / name).resolve().is_relative_to(home.resolve()):
            character.file.refuse(
                f"it refers to {json.dumps(name)[:80]}, outside of its folder; name an output in "
                "the folder of the file"
            )
        if (home / name).is_file():
            yield name, read_bytes(home / name)


def name_beside(character: Character, output: str | Path) -> tuple[str, str]:
    """The name of a file for the bytes of bends, and how a document refers to it."""
    taken = {
        unquote(str(entry.get("uri")))
        for entry in character.file.items("buffers")
        if isinstance(entry, dict)
    }
    name = f"{Path(output).stem}.bends.bin"
    while name in taken:
        name = f"_{name}"
    return name, quote(name)
