"""Tables of numbers as text in columns, read strictly: a header, and equal rows below it.

Columns are separated by commas, or as spreadsheets of many countries write them, by semicolons or
tabs; decimals then have a point or a comma.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, warn
from elastomorph.io.atomic import read_bytes

__all__ = ["CsvTable", "numbers", "read_table", "say_how_read"]

_SHOWN = 40
_BLOCK = 1000
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*", re.ASCII)


@dataclass(frozen=True)
class CsvTable:
    """The cells of a file, and the line number of each row; empty lines are left out.

    Names in the header are different and have no blanks around them.
    """

    path: str | Path
    header: tuple[str, ...]
    rows: tuple[Sequence[str], ...]
    lines: tuple[int, ...]
    separator: str = ","
    decimal_comma: bool = False

    @property
    def said(self) -> tuple[str, ...]:
        """How it was read, where that is not what a file in this format should look like."""
        if self.separator == ",":
            return ()
        found = "semicolons" if self.separator == ";" else "tabs"
        commas = " and decimals by commas" * self.decimal_comma
        return (f"columns are separated by {found}{commas}",)


def read_table(path: str | Path) -> CsvTable:
    """The cells of a file in UTF-8 whose columns are separated by commas, semicolons or tabs."""
    text = _decoded(path, read_bytes(path))
    separator = _separator(text)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    rows: list[list[str]] = []
    lines: list[int] = []
    try:
        for row in reader:
            if row:
                rows.append(row)
                lines.append(reader.line_num)
    except csv.Error as error:
        raise FormatError(
            path, f"this is not comma-separated text: {error}", line=reader.line_num
        ) from None
    if not rows:
        raise FormatError(path, "the file is empty; expected a header and a row for each frame")
    header = tuple(name.strip() for name in rows[0])
    seen: set[str] = set()
    for i, name in enumerate(header):
        if not name:
            raise FormatError(path, f"column {i + 1} of the header has no name", line=lines[0])
        if name in seen:
            raise FormatError(path, f"the header names {_shown(name)} twice", line=lines[0])
        seen.add(name)
    decimal_comma = separator != "," and any(
        _DECIMAL_COMMA.fullmatch(cell) for row in rows[1:] for cell in row
    )
    return CsvTable(
        path, header, tuple(rows[1:]), tuple(lines[1:]), separator, decimal_comma=decimal_comma
    )


def say_how_read(table: CsvTable, guessed: Sequence[str] = ()) -> None:
    """Warn of what was taken for what."""
    if said := (*table.said, *guessed):
        warn(f"{table.path}: {'; '.join(said)}")


def numbers(table: CsvTable, columns: Sequence[int], rows: Sequence[int]) -> NDArray[np.float64]:
    """(len(rows), len(columns)) finite numbers."""
    width = len(table.header)
    cells: list[str] = []
    for row in rows:
        own = table.rows[row]
        if len(own) != width:
            raise FormatError(
                table.path,
                f"expected {width} columns as in the header, found {len(own)}",
                line=table.lines[row],
            )
        cells += [own[column] for column in columns]
    written = cells
    if table.decimal_comma:
        cells = ["" if "." in cell else cell.replace(",", ".", 1) for cell in cells]
    values = _floats(cells)
    if values is None:
        blocks = range(0, len(cells), _BLOCK)  # one by one, a large file would take minutes
        first = next(b for b in blocks if _floats(cells[b : b + _BLOCK]) is None)
        i = next(i for i in range(first, len(cells)) if _floats([cells[i]]) is None)
        name = _cut(table.header[columns[i % len(columns)]])
        with_comma = " with a decimal comma, as others have" * table.decimal_comma
        raise FormatError(
            table.path,
            f"{name} is {_shown(written[i])}, expected a finite number{with_comma}",
            line=table.lines[rows[i // len(columns)]],
        )
    return values.reshape(len(rows), len(columns))


def _separator(text: str) -> str:
    """What gives the first line that is not empty the most columns; commas, if in doubt."""
    first = re.split(r"[\r\n]", text.lstrip("\r\n"), maxsplit=1)[0]
    columns = {}
    for mark in (",", ";", "\t"):
        with suppress(csv.Error):
            columns[mark] = len(next(csv.reader([first], delimiter=mark), []))
    return max(columns, key=columns.__getitem__, default=",")


def _floats(cells: list[str]) -> NDArray[np.float64] | None:
    """The numbers in cells, or None if one has none; float alone would take 1_000 and ١."""
    text = ",".join(cells)
    if "_" in text or not text.isascii():
        return None
    try:
        values = np.array(list(map(float, cells)), dtype=np.float64)
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None


def _decoded(path: str | Path, content: bytes) -> str:
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise FormatError(path, "the text is UTF-16; save it as UTF-8", line=1)
    content = content.rstrip(b"\0")  # padding
    nul = content.find(b"\0")
    if nul >= 0:
        line = content.count(b"\n", 0, nul) + 1
        raise FormatError(path, "this is not text: there is a zero byte", line=line)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise FormatError(path, "the text is not UTF-8; save it as UTF-8", line=line) from None


def _shown(cell: str) -> str:
    return repr(_cut(cell))


def _cut(text: str) -> str:
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "…"
