"""A settings file as tables of checked values; every complaint names file, line and key."""

from __future__ import annotations

import math
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

from elastomorph.character.schema import Key
from elastomorph.errors import FormatError, ParameterError, warn
from elastomorph.io.atomic import opened
from elastomorph.io.untrusted import shortened
from elastomorph.rig.naming import nearest_name

Where = tuple[str | int, ...]
"""What leads to a key: ``("regions", "mouth", "falloff")``, ``("mixture", 0, "share")``."""

_MOST_BYTES = 1 << 18
_SHOWN = 60
_MOST_PARTS = 32
_LONG_KEY = re.compile(rf"(?:[\w-]+[ \t]*\.[ \t]*){{{_MOST_PARTS},}}")
_QUOTED = re.compile(r'"(?:[^"\\]|\\.)*"|\'[^\']*\'')
_SEVERAL_LINES = re.compile(r'"{3}|\'{3}')


def nearest(name: str, known: Iterable[str]) -> str:
    """A hint for a mistyped name: the nearest known one, or all of them."""
    names = list(known)
    near = nearest_name(name, names)
    if near:
        return f"did you mean {near!r}?"
    shown = ", ".join(names[:12]) + (", …" if len(names) > 12 else "")
    return f"there are {shown}" if names else "there are none"


class Document:
    """An open settings file: the file as the user named it, its tables, and its text."""

    def __init__(self, path: Path, content: dict[str, Any], text: str) -> None:
        self.path, self.content, self._text = path, content, text

    def refuse(self, where: Where, problem: str) -> NoReturn:
        """Refuse the file because of one key or table, with the line where it is known."""
        raise FormatError(self.path, shortened(problem), line=line_of(self._text, where))

    def warn(self, where: Where, problem: str) -> None:
        """Say what is odd about a key, with the line where it is known."""
        told = FormatError(self.path, problem, line=line_of(self._text, where))
        warn(str(told))

    @contextmanager
    def naming(self, where: Where) -> Iterator[None]:
        """Turn a value out of its range into a complaint about its line."""
        try:
            yield
        except ParameterError as error:
            self.refuse(where, f"{shown(where)}: {error}")

    def table(self, where: Where) -> dict[str, Any]:
        """A table; empty where it is left out."""
        found: Any = self.content
        for depth, name in enumerate(where, start=1):
            inner = found[name] if isinstance(name, int) else found.get(name, {})
            one_of_several = any(isinstance(n, int) for n in where[depth : depth + 1])
            if not isinstance(inner, dict) and not one_of_several:
                self.refuse(
                    where[:depth],
                    f"'{name}' is a table and must hold keys: write [{shown(where[:depth])}]",
                )
            found = inner
        table: dict[str, Any] = found
        return table

    def entries(self, name: str) -> list[Where]:
        """Where each of the tables [[name]] is; none where they are left out."""
        found = self.content.get(name, [])
        if not isinstance(found, list) or not all(isinstance(each, dict) for each in found):
            self.refuse((name,), f"'{name}' is a list of tables: write [[{name}]]")
        return [(name, number) for number in range(len(found))]

    def require_known(self, where: Where, known: Iterable[str]) -> None:
        """Refuse the first key of a table that is not among the known ones."""
        names = list(known)
        for key in self.table(where):
            if key not in names:
                what = f"key {key!r} in [{shown(where)}]" if where else f"table or key {key!r}"
                self.refuse((*where, key), f"unknown {what}: {nearest(key, names)}")

    def values(self, where: Where, keys: Mapping[str, Key]) -> dict[str, Any]:
        """The values of a table, each of the kind its key has."""
        self.require_known(where, keys)
        table = self.table(where)
        return {key: self.value((*where, key), keys[key], given) for key, given in table.items()}

    def value(self, where: Where, key: Key, given: Any) -> Any:
        """One value, checked; lists become tuples."""
        expected, understood = _KINDS[key.kind]
        if not understood(given):
            self.refuse(
                where,
                f"'{shown(where)}' must be {expected}, such as {key.example}; "
                f"found {as_found(given)}",
            )
        if key.kind == "file":
            self.require_file(where, given)
        if key.kind == "texts" and isinstance(given, str):
            return (given,)
        return tuple(given) if isinstance(given, list) else given

    def require_file(self, where: Where, name: str) -> None:
        """Refuse the name of a file that is not there."""
        try:
            there = (self.path.parent / name).is_file()
        except (OSError, ValueError):
            there = False
        if not there:
            self.refuse(
                where,
                f"'{shown(where)}' names the file {name!r}, which does not exist in "
                f"{self.path.parent}; names are relative to the settings file",
            )


def open_document(path: str | Path) -> Document:
    """Open a settings file; what is no TOML is refused, with its line."""
    with opened(path) as file:
        return parse_document(path, file.read(_MOST_BYTES + 1))


def parse_document(path: str | Path, raw: bytes) -> Document:
    """The content of a settings file; what is no TOML is refused, with its line."""
    if len(raw) > _MOST_BYTES:
        raise FormatError(
            path, f"it is larger than {_MOST_BYTES >> 10} KiB; settings are a few lines of text"
        )
    try:
        text = raw.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise FormatError(path, "not TOML: the text is not UTF-8", line=line) from None
    _require_shallow(path, text)
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        problem, place, rest = str(error).partition(" (at line ")
        known = int(rest.partition(",")[0]) if place else None
        raise FormatError(path, f"not TOML: {problem}", line=known) from None
    except RecursionError:
        raise FormatError(path, "not TOML: it is nested too deeply") from None
    except ValueError:
        raise FormatError(path, "not TOML: a number or date in it is out of range") from None
    return Document(Path(path), content, text)


def _require_shallow(path: str | Path, text: str) -> None:
    """Refuse keys of very many parts, for which the TOML reader takes the square in memory."""
    # Beside text over several lines, nobody can say where in a line quotes begin.
    unclear = _SEVERAL_LINES.search(text) is not None
    for number, line in enumerate(text.split("\n"), start=1):
        if line.count(".") <= _MOST_PARTS:
            continue
        if unclear or _LONG_KEY.search(_QUOTED.sub("q", line)):
            raise FormatError(path, "not TOML: a key is nested too deeply", line=number)


def _is_number(value: Any) -> bool:
    try:
        return (
            isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
        )
    except OverflowError:
        return False


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _list_of(understood: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and bool(value) and all(map(understood, value))


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip()) and "\0" not in value


def _is_span(value: Any) -> bool:
    low, high = value if isinstance(value, list) and len(value) == 2 else (value, value)
    return _is_number(low) and _is_number(high)


_is_texts = _list_of(_is_text)
_is_vertices = _list_of(lambda value: _is_whole(value) and 0 <= value < 2**31)

_KINDS: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "text": ("text in quotes", _is_text),
    "file": ("the name of a file in quotes", _is_text),
    "number": ("a finite number", _is_number),
    "whole": ("a whole number", _is_whole),
    "flag": ("true or false", lambda value: isinstance(value, bool)),
    "numbers": ("a list of finite numbers", _list_of(_is_number)),
    "span": ("a finite number or two, [lowest, highest]", _is_span),
    "texts": ("text or a list of texts", lambda value: _is_text(value) or _is_texts(value)),
    "vertices": (
        "a file, ranges such as '0-99,120' or a list of indices",
        lambda value: _is_text(value) or _is_vertices(value),
    ),
    "table": ("a table", lambda value: isinstance(value, dict)),
}


def shown(where: Where) -> str:
    """What leads to a key, as messages say it: ``regions.mouth.falloff``, ``mixture #1.share``."""
    names = ".".join(f"#{name + 1}" if isinstance(name, int) else name for name in where)
    return names.replace(".#", " #")


def as_found(value: Any) -> str:
    """A value of the file, short enough for a message."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, int) and abs(value) >= 10**30:
        return "a number too large to show"
    text = repr(value) if not isinstance(value, bool) else str(value).lower()
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "…"


_PART = r"""(?:[A-Za-z0-9_-]+|"(?:[^"\\]|\\.)*"|'[^']*')"""
_KEY = rf"{_PART}(?:[ \t]*\.[ \t]*{_PART})*"
_HEADER = re.compile(rf"[ \t]*\[{{1,2}}[ \t]*({_KEY})[ \t]*\]")
_ASSIGNMENT = re.compile(rf"[ \t]*({_KEY})[ \t]*=")


def line_of(text: str, where: Where) -> int | None:
    """The line of a key or table, counted from 1; of what it is in where it has no line itself.

    Args:
        text: A document that is valid TOML.
        where: The names that lead to it, such as ``("regions", "mouth", "falloff")``.

    Returns:
        The line, or None where it cannot be told: the document has text over several lines, in
        which something may look like a key.
    """
    if '"' * 3 in text or "'" * 3 in text:
        return None
    best, found = 0, None
    table: Where = ()
    entries: Counter[Where] = Counter()
    for number, line in enumerate(text.split("\n"), start=1):
        if header := _HEADER.match(line):
            place = table = _names(header[1])
            if line.lstrip().startswith("[["):
                place = table = (*table, entries[table])
                entries[table[:-1]] += 1
        elif assignment := _ASSIGNMENT.match(line):
            place = table + _names(assignment[1])
        else:
            continue
        pairs = enumerate(zip(place, where, strict=False))
        both = min(len(place), len(where))
        shared = next((count for count, (own, its) in pairs if own != its), both)
        # A table deeper than what is asked for may be all there is of it: [a.b] is where a begins.
        if shared > best and (shared == len(place) or shared == len(where)):
            best, found = shared, number
    return found


def _names(key: str) -> Where:
    content: Any = tomllib.loads(f"{key} = 0")
    names = []
    while isinstance(content, dict):
        ((name, content),) = content.items()
        names.append(name)
    return tuple(names)
