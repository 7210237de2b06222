"""Reads what a doctor is given: meshes, a folder, a rig, and pairs of vertices that are known."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from elastomorph.character import find_settings, read_settings
from elastomorph.character.build import find_sources
from elastomorph.doctor.examining import examine, examine_rig
from elastomorph.doctor.findings import Examination, unreadable
from elastomorph.doctor.settings import ExaminationSettings
from elastomorph.errors import ElastomorphError, FormatError, ParameterError
from elastomorph.io import read
from elastomorph.io.atomic import read_bytes
from elastomorph.io.registry import BUILT_IN, MESH_FORMATS, RIG_FORMATS, known_suffixes
from elastomorph.io.rig_folder import find_rig_files, rig_as_stored
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig

_MESHES, _RIGS = known_suffixes(MESH_FORMATS), known_suffixes(RIG_FORMATS)


def rig_paths(paths: Sequence[str | Path]) -> tuple[Path, ...]:
    """The neutral, then the targets, of a folder, a rig, settings of a character or files."""
    files = tuple(Path(path) for path in paths)
    if len(files) == 1:
        (only,) = files
        own = find_settings(only) if only.is_dir() else only
        if own is not None and own.suffix.lower() == ".toml":
            sources = find_sources(read_settings(own))
            return (sources.main, *sources.targets.values())
        return find_rig_files(only).all if only.is_dir() else files
    for file in files:
        suffix = file.suffix.lower()
        what = "a folder" if file.is_dir() else "a settings file" if suffix == ".toml" else ""
        if str(file) == BUILT_IN:
            what = "a rig"
        if what:
            raise ParameterError(f"{file} is {what}: name it alone, or name mesh files")
    twice = next((file for i, file in enumerate(files) if file in files[:i]), None)
    if twice is not None:
        raise ParameterError(f"{twice} is named twice")
    return files


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
        FileError: No such folder, no neutral in it or several, no targets, or a rig that cannot
            be read.
        FormatError: Settings that cannot be understood.
        ParameterError: A folder, settings or a rig beside other paths, a file twice, or as
            `examine`.
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
        names = tuple(map(str, targets))
        found = (unreadable(str(neutral), error),)
        return Examination(str(neutral), names, None, None, found, {}, names)
    return examine(mesh, _read_each(targets), settings, file=str(neutral), say=say)


def _rig(path: Path) -> Rig | None:
    """The rig in a file; None for a mesh."""
    suffix = path.suffix.lower()
    if str(path) == BUILT_IN:
        return rig_as_stored(path)
    if suffix not in (*_MESHES, *_RIGS) and path.is_file():
        found = f"unknown suffix {suffix!r}" if suffix else "the name has no suffix"
        raise FormatError(path, f"{found}; expected one of {', '.join(sorted({*_MESHES, *_RIGS}))}")
    if suffix in _MESHES and suffix in _RIGS:
        with suppress(FormatError):
            read(path)
            return None
    return rig_as_stored(path) if suffix in _RIGS else None


def _read_each(files: Sequence[Path]) -> Iterator[tuple[str, Mesh | ElastomorphError]]:
    for file in files:
        try:
            yield str(file), read(file)
        except ElastomorphError as error:
            yield str(file), error


def read_seeds(text: str) -> tuple[tuple[int, int], ...]:
    """Pairs of vertices from ``12=40,13=41``, the neutral first, or a JSON file [[12, 40], …]."""
    if text.lower().endswith(".json"):
        try:
            content = json.loads(read_bytes(text))
        except (ValueError, RecursionError) as error:
            raise FormatError(text, f"not JSON: {error}") from None
        if not isinstance(content, list) or not all(map(_is_pair, content)):
            raise FormatError(text, "expected a list of pairs such as [[12, 40], [13, 41]]")
        pairs = tuple((int(a), int(b)) for a, b in content)
    else:
        words = [[word.strip() for word in part.partition("=")[::2]] for part in text.split(",")]
        if not all(w.isdecimal() and w.isascii() and len(w) < 10 for pair in words for w in pair):
            raise ParameterError(
                f"--seeds {text!r}: expected pairs such as 12=40,13=41, the vertex of the neutral "
                "first"
            )
        pairs = tuple((int(a), int(b)) for a, b in words)
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
