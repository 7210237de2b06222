"""Reads what a doctor is given: meshes, a folder, a rig, and pairs of vertices that are known."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from elastomorph.character import find_settings, read_settings
from elastomorph.character.sources import find_sources
from elastomorph.doctor.examination import Examination, unreadable_neutral
from elastomorph.doctor.examining import examine, examine_rig
from elastomorph.doctor.settings import ExaminationSettings
from elastomorph.errors import ElastomorphError, FormatError, ParameterError
from elastomorph.io import read, read_rig
from elastomorph.io.atomic import read_bytes
from elastomorph.io.registry import MESH_FORMATS, RIG_FORMATS, known_suffixes
from elastomorph.io.rig_folder import find_rig_files
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig

__all__ = ["BUILT_IN", "examine_files", "read_seeds", "rig_paths"]

BUILT_IN = "built-in"
"""In place of a file: the built-in head with its shapes and expressions."""


def rig_paths(paths: Sequence[str | Path]) -> tuple[Path, ...]:
    """The neutral, then the targets.

    Args:
        paths: A folder with a neutral and its targets, settings of a character that is made of
            meshes, or a neutral and its targets.

    Raises:
        FileError: No such folder, no neutral in it or several, no targets.
        FormatError: Settings that cannot be understood.
        ParameterError: A folder, settings or a rig beside other paths, or a file twice.
    """
    files = [Path(path) for path in paths]
    if len(files) == 1:
        folder = files[0].is_dir()
        own = find_settings(files[0]) if folder else files[0] if _is_settings(files[0]) else None
        sources = None if own is None else find_sources(read_settings(own))
        if sources is not None and sources.rig is not None:
            return (sources.rig,)
        if sources is not None:
            return (sources.main, *sources.targets.values())
        return find_rig_files(files[0]).all if folder else tuple(files)
    rigs = set(known_suffixes(RIG_FORMATS)) - set(known_suffixes(MESH_FORMATS))
    for file in files:
        what = "a folder" if file.is_dir() else "a settings file" if _is_settings(file) else ""
        if file.suffix.lower() in rigs or str(file) == BUILT_IN:
            what = "a rig"
        if what:
            raise ParameterError(f"{file} is {what}: name it alone, or name mesh files")
    twice = next((file for i, file in enumerate(files) if file in files[:i]), None)
    if twice is not None:
        raise ParameterError(f"{twice} is named twice")
    return tuple(files)


def examine_files(
    paths: Sequence[str | Path],
    settings: ExaminationSettings | None = None,
    *,
    say: Callable[[str], None] = lambda _: None,
) -> Examination:
    """Examine a folder, a rig, or a neutral and its targets.

    A mesh file that cannot be read is a finding; the others are examined all the same.

    Args:
        paths: A folder, a rig file, settings, ``built-in``, or mesh files, the neutral first.
        settings: What is known beforehand.
        say: Told what is being done.

    Raises:
        FileError: As `rig_paths`, or a rig that cannot be read.
        ParameterError: As `rig_paths` and `examine`.
        MissingExtraError: The format of a rig needs a package that is not installed.
    """
    neutral, *targets = rig_paths(paths)
    say(f"reading {neutral}")
    if not targets:
        rig = _rig(neutral)
        if rig is not None:
            return examine_rig(rig, settings, file=str(neutral), say=say)
    try:
        mesh = read(neutral)
    except ElastomorphError as error:
        return unreadable_neutral(str(neutral), error, map(str, targets))
    return examine(mesh, _read_each(targets), settings, file=str(neutral), say=say)


def _is_settings(path: Path) -> bool:
    return path.suffix.lower() == ".toml"


def _rig(path: Path) -> Rig | None:
    """The rig in a file; None for a mesh."""
    if str(path) == BUILT_IN:
        from elastomorph.paths import prepare
        from elastomorph.samples import expressions, head, shapes

        to = prepare(head(), "linear")
        return Rig(head(), {name: to(m) for name, m in {**shapes(), **expressions()}.items()})
    suffix = path.suffix.lower()
    known = {*known_suffixes(MESH_FORMATS), *known_suffixes(RIG_FORMATS)}
    if suffix not in known and path.is_file():
        found = f"unknown suffix {suffix!r}" if suffix else "the name has no suffix"
        raise FormatError(path, f"{found}; expected one of {', '.join(sorted(known))}")
    if suffix not in known_suffixes(RIG_FORMATS):
        return None
    if suffix not in known_suffixes(MESH_FORMATS):
        return read_rig(path)
    try:
        read(path)
    except FormatError:
        return read_rig(path)
    return None


def _read_each(files: Sequence[Path]) -> Iterator[tuple[str, Mesh | ElastomorphError]]:
    for file in files:
        try:
            yield str(file), read(file)
        except ElastomorphError as error:
            yield str(file), error


def read_seeds(text: str) -> tuple[tuple[int, int], ...]:
    """Pairs of vertices that belong together.

    Args:
        text: ``12=40,13=41``, vertex of the neutral first; or a JSON file with [[12, 40], …].

    Raises:
        FileError: The file cannot be read.
        FormatError: The file holds no pairs.
        ParameterError: The text holds no pairs, or a vertex is in two of them.
    """
    expected = "expected pairs such as 12=40,13=41, the vertex of the neutral first"
    if text.lower().endswith(".json"):
        try:
            content = json.loads(read_bytes(text))
        except (ValueError, RecursionError) as error:
            raise FormatError(text, f"not JSON: {error}") from None
        if not isinstance(content, list) or not all(map(_is_pair, content)):
            raise FormatError(text, "expected a list of pairs such as [[12, 40], [13, 41]]")
        pairs = tuple((int(a), int(b)) for a, b in content)
    else:
        parts = [part.partition("=") for part in text.split(",")]
        words = [word.strip() for a, _, b in parts for word in (a, b)]
        if not all(word.isdecimal() and word.isascii() and len(word) < 10 for word in words):
            raise ParameterError(f"--seeds {text!r}: {expected}")
        pairs = tuple((int(a), int(b)) for a, _, b in parts)
    for side in zip(*pairs, strict=True):
        if len(set(side)) < len(side):
            raise ParameterError(f"--seeds {text!r}: a vertex is in two pairs")
    return pairs


def _is_pair(value: object) -> bool:
    return (
        isinstance(value, list)
        and len(value) == 2
        and all(isinstance(v, int) and not isinstance(v, bool) and 0 <= v < 2**31 for v in value)
    )
