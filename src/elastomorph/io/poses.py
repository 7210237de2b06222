"""Named poses of a face in a file: weights of sliders by name, as JSON or as a table.

JSON is what the viewer saves::

    {"format": "elastomorph poses", "version": 1,
     "poses": [{"name": "Smile", "weights": {"mouthSmileLeft": 0.7}}]}

or the bare form ``{"Smile": {"mouthSmileLeft": 0.7}}``. A table (.csv) has a row a pose::

    pose,jawOpen,mouthSmileLeft
    Smile,0,0.7

Weights that are not named, and cells that are empty, are 0.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import read_bytes, replacing, require_name
from elastomorph.io.performance import CsvTable, numbers, read_table, say_how_read
from elastomorph.io.untrusted import shortened

Poses = dict[str, dict[str, float]]

POSE_SUFFIXES = (".json", ".csv")
_COLUMN = "pose"
_FORMAT, _VERSION = "elastomorph poses", 1
_EXPECTED = 'expected {"poses": [{"name": "Smile", "weights": {"mouthSmileLeft": 0.7}}]}'


def read_poses(path: str | Path) -> dict[str, dict[str, float]]:
    """The named poses in a file, in its order: what `Rig.pose` takes, by name.

    ::

        poses = em.read_poses("poses.json")
        rig.pose(poses["Smile"])

    Args:
        path: A .json file as the viewer and `write_poses` save it, or an object of names and
            weights alone; or a .csv file with the columns ``pose,jawOpen,…``.

    Returns:
        The weight of each slider by name, of each pose by name; weights left out are 0.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It holds no poses, a pose is there twice, or a weight is no finite number; the
            message names the line.
    """
    require_name(path)
    suffix = Path(path).suffix.lower()
    if suffix == ".csv":
        return _in_rows(read_table(path))
    if suffix == ".json":
        return _in_json(path)
    raise _other_suffix(path)


def write_poses(path: str | Path, poses: Mapping[str, Mapping[str, float]]) -> None:
    """Write named poses, which come back from `read_poses` as they are, whole or not at all.

    Args:
        path: A .json or .csv file; in a table, weights that are 0 are left out when it is read.
        poses: The weight of each slider by name, of each pose by name.

    Raises:
        FileError: The file cannot be written.
        FormatError: The suffix is neither.
        ParameterError: No mapping of mappings, a name that is empty or has blanks around it, or a
            weight that is no finite number.
    """
    require_name(path)
    given = _checked(poses)
    if not given:
        raise ParameterError("there are no poses to write; give one at least")
    suffix = Path(path).suffix.lower()
    if suffix not in POSE_SUFFIXES:
        raise _other_suffix(path)
    text = _as_json(given) if suffix == ".json" else _as_rows(given)
    with replacing(path) as file:
        file.write(text.encode())


def holds_poses(path: str | Path) -> bool:
    """Whether a file is one of poses and not a take: .json, or .csv whose first column is them."""
    suffix = Path(path).suffix.lower()
    return suffix == ".json" or (suffix == ".csv" and _names_poses(read_table(path)))


def _names_poses(table: CsvTable) -> bool:
    return table.header[0].casefold() == _COLUMN


def _in_rows(table: CsvTable) -> Poses:
    if not _names_poses(table):
        raise FormatError(
            table.path,
            f"the first column is {shortened(table.header[0])!r}, expected 'pose'; a table of "
            "poses begins for example with pose,jawOpen,mouthSmileLeft",
            line=1,
        )
    if not table.rows:
        raise FormatError(table.path, "there are no poses below the header", line=1)
    say_how_read(table)
    found: Poses = {}
    for row, (cells, line) in enumerate(zip(table.rows, table.lines, strict=True)):
        filled = [i for i in range(1, len(table.header)) if i < len(cells) and cells[i].strip()]
        values = numbers(table, filled, [row])[0].tolist()
        weights = {table.header[i]: v for i, v in zip(filled, values, strict=True) if v}
        try:
            _add(found, cells[0].strip(), weights)
        except ParameterError as problem:
            raise FormatError(table.path, shortened(problem), line=line) from None
    return found


def _in_json(path: str | Path) -> Poses:
    raw = read_bytes(path)
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise FormatError(path, "the text is not UTF-8; save it as UTF-8", line=line) from None
    try:
        content = json.loads(text, object_pairs_hook=_Object)
    except json.JSONDecodeError as error:
        raise FormatError(path, f"not JSON: {error.msg}", line=error.lineno) from None
    except (RecursionError, ValueError):
        raise FormatError(path, f"nested too deeply, or too long a number: {_EXPECTED}") from None
    found: Poses = {}
    for name, weights in _entries(path, content):
        try:
            _add(found, name.strip(), _by_slider(name, weights))
        except ParameterError as problem:
            raise FormatError(path, shortened(problem), line=_line_of(text, name)) from None
    if not found:
        raise FormatError(path, f"the file holds no poses: {_EXPECTED}")
    return found


class _Object:
    """An object of JSON, which may name a thing twice."""

    def __init__(self, pairs: list[tuple[str, Any]]) -> None:
        self.pairs = pairs
        self.members = dict(pairs)

    @property
    def twice(self) -> str | None:
        """A name that is there more than once."""
        if len(self.pairs) == len(self.members):
            return None
        return Counter(name for name, _ in self.pairs).most_common(1)[0][0]


def _by_slider(name: str, weights: Any) -> dict[str, float]:
    """What should be the weights of a pose; NaN where they are no numbers."""
    if not isinstance(weights, _Object):
        raise ParameterError(f"{name!r} has no weights by name: {_EXPECTED}")
    if twice := weights.twice:
        raise ParameterError(f"{name!r} names {twice!r} twice; leave one out")
    return {slider: _weight(value) for slider, value in weights.pairs}


def _entries(path: str | Path, content: Any) -> Iterable[tuple[str, Any]]:
    """The name and what should be the weights of each pose."""
    if not isinstance(content, _Object):
        raise FormatError(path, f"this is no object with poses: {_EXPECTED}")
    listed = content.members.get("poses")
    if not isinstance(listed, list):
        if "format" in content.members or "version" in content.members:
            raise FormatError(path, f"there is no list of poses: {_EXPECTED}")
        return content.pairs
    if content.members.get("format", _FORMAT) != _FORMAT:
        said = shortened(str(content.members["format"]))
        raise FormatError(path, f"the format is {said!r}, expected {_FORMAT!r}")
    if content.members.get("version", _VERSION) != _VERSION:
        said = shortened(str(content.members["version"]))
        raise FormatError(
            path, f"version {said} of poses is not known; install a newer elastomorph"
        )
    entries = []
    for number, entry in enumerate(listed, start=1):
        own = entry.members if isinstance(entry, _Object) else {}
        if not isinstance(own.get("name"), str):
            raise FormatError(path, f"pose {number} has no name: {_EXPECTED}")
        entries.append((own["name"], own.get("weights")))
    return entries


def _add(found: Poses, name: str, weights: Mapping[str, float]) -> None:
    """One more pose, checked."""
    if name in found:
        raise ParameterError(f"the pose {name!r} is there twice; rename one")
    found |= _checked({name: weights})


def _checked(poses: Mapping[str, Mapping[str, float]]) -> Poses:
    """Poses with names that a file can hold and weights that are finite numbers."""
    if not isinstance(poses, Mapping) or not all(isinstance(w, Mapping) for w in poses.values()):
        raise ParameterError(
            "poses are a mapping from names to weights by name, such as "
            f"{{'Smile': {{'mouthSmileLeft': 0.7}}}}, found {shortened(repr(poses))}"
        )
    for name, weights in poses.items():
        _require_plain(name, "a pose")
        for slider, weight in weights.items():
            _require_text(slider)
            if not math.isfinite(_weight(weight)):
                raise ParameterError(
                    f"the weight of {slider!r} in {name!r} is {shortened(str(weight))}, expected "
                    "a finite number"
                )
    return {name: {s: _weight(w) for s, w in own.items()} for name, own in poses.items()}


def _require_plain(name: object, what: str) -> None:
    """Refuse a name that a table or a list could not show as it is."""
    fits = isinstance(name, str) and name and name == name.strip()
    if not fits or any(unicodedata.category(letter) in ("Cc", "Cs") for letter in str(name)):
        raise ParameterError(
            f"{what} cannot be called {shortened(repr(name))}; give it a name of letters without "
            "blanks around it"
        )


def _require_text(slider: object) -> None:
    """Refuse what is no name of a slider; rigs call theirs as they like."""
    lone = isinstance(slider, str) and any("\ud800" <= letter <= "\udfff" for letter in slider)
    if not isinstance(slider, str) or not slider or lone:
        raise ParameterError(f"a slider is named by a text, found {shortened(repr(slider))}")


def _weight(value: object) -> float:
    """A number, NaN where it is none."""
    try:
        return math.nan if isinstance(value, bool | str) else float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return math.nan


def _line_of(text: str, name: str) -> int | None:
    """The line of JSON in which a name stands first."""
    found = re.search(re.escape(json.dumps(name, ensure_ascii=False)), text)
    return None if found is None else text.count("\n", 0, found.start()) + 1


def _as_json(poses: Poses) -> str:
    entries = [
        json.dumps({"name": name, "weights": weights}, ensure_ascii=False, allow_nan=False)
        for name, weights in poses.items()
    ]
    head = json.dumps({"format": _FORMAT, "version": _VERSION})[:-1]
    return f'{head}, "poses": [\n' + ",\n".join(entries) + "\n]}\n"


def _as_rows(poses: Poses) -> str:
    sliders = list(dict.fromkeys(name for weights in poses.values() for name in weights))
    for name in sliders:
        _require_plain(name, "in a table, a slider")
        if ";" in name:  # a header with it would be taken for columns separated by semicolons
            raise ParameterError(f"a table cannot hold the slider {name!r}; write .json")
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([_COLUMN, *sliders])
    writer.writerows(
        [name, *(repr(weights.get(slider, 0.0)) for slider in sliders)]
        for name, weights in poses.items()
    )
    return text.getvalue()


def _other_suffix(path: str | Path) -> FormatError:
    return FormatError(
        path, f"poses are in .json or .csv, found {Path(path).suffix or 'no suffix'}; rename it"
    )
