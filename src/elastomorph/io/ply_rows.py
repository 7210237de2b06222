"""The rows of a PLY file, binary or ASCII, as columns.

Nothing is allocated for rows that the rest of the file could not hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.ply_header import ENCODINGS, Element, PlyHeader

__all__ = ["Column", "read_columns"]

ByteOrder = Literal["big", "little"]


@dataclass(frozen=True, eq=False)
class Column:
    """One property of all rows of an element.

    Attributes:
        values: (rows,) numbers, or the numbers of all lists one after another.
        sizes: (rows,) int64, the length of each list; ones where each row has one number.
    """

    values: NDArray[Any]
    sizes: NDArray[np.int64]


def read_columns(
    path: str | Path, content: bytes, header: PlyHeader, wanted: dict[str, list[str]]
) -> dict[tuple[str, str], Column]:
    """The wanted columns.

    Args:
        path: The file as the user named it, for messages.
        content: The whole file.
        header: Its header.
        wanted: Names of properties, by the name of their element; names the header lacks are
            passed over.

    Returns:
        Columns by the names of element and property.

    Raises:
        FormatError: The rows are not what the header announces.
    """
    read = _read_ascii if ENCODINGS[header.encoding] == "" else _read_binary
    return read(path, content, header, wanted)


def _wanted(element: Element, wanted: dict[str, list[str]]) -> list[int]:
    names = [p.name for p in element.properties]
    return [names.index(name) for name in wanted.get(element.name, []) if name in names]


def _read_ascii(
    path: str | Path, content: bytes, header: PlyHeader, wanted: dict[str, list[str]]
) -> dict[tuple[str, str], Column]:
    text = content[header.size :].replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    rows = [
        (line, words)
        for line, words in enumerate(map(bytes.split, text.split(b"\n")), start=header.lines + 1)
        if words
    ]
    found: dict[tuple[str, str], Column] = {}
    first = 0
    for element in header.elements:
        if not element.properties:
            continue
        own = rows[first : first + element.length]
        if len(own) < element.length:
            raise FormatError(
                path,
                f"the header announces {element.length:,} rows of '{element.name}', but only "
                f"{len(own):,} lines are left; the file was cut off or its header is wrong",
            )
        first += element.length
        for j, column in _ascii_columns(path, element, own, _wanted(element, wanted)).items():
            found.setdefault((element.name, element.properties[j].name), column)
    if first < len(rows):
        raise FormatError(
            path, "there are more lines than the header announces", line=rows[first][0]
        )
    return found


def _ascii_columns(
    path: str | Path, element: Element, rows: list[tuple[int, list[bytes]]], wanted: list[int]
) -> dict[int, Column]:
    values: dict[int, list[float]] = {j: [] for j in wanted}
    sizes: dict[int, list[int]] = {j: [] for j in wanted}
    parse = [float if p.kind.kind == "f" else int for p in element.properties]
    for line, words in rows:
        try:
            start = 0
            for j, p in enumerate(element.properties):
                size = 1
                if p.count is not None:
                    size = int(words[start])
                    start += 1
                if size < 0 or start + size > len(words):
                    raise IndexError
                if j in values:
                    values[j].extend(map(parse[j], words[start : start + size]))
                    sizes[j].append(size)
                start += size
            if start != len(words) or b"_" in b"".join(words):
                raise IndexError
        except (IndexError, ValueError):
            expected = " ".join(_described(element))[:200]
            raise FormatError(
                path,
                f"expected the numbers of one '{element.name}' ({expected}), found "
                f"'{b' '.join(words)[:60].decode('ascii', 'backslashreplace')}'",
                line=line,
            ) from None
    try:
        return {
            j: Column(
                np.array(values[j], dtype="f8" if parse[j] is float else "i8"),
                np.array(sizes[j], dtype=np.int64),
            )
            for j in wanted
        }
    except OverflowError:
        raise FormatError(path, f"a number of '{element.name}' is too large") from None


def _described(element: Element) -> list[str]:
    return [p.name if p.count is None else f"N N×{p.name}" for p in element.properties]


def _read_binary(
    path: str | Path, content: bytes, header: PlyHeader, wanted: dict[str, list[str]]
) -> dict[tuple[str, str], Column]:
    found: dict[tuple[str, str], Column] = {}
    position = header.size
    order: ByteOrder = "big" if ENCODINGS[header.encoding] == ">" else "little"
    for element in header.elements:
        left = len(content) - position
        if element.length * element.smallest_row > left:
            raise FormatError(
                path,
                f"the header announces {element.length:,} rows of '{element.name}', at least "
                f"{element.length * element.smallest_row:,} bytes, but only {left:,} are left; "
                "the file was cut off or its header is wrong",
            )
        if not element.properties or not element.length:
            continue
        properties = _wanted(element, wanted)
        alike = _alike_rows(path, content, position, element, order)
        if alike is not None:
            position += alike.nbytes
            columns = {j: _column_of(alike[f"f{j}"]) for j in properties}
        else:
            starts, sizes, position = _walk(path, content, position, element, element.length, order)
            columns = {
                j: _gathered(content, starts[:, j], sizes[:, j], element.properties[j].kind)
                for j in properties
            }
        for j, column in columns.items():
            found.setdefault((element.name, element.properties[j].name), column)
    rest = len(content[position:].strip())
    if rest:
        raise FormatError(path, f"{rest:,} bytes follow the last row; the header is wrong")
    return found


def _alike_rows(
    path: str | Path, content: bytes, position: int, element: Element, order: ByteOrder
) -> NDArray[Any] | None:
    """The rows as one table, if all their lists are as long as those of the first row."""
    sizes = _walk(path, content, position, element, 1, order)[1][0].tolist()
    fields: list[tuple[Any, ...]] = []
    for j, (p, size) in enumerate(zip(element.properties, sizes, strict=True)):
        if p.count is not None:
            fields.append((f"n{j}", p.count))
        fields.append((f"f{j}", p.kind) if p.count is None else (f"f{j}", p.kind, (size,)))
    row = np.dtype(fields)
    if 0 in sizes or element.length * row.itemsize > len(content) - position:
        return None
    table = np.frombuffer(content, dtype=row, count=element.length, offset=position)
    for j, p in enumerate(element.properties):
        if p.count is not None and (table[f"n{j}"] != sizes[j]).any():
            return None
    return table


def _column_of(values: NDArray[Any]) -> Column:
    width = values.shape[1] if values.ndim == 2 else 1
    return Column(values.reshape(-1), np.full(len(values), width, dtype=np.int64))


def _walk(
    path: str | Path,
    content: bytes,
    position: int,
    element: Element,
    length: int,
    order: ByteOrder,
) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """(rows, properties) first byte and number of values of each entry, and where the rows end."""
    steps = [
        (p.kind.itemsize, 0, False)
        if p.count is None
        else (p.kind.itemsize, p.count.itemsize, p.count.kind == "i")
        for p in element.properties
    ]
    starts: list[int] = []
    sizes: list[int] = []
    for row in range(length):
        for item, counter, signed in steps:
            size = 1
            if counter:
                count = content[position : position + counter]
                size = int.from_bytes(count, order, signed=signed)
                position += counter
            if size < 0 or position + size * item > len(content):
                raise FormatError(
                    path,
                    f"row {row:,} of '{element.name}' has a list of {size:,} values, but only "
                    f"{max(len(content) - position, 0):,} bytes are left; the file was cut off or "
                    "is damaged",
                )
            starts.append(position)
            sizes.append(size)
            position += size * item
    shape = (length, len(steps))
    return np.array(starts).reshape(shape), np.array(sizes).reshape(shape), position


def _gathered(
    content: bytes,
    starts: NDArray[np.int64],
    sizes: NDArray[np.int64],
    kind: np.dtype[np.generic],
) -> Column:
    before = np.cumsum(sizes) - sizes
    within = np.arange(int(sizes.sum())) - np.repeat(before, sizes)
    first = np.repeat(starts, sizes) + within * kind.itemsize
    everything = np.frombuffer(content, dtype=np.uint8)
    values = everything[first[:, None] + np.arange(kind.itemsize)].reshape(-1).view(kind)
    return Column(values, sizes)
