"""Methods of targets written into a settings file, where every other word stays as it was."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.items import Table

from elastomorph.character.document import parse_document
from elastomorph.character.read import settings_of
from elastomorph.character.schema import stated_as
from elastomorph.character.settings import Settings
from elastomorph.errors import FormatError
from elastomorph.io.atomic import is_file, read_bytes, replacing, unnoted
from elastomorph.paths import Method

_BOM = "\ufeff".encode()
_INSTEAD = ("order", "load")  # each takes the place of the other
_HEADER = re.compile(r"^[ \t]*\[[^\[\]\n]+\][ \t]*(?:#.*)?$", re.MULTILINE)


def said_of(settings: Settings, target: str) -> str:
    """What a settings file says of one target by its own name, as text; empty for nothing."""
    between = settings.inbetweens.get(target)
    if between is not None:
        return between.method
    choice = settings.methods.get(target)
    if choice is None:
        return ""
    stated = {key: value for key, value in stated_as(choice).items() if value not in (None, {})}
    return str(stated["method"]) if list(stated) == ["method"] else json.dumps(stated)


def save_methods(path: Path, choices: Mapping[str, str], known: Mapping[str, str]) -> Settings:
    """Write the methods of some targets into a settings file, which is made where there is none.

    Args:
        path: The settings file.
        choices: A method a target as text, or the law of one with in-betweens; empty takes away
            what the file says of the target by its own name.
        known: What whoever chose has read there of these targets, as `said_of` says it.

    Returns:
        The settings as they are now.

    Raises:
        FormatError: The file is damaged, says something else of a target than was known, or would
            not be read with the choice; it stays as it was.
        FileError: It cannot be read or written.
    """
    raw = read_bytes(path) if is_file(path) else b""
    before = settings_of(parse_document(path, raw))
    for name in choices:
        now, was = said_of(before, name), known.get(name, "")
        if now != was:
            raise FormatError(
                path,
                f"of {name} it now says {now or 'nothing'!r}, and when this page read it "
                f"{was or 'nothing'!r}: somebody else has changed it; reload the page and choose "
                "again",
            )
    content = with_methods(path, raw, choices)
    after = settings_of(parse_document(path, content))
    with unnoted(), replacing(path) as file:
        file.write(content)
    return after


def with_methods(path: Path, raw: bytes, choices: Mapping[str, str]) -> bytes:
    """The bytes of a settings file with other methods, as for `save_methods`."""
    parse_document(path, raw)  # says what is wrong with it, where something is
    text = raw.decode("utf-8-sig")
    plain = found = text.replace("\r\n", "\n")
    # Each new line stands below the header, so the last comes first.
    for name, method in reversed(list(choices.items())):
        tables = tomllib.loads(found)
        own = tables.get("methods", {}).get(name)
        if name in tables.get("inbetweens", {}):
            where: tuple[str, ...] = ("inbetweens", name, "method")
        else:
            where = ("methods", name, "method") if isinstance(own, dict) else ("methods", name)
            for key in _stated_again(own, method) if isinstance(own, dict) and method else ():
                found = _without(found, ("methods", name, key))
        found = _with(found, where, method) if method else _without(found, where)
    if _rest(found, choices) != _rest(plain, choices):
        raise FormatError(
            path,
            "its methods cannot be changed without touching something else; write them by hand: "
            + ", ".join(f"{name} = {method!r}" for name, method in choices.items()),
        )
    ended = found.replace("\n", "\r\n") if "\r\n" in text else found
    return (_BOM if raw.startswith(_BOM) else b"") + ended.encode()


def _with(text: str, where: tuple[str, ...], value: str) -> str:
    """A document with another value of a key."""
    document = tomlkit.parse(text)
    parent = _table(document, where[:-1])
    header = _header(text, where[:-1])
    # A new key stands below the header of its table: behind the last one there may be comments
    # that belong to what follows.
    has = parent is not None and where[-1] in parent
    if has or (parent is not None and header is None and not _is_above(parent)):
        parent[where[-1]] = value
        return tomlkit.dumps(document)
    line = f"{tomlkit.key(where[-1]).as_string()} = {tomlkit.string(value).as_string()}\n"
    if header is not None:
        return f"{text[:header].rstrip()}\n{line}{text[header:]}"
    name = ".".join(tomlkit.key(part).as_string() for part in where[:-1])
    start = f"{text.rstrip()}\n\n" if text.strip() else ""
    return f"{start}[{name}]\n{line}"


def _without(text: str, where: tuple[str, ...]) -> str:
    """A document without a key, and without its table where that held nothing else."""
    document = tomlkit.parse(text)
    parent = _table(document, where[:-1])
    if parent is None or where[-1] not in parent:
        return text
    del parent[where[-1]]
    changed = tomlkit.dumps(document)
    return changed if parent or len(where) < 3 else _without(changed, where[:-1])


def _table(document: Any, where: tuple[str, ...]) -> Any:
    for name in where:
        document = document.get(name)
        if document is None:
            return None
    return document


def _is_above(table: Any) -> bool:
    """Whether a table is only there because of others within it: [a.b] is the first of a."""
    return isinstance(table, Table) and table.is_super_table() is True


def _header(text: str, where: tuple[str, ...]) -> int | None:
    """Where the line that begins a table ends."""
    for found in _HEADER.finditer(text):
        if tomllib.loads(f"{found[0]}\n") == _nested(where):
            return found.end() + text[found.end() :].startswith("\n")
    return None


def _nested(where: tuple[str, ...]) -> dict[str, Any]:
    return {where[0]: _nested(where[1:])} if where else {}


def _stated_again(table: Mapping[str, Any], method: str) -> list[str]:
    """Keys of a table that the text of a method states too."""
    _, found = Method.read(method)
    taken = {*found, *(_INSTEAD if any(key in found for key in _INSTEAD) else ())}
    return [key for key in table if key in taken]


def _rest(text: str, choices: Mapping[str, str]) -> dict[str, Any] | None:
    """All that a document says but the methods of some targets; None for what is none."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return None
    for name in choices:
        tables.get("methods", {}).pop(name, None)
        tables.get("inbetweens", {}).get(name, {}).pop("method", None)
    if not tables.get("methods"):
        tables.pop("methods", None)
    return tables
