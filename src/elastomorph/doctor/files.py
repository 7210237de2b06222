"""Reads what a doctor is given: files or a folder, and pairs of vertices that are known."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from elastomorph.doctor.examination import Examination, Settings, examine, unreadable_neutral
from elastomorph.errors import ElastomorphError, FormatError, ParameterError
from elastomorph.io import read
from elastomorph.io.atomic import read_bytes
from elastomorph.io.rig_folder import find_rig_files
from elastomorph.mesh import Mesh

__all__ = ["examine_files", "read_seeds", "rig_paths"]


def rig_paths(paths: Sequence[str | Path]) -> tuple[Path, ...]:
    """The neutral, then the targets.

    Args:
        paths: A folder with a neutral and its targets, or a neutral and its targets.

    Raises:
        FileError: No such folder, no neutral in it or several, no targets.
        ParameterError: A folder beside other paths, or a file twice.
    """
    files = [Path(path) for path in paths]
    if len(files) == 1 and files[0].is_dir():
        return find_rig_files(files[0]).all
    for file in files:
        if file.is_dir():
            raise ParameterError(f"{file} is a folder: name it alone, or name files")
    twice = next((file for i, file in enumerate(files) if file in files[:i]), None)
    if twice is not None:
        raise ParameterError(f"{twice} is named twice")
    return tuple(files)


def examine_files(
    paths: Sequence[str | Path],
    settings: Settings | None = None,
    *,
    say: Callable[[str], None] = lambda _: None,
) -> Examination:
    """Examine a folder, or a neutral and its targets.

    A file that cannot be read is a finding; the others are examined all the same.

    Args:
        paths: A folder, or files, the neutral first.
        settings: What is known beforehand.
        say: Told what is being done.

    Raises:
        FileError: As `rig_paths`.
        ParameterError: As `rig_paths` and `examine`.
    """
    neutral, *targets = rig_paths(paths)
    say(f"reading {neutral}")
    try:
        mesh = read(neutral)
    except ElastomorphError as error:
        return unreadable_neutral(str(neutral), error, map(str, targets))
    return examine(mesh, _read_each(targets), settings, file=str(neutral), say=say)


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
