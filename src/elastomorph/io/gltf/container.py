"""Opens .glb and .gltf files: the JSON document and its buffers, nothing fetched.

A file may bring its bytes along, hold them in data URIs, or name files beside it. Names that lead
out of the folder of the file, and addresses of any kind, are refused. Of values of the document
nothing is refused here: what is wrong is as if it were not there.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
import re
import struct
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import unquote

from numpy.typing import NDArray

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import read_bytes
from elastomorph.io.gltf import meshopt
from elastomorph.io.untrusted import MemoryBudget, refuse_mistaken


def entry_of(file: GltfFile, key: str, number: Any) -> dict[str, Any]:
    """An object of a list of the document, or an empty one."""
    items = file.document.get(key)
    if isinstance(items, list) and type(number) is int and 0 <= number < len(items):
        return object_of(items[number])
    return {}


def object_of(value: Any) -> dict[str, Any]:
    """An object, or an empty one."""
    return value if isinstance(value, dict) else {}


def key_of(value: Any) -> Any:
    """A value to look up; lists and objects are none."""
    return value if isinstance(value, int | float | str) else None


def number_of(value: Any, otherwise: float) -> float:
    """A finite number, or the other."""
    return numbers_of([value], (otherwise,))[0]


def numbers_of(values: Any, otherwise: Sequence[float]) -> list[float]:
    """As many finite numbers as there are others, or those."""
    usable = isinstance(values, list) and len(values) == len(otherwise)
    try:
        found = [float(v) for v in values if type(v) in (int, float)] if usable else []
    except OverflowError:
        found = []
    fits = len(found) == len(otherwise) and all(map(math.isfinite, found))
    return found if fits else [float(value) for value in otherwise]


_MAGIC = b"glTF"
_JSON, _BIN = 0x4E4F534A, 0x004E4942
_HALF_CHARACTER = re.compile(rb"\\u[dD][89a-fA-F]")


class GltfFile:
    """An open document whose parts are checked as they are asked for.

    Args:
        path: The file.
        document: Its JSON document.
        chunk: The binary chunk of a container of chunks, None where there is none.
        size: Bytes of the file on the disk.
        rest: All other chunks of a container, which no one but their author understands; None
            where the file is no container, but the document alone.
    """

    def __init__(
        self,
        path: str | Path,
        document: dict[str, Any],
        chunk: bytes | None,
        size: int,
        rest: bytes | None,
    ) -> None:
        self.path = path
        self.document = document
        self.chunk, self.size, self.rest = chunk, size, rest
        self.budget = MemoryBudget(path, size)  # of the file and those it brings with it
        self._read: dict[Path, bytes] = {}
        self.buffer: Callable[[int], memoryview] = cache(self._buffer)
        self.draco: dict[int, NDArray[Any]] | None = None  # see `elastomorph.io.gltf.accessors`
        self._unpacked: Callable[[int], memoryview] = cache(self._decoded)

    @property
    def is_glb(self) -> bool:
        """Whether it is one file of chunks, as .glb and .vrm are."""
        return self.rest is not None

    def refuse(self, problem: str) -> NoReturn:
        """Refuse the file by a FormatError."""
        raise FormatError(self.path, problem)

    def items(self, key: str) -> list[Any]:
        """A list of the document, empty where it is left out."""
        return self.list_in(self.document, key, "the document")

    def item(self, key: str, number: Any, of: str) -> dict[str, Any]:
        """An object of a list of the document, by a number that the file gives."""
        items = self.items(key)
        if type(number) is not int or number not in range(len(items)):
            self.refuse(f"{of} names number {_shown(number)} of {len(items)} {key}")
        if not isinstance(items[number], dict):
            self.refuse(f"number {number} of {key} is no object")
        found: dict[str, Any] = items[number]
        return found

    def list_in(self, holder: dict[str, Any], key: str, of: str) -> list[Any]:
        """A list in an object, empty where it is left out."""
        found = holder.get(key, [])
        if not isinstance(found, list):
            self.refuse(f"'{key}' of {of} is no list")
        return found

    def object_in(self, holder: dict[str, Any], key: str, of: str) -> dict[str, Any]:
        """An object in an object, empty where it is left out."""
        found = holder.get(key, {})
        if not isinstance(found, dict):
            self.refuse(f"'{key}' of {of} is no object")
        return found

    def whole_in(
        self, holder: dict[str, Any], key: str, of: str, *, default: int | None = None
    ) -> int:
        """A whole number from 0 in an object; required where there is no default."""
        found = holder.get(key, default)
        if isinstance(found, float) and found.is_integer():  # 12.0 is whole in JSON
            found = int(found)
        if type(found) is not int or found < 0:
            self.refuse(f"'{key}' of {of} is {_shown(found)}; expected a whole number from 0")
        return found

    def view(self, number: Any, of: str) -> tuple[memoryview, int]:
        """The bytes of a buffer view, decoded, and how far its elements are apart; 0: no gaps."""
        entry = self.item("bufferViews", number, of)
        packed = self._packing(entry, number)
        if packed is not None:
            stride = self.whole_in(packed[1], "byteStride", f"buffer view {number}")
            return self._unpacked(number), stride
        # Some programs write 0 for elements without gaps, as glTF 1.0 had it.
        stride = self.whole_in(entry, "byteStride", f"buffer view {number}", default=0)
        return self._range(entry, number), stride

    def _packing(self, entry: dict[str, Any], number: int) -> tuple[str, dict[str, Any]] | None:
        """The extension that says how a buffer view is packed."""
        of = f"buffer view {number}"
        extensions = self.object_in(entry, "extensions", of)
        named = next((name for name in meshopt.EXTENSIONS if name in extensions), None)
        return None if named is None else (named, self.object_in(extensions, named, of))

    def _decoded(self, number: int) -> memoryview:
        """A packed buffer view as it is without the packing."""
        entry = self.item("bufferViews", number, "the document")
        name, packed = self._packing(entry, number) or ("", {})
        of = f"buffer view {number}"
        problem = f"{of} cannot be unpacked from {name}"
        mode, applied = packed.get("mode"), packed.get("filter", "NONE")
        if not isinstance(mode, str) or not isinstance(applied, str):
            self.refuse(f"{problem}: its mode or its filter is no text")
        count, stride = (self.whole_in(packed, key, of) for key in ("count", "byteStride"))
        content = self._range(packed, number)
        try:
            packing = meshopt.Packing(count, stride, mode, applied)
            if self.whole_in(entry, "byteLength", of) != packing.size:
                raise ValueError(f"{count:,} rows of {stride} bytes are not its byteLength")
            self.budget.spend(packing.size)
            self.budget.spend_briefly(packing.size)
            return meshopt.decoded(packing, content)
        except ValueError as error:
            self.refuse(f"{problem}: {error}")

    def _range(self, entry: dict[str, Any], number: int) -> memoryview:
        """The bytes of a buffer that a buffer view, or what says how it is packed, refers to."""
        of = f"buffer view {number}"
        start = self.whole_in(entry, "byteOffset", of, default=0)
        length = self.whole_in(entry, "byteLength", of)
        content = self.buffer(self.whole_in(entry, "buffer", of))
        if start + length > len(content):
            self.refuse(f"{of} reaches beyond its buffer of {len(content):,} bytes")
        return content[start : start + length]

    def _buffer(self, number: int) -> memoryview:
        """The bytes of a buffer, as many as it announces."""
        entry = self.item("buffers", number, "a buffer view")
        length = self.whole_in(entry, "byteLength", f"buffer {number}")
        uri = entry.get("uri")
        if uri is None:
            content = (self.chunk or b"") if number == 0 else b""
        elif not isinstance(uri, str):
            self.refuse(f"the URI of buffer {number} is no text")
        else:
            content = self.uri_content(uri, f"buffer {number}")
        if len(content) < length:
            self.refuse(
                f"buffer {number} announces {length:,} bytes, but there are {len(content):,}; "
                "the file is cut off or a part of it is missing"
            )
        return memoryview(content)[:length]

    def uri_content(self, uri: str, of: str) -> bytes:
        """What a URI holds or names: the bytes of a buffer or image in or beside this file."""
        return self._from_data_uri(uri, of) if uri.startswith("data:") else self._from_file(uri)

    def _from_file(self, uri: str) -> bytes:
        """The content of a file beside this one; read once, however many buffers name it."""
        path = self._beside(uri)
        if path not in self._read:
            try:
                self._read[path] = read_bytes(path)
            except FileError as error:
                problem = str(error).removeprefix(f"{path}: ")
                raise type(error)(self.path, f"it needs {_shown(uri)}, but {problem}") from error
            self.budget.add_size(len(self._read[path]))
        return self._read[path]

    def _from_data_uri(self, uri: str, of: str) -> bytes:
        head, comma, content = uri.partition(",")
        if not comma or not head.endswith(";base64"):
            self.refuse(f"the data URI of {of} is not in base64")
        try:
            return base64.b64decode(unquote(content), validate=True)
        except (binascii.Error, ValueError):
            self.refuse(f"the data URI of {of} is damaged")

    def _beside(self, uri: str) -> Path:
        """A file in the folder of this file, or in a folder in it."""
        name = unquote(uri)
        parts = name.replace("\\", "/").split("/")
        if ":" in name or name.startswith(("/", "\\")) or ".." in parts or "\0" in name:
            self.refuse(
                f"it refers to {_shown(uri)}; only files in its own folder are read. Put the file "
                "there, or export again as .glb with everything inside"
            )
        folder = Path(self.path).parent
        try:
            found = (folder / name).resolve()
            inside = found.is_relative_to(folder.resolve())
        except (OSError, RuntimeError, ValueError):
            inside = False
        if not inside:
            self.refuse(f"it refers to {_shown(uri)}, which is no file in its own folder")
        return found


def open_gltf(path: str | Path) -> GltfFile:
    """Open a .glb or .gltf file; which of them it is, its first bytes tell."""
    return gltf_of(path, read_bytes(path))


def gltf_of(path: str | Path, content: bytes) -> GltfFile:
    """What a .glb or .gltf file is that has this content."""
    if not content:
        raise FormatError(path, "the file is empty; copy or export it again")
    refuse_mistaken(path, content)
    text, chunk, rest = content, None, None
    if content.startswith(_MAGIC):
        text, chunk, rest = _chunks(path, content)
    file = GltfFile(path, _parsed(path, text), chunk, len(content), rest)
    version = file.object_in(file.document, "asset", "the document").get("version")
    if not isinstance(version, str) or not version.startswith("2."):
        file.refuse(f"glTF version {_shown(version)}; only glTF 2.0 is read. Export it again")
    return file


def glb_chunks(text: bytes, chunk: bytes | None, rest: bytes = b"") -> list[bytes]:
    """A GLB container: a JSON document, a binary chunk if there is one, and further whole chunks.

    What is longer than the 4 GiB that a container may have is for the caller to refuse.
    """
    text += b" " * (-len(text) % 4)
    parts = [struct.pack("<II", len(text), _JSON), text]
    if chunk is not None:
        padding = bytes(-len(chunk) % 4)
        length = (len(chunk) + len(padding)) & 0xFFFFFFFF
        parts += [struct.pack("<II", length, _BIN), chunk, padding]
    parts.append(rest)
    length = 12 + sum(map(len, parts))
    return [_MAGIC + struct.pack("<II", 2, length & 0xFFFFFFFF), *parts]


def without_empty(value: Any) -> Any:
    """JSON without nulls, empty lists, objects and texts: glTF leaves out what is not there.

    A morph without target is another than one whose target has no name.
    """
    if isinstance(value, list):
        return [without_empty(each) for each in value]
    if isinstance(value, dict):
        return {
            key: without_empty(each)
            for key, each in value.items()
            if (each is not None and each not in ("", [], {})) or (key, each) == ("target", "")
        }
    return value


def _chunks(path: str | Path, content: bytes) -> tuple[bytes, bytes | None, bytes]:
    """The JSON and the binary chunk of a GLB container, and all others as they are."""
    if len(content) < 20:
        raise FormatError(path, "this GLB file is cut off before its first chunk")
    version, length = struct.unpack_from("<II", content, 4)
    if version != 2:
        raise FormatError(path, f"GLB version {version}; only version 2 is read. Export it again")
    if length > len(content):
        raise FormatError(
            path,
            f"this GLB file announces {length:,} bytes, but has {len(content):,}: it is cut off",
        )
    found: dict[int, bytes] = {}
    others = []
    place = 12
    while place + 8 <= length:
        size, kind = struct.unpack_from("<II", content, place)
        if place + 8 + size > length:
            raise FormatError(path, f"the chunk at byte {place} is longer than this GLB file")
        if not found and kind != _JSON:
            break
        if kind in (_JSON, _BIN) and kind not in found:
            found[kind] = content[place + 8 : place + 8 + size]
        else:
            others.append(content[place : place + 8 + size])
        place += 8 + size
    if _JSON not in found:
        raise FormatError(path, "the first chunk of this GLB file is not the JSON document")
    return found[_JSON], found.get(_BIN), b"".join([*others, content[place:length]])


def _parsed(path: str | Path, text: bytes) -> dict[str, Any]:
    def refuse_constant(name: str) -> NoReturn:
        raise FormatError(path, f"the document contains {name}, which is not allowed in JSON")

    problem = "it is not an object"
    try:
        document = json.loads(text.removeprefix(b"\xef\xbb\xbf"), parse_constant=refuse_constant)
        if _HALF_CHARACTER.search(text):
            json.dumps(document, ensure_ascii=False).encode()
    except json.JSONDecodeError as error:
        raise FormatError(path, f"this is no glTF file: {error.msg}", line=error.lineno) from None
    except UnicodeEncodeError:
        problem = "a text in it holds half a character"
    except UnicodeDecodeError:
        problem = "the text is not UTF-8"
    except RecursionError:
        problem = "it is nested too deeply"
    except ValueError:
        problem = "a number in it has too many digits"
    else:
        if isinstance(document, dict):
            return document
    raise FormatError(path, f"this is no glTF file: its JSON document cannot be read: {problem}")


def _shown(value: Any) -> str:
    """A value from the file, short enough for a message."""
    if isinstance(value, int) and abs(value) >= 10**40:
        return "a number too large to show"
    if isinstance(value, list | dict):
        return "a list" if isinstance(value, list) else "an object"
    text = json.dumps(value, ensure_ascii=True, default=str)
    return text if len(text) <= 60 else text[:60] + "…"
