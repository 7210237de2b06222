"""Performances in files: takes of Live Link Face, plain columns, arrays, clips of glTF.

Plain columns are comma-separated text: a column of seconds and one column a weight.

::

    time,jawOpen,browInnerUp
    0,0,0.25
    0.0333333,0.1,0.5

The column ``time`` (or ``seconds``) may stand anywhere; its numbers must rise. Files are in UTF-8,
read strictly: a header, and equal rows below it. Columns may also be separated, as spreadsheets of
many countries write them, by semicolons or tabs, and decimals have a comma; this, milliseconds and
percent are recognised, and a warning says what was taken for what.

A face is recorded at 5 to 250 frames a second, and a weight is rarely above 2. So times that are 4
to 250 apart are milliseconds, and weights of up to 100 or so are percent, unless there is too
little to tell by: then the file is refused. A column ``seconds`` in place of ``time`` says that all
numbers are as they should be, ``milliseconds`` that times are these.

The header of a take of Live Link Face is ``Timecode,BlendShapeCount,EyeBlinkLeft,…``: 52 shapes of
ARKit, and nine angles of the head and the eyes that most takes have. Timecodes are
``HH:MM:SS:FF.fff`` with FF counting 24 to 60 and more a second, whatever the rate of the recording,
and fff thousandths of a frame.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, ParameterError, warn
from elastomorph.io.atomic import read_bytes, replacing, require_name
from elastomorph.io.gltf.clips import SCENES, chosen_clip, named_clip, read_weight_clips
from elastomorph.io.npz.members import open_npz, write_arrays
from elastomorph.io.rig_folder import rig_as_stored
from elastomorph.io.timecode import Timecode, TimingError, parse_timecode, take_timing
from elastomorph.io.untrusted import naming_file
from elastomorph.rig.naming import is_rotation
from elastomorph.rig.performance import HEAD_ANGLES, Performance

_TIMECODE, _COUNT = "timecode", "blendshapecount"


def read_livelink(path: str | Path, timecode_rate: float | None = None) -> Performance:
    """The performance in a take of Live Link Face.

    Times are those of the timecodes, from 0 at the first frame, also past midnight and where
    frames were dropped. A frame with the timecode of the one before is left out. So is one without
    weights, which is what a take has where no face was seen. Angles are kept under their names.
    """
    return livelink_performance(read_table(path), timecode_rate)


def is_livelink(table: CsvTable) -> bool:
    """Whether a table has a column of timecodes."""
    return _TIMECODE in [name.casefold() for name in table.header]


def livelink_performance(table: CsvTable, timecode_rate: float | None = None) -> Performance:
    """The performance in a table."""
    keys = [name.casefold() for name in table.header]
    for key, name in ((_TIMECODE, "Timecode"), (_COUNT, "BlendShapeCount")):
        if key not in keys:
            raise FormatError(
                table.path,
                f"there is no column {name}; a take of Live Link Face begins with "
                "Timecode,BlendShapeCount,EyeBlinkLeft",
                line=1,
            )
    columns = [i for i, key in enumerate(keys) if key not in (_TIMECODE, _COUNT)]
    if not columns:
        raise FormatError(table.path, "there are no columns of weights", line=1)
    rows = _with_weights(table, keys.index(_COUNT), len(columns))
    weights = numbers(table, columns, rows)
    timecodes = [_timecode(table, row, keys.index(_TIMECODE)) for row in rows]
    try:
        timing = take_timing(timecodes, timecode_rate)
    except TimingError as error:
        raise FormatError(table.path, str(error), line=table.lines[rows[error.frame]]) from None
    texts = [table.rows[row][keys.index(_TIMECODE)].strip() for row in rows]
    kept = timing.kept.tolist()
    return Performance(
        [table.header[i] for i in columns],
        timing.times,
        weights[timing.kept],
        timing.rate,
        timecodes=[texts[i] for i in kept],
        dropped=timing.dropped,
        dropped_times=timing.dropped_times,
        duplicates=[texts[i] for i in sorted(set(range(len(rows))) - set(kept))],
        source=str(table.path),
    )


def _with_weights(table: CsvTable, count: int, weights: int) -> list[int]:
    """The rows in which a face was seen."""
    rows: list[int] = []
    for i, row in enumerate(table.rows):
        announced = row[count].strip() if count < len(row) else ""
        if not (announced.isdecimal() and announced.isascii()):
            raise FormatError(
                table.path,
                f"BlendShapeCount is {announced[:40]!r}, expected the number of weights",
                line=table.lines[i],
            )
        number = int(announced[:9])
        if number == 0 and not any(cell.strip() for cell in row[count + 1 :]):
            continue
        if number > weights:
            raise FormatError(
                table.path,
                f"BlendShapeCount announces {number} weights, but the header names {weights}; "
                "columns are missing",
                line=table.lines[i],
            )
        rows.append(i)
    if not rows:
        raise FormatError(table.path, "there are no frames with weights below the header", line=1)
    return rows


def _timecode(table: CsvTable, row: int, column: int) -> Timecode:
    text = table.rows[row][column]
    found = parse_timecode(text)
    if found is None:
        raise FormatError(
            table.path,
            f"the timecode is {text[:40]!r}, expected HH:MM:SS:FF.fff such as 13:04:31:12.500",
            line=table.lines[row],
        )
    return found


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


_AS_IT_IS = "seconds"
_MILLISECONDS = ("milliseconds", "ms", "time_ms", "time (ms)", "time [ms]")
TIME_COLUMNS = ("time", _AS_IT_IS, *_MILLISECONDS)
"""What the column of times may be called, in small letters."""

_CLOSEST, _FARTHEST = 4.0, 250.0
_FEWEST_TIMES = 10
_MOST_IN_FULL = 2.0
_LEAST_PERCENT, _MOST_PERCENT = 10.0, 200.0
_FEWEST_IN_PERCENT = 0.25

# Turns and places of head and eyes may be in degrees or centimetres beside weights of 1.
_POSE = re.compile(r"(head|neck|eye).*(yaw|pitch|roll|rot\w*|pos\w*|trans\w*|[xyz])", re.IGNORECASE)

_RATES = (24000 / 1001, 24.0, 25.0, 30000 / 1001, 30.0, 48.0, 50.0, 60000 / 1001, 60.0, 120.0)
_SAME_RATE = 5e-4
_LATEST = 1e15


def read_performance_csv(path: str | Path) -> Performance:
    """The performance in a file with a column ``time``; a rate close to a standard one is that."""
    return plain_performance(read_table(path))


def write_performance_csv(path: str | Path, performance: Performance) -> None:
    """Write times and weights, whole or not at all; they come back bit for bit.

    Timecodes and what was dropped are not kept. The column of times is called ``time``, or
    ``seconds`` where numbers would otherwise be taken for milliseconds or percent.
    """
    for name in performance.names:
        taken = name.casefold() in TIME_COLUMNS
        if taken or not name or name != name.strip() or not name.isprintable():
            raise ParameterError(
                f"a weight cannot be called {name!r} in a file with columns; rename it"
            )
    try:
        units = units_of("time", performance.names, performance.times, performance.weights)
        column = _AS_IT_IS if units.said else "time"
    except AmbiguousUnitsError:
        column = _AS_IT_IS
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([column, *performance.names])
    table = np.column_stack([performance.times, performance.weights])
    writer.writerows([repr(value) for value in row] for row in table.tolist())
    with replacing(path) as file:
        file.write(text.getvalue().encode())


def plain_performance(table: CsvTable) -> Performance:
    """The performance in a table with a column of times."""
    times = [i for i, name in enumerate(table.header) if name.casefold() in TIME_COLUMNS]
    if len(times) != 1:
        raise FormatError(
            table.path,
            f"expected one column 'time' in seconds (or a Timecode), found {len(times)}; a "
            "performance begins for example with time,jawOpen,browInnerUp",
            line=1,
        )
    columns = [i for i in range(len(table.header)) if i != times[0]]
    if not columns:
        raise FormatError(table.path, "there are no columns of weights", line=1)
    if not table.rows:
        raise FormatError(table.path, "there are no frames below the header", line=1)
    values = numbers(table, [times[0], *columns], range(len(table.rows)))
    when = values[:, 0]
    beyond = np.flatnonzero(np.abs(when) > _LATEST)
    if beyond.size:
        at = int(beyond[0])
        raise FormatError(
            table.path, f"the time {when[at]:g} cannot be seconds", line=table.lines[at]
        )
    back = np.flatnonzero(np.diff(when) <= 0)
    if back.size:
        at = int(back[0])
        raise FormatError(
            table.path,
            f"the time {when[at + 1]:g} s does not come after {when[at]:g} s; times must rise",
            line=table.lines[at + 1],
        )
    names = [table.header[i] for i in columns]
    try:
        units = units_of(table.header[times[0]], names, when, values[:, 1:])
    except AmbiguousUnitsError as problem:
        raise FormatError(table.path, str(problem), line=1) from None
    when = when * units.time
    with naming_file(table.path):
        performance = Performance(
            names, when, values[:, 1:] * units.weights, frame_rate(when), source=str(table.path)
        )
    say_how_read(table, units.said)
    return performance


def frame_rate(times: NDArray[np.float64]) -> float:
    """Frames a second: of the whole where times are even, else of most frames."""
    if len(times) == 1:
        return 30.0
    steps = np.diff(times)
    usual = float(np.median(steps))
    mean = float(steps.mean())
    rate = 1 / (mean if abs(mean - usual) < 0.05 * usual else usual)
    nearest = min(_RATES, key=lambda known: abs(known - rate))
    return nearest if abs(nearest - rate) <= _SAME_RATE * nearest else rate


class AmbiguousUnitsError(ValueError):
    """Nothing tells which units numbers have; the sentence says how to tell."""


class Units(NamedTuple):
    """What to multiply times and (N,) weights with, and what was guessed to tell that."""

    time: float
    weights: NDArray[np.float64]
    said: tuple[str, ...]


def units_of(
    column: str, names: Sequence[str], times: NDArray[np.float64], weights: NDArray[np.float64]
) -> Units:
    """The units of a table of (T,) times and (T, N) weights as they stand in the file."""
    time, scales = 1.0, np.ones(len(names))
    said: list[str] = []
    if column.casefold() == _AS_IT_IS:
        return Units(time, scales, ())
    if column.casefold() in _MILLISECONDS or _in_milliseconds(times):
        time = 1e-3
        said.append(f"the times in '{column}' are taken for milliseconds")
    own = np.array([not _POSE.fullmatch(name) for name in names])
    if _in_percent(weights[:, own]):
        scales = np.where(own, 0.01, 1.0)
        said.append("the weights are taken for percent, 100 in full")
    return Units(time, scales, tuple(said))


def _in_milliseconds(times: NDArray[np.float64]) -> bool:
    step = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    if not _CLOSEST <= step <= _FARTHEST:
        return False
    if len(times) < _FEWEST_TIMES:
        raise AmbiguousUnitsError(
            f"the times are {step:g} apart, which could be seconds or milliseconds; call their "
            f"column '{_AS_IT_IS}' or '{_MILLISECONDS[0]}'"
        )
    return True


def _in_percent(weights: NDArray[np.float64]) -> bool:
    largest = np.abs(weights).max(axis=0, initial=0.0)
    most = float(largest.max(initial=0.0))
    if not _MOST_IN_FULL < most <= _MOST_PERCENT:
        return False
    moving = np.count_nonzero(largest)
    above = np.count_nonzero(largest > _MOST_IN_FULL)
    if most <= _LEAST_PERCENT or above < _FEWEST_IN_PERCENT * moving:
        raise AmbiguousUnitsError(
            f"the weights go up to {most:g}, which could be percent or not; scale them to 0 to 1, "
            f"or call the column of times '{_AS_IT_IS}' to have all numbers taken as they are"
        )
    return True


_MEMBERS = ("names", "times", "weights")


def read_performance(
    path: str | Path, timecode_rate: float | None = None, *, clip: str | None = None
) -> Performance:
    """The performance in a file: weights of a face over time.

    Args:
        path: A take of Live Link Face or plain columns with a time (.csv); arrays ``names`` (N,),
            ``times`` (T,) in seconds, ``weights`` (T, N) and, if it is known, ``rate`` (.npz); or
            an animation of weights (.glb, .gltf, .vrm), with how it turns the head.
        timecode_rate: Frames a second that timecodes count, such as 29.97, where it is known better
            than the file shows.
        clip: Which animation, in a file with several, as also ``take.glb#NAME`` says. By default
            the one named like the file, else the first that is not named like a slider, as those
            are that play one slider from 0 to 1.

    Returns:
        Weights under the names that the file has. ``HeadYaw``, ``HeadPitch`` and ``HeadRoll`` are
        among them where it says how the head turns, in radians, see `Performance.head`; so are the
        angles of the eyes, whose directions the shapes ``eyeLook…`` tell too.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It holds no performance, or nothing tells in which units its numbers are; the
            message names the line.
        ParameterError: No timecode counts at ``timecode_rate``, or there are none, or no animation
            is called ``clip``.
    """
    require_name(path)
    path, clip = named_clip(path, clip)
    suffix = Path(path).suffix.lower()
    if clip is not None and suffix not in SCENES:
        raise ParameterError(f"{path} holds one performance: leave the name of a clip out")
    table = read_table(path) if suffix not in (".npz", *SCENES) else None
    if table is not None and is_livelink(table):
        performance = livelink_performance(table, timecode_rate)
        say_how_read(table, ())
        return performance
    if timecode_rate is not None:
        raise ParameterError(
            f"{path} has times in seconds and no timecodes: leave the timecode rate out"
        )
    if table is not None:
        return plain_performance(table)
    return _in_arrays(path) if suffix == ".npz" else _in_clip(path, clip)


def write_performance(path: str | Path, performance: Performance) -> None:
    """Write a performance, which comes back from `read_performance` bit for bit.

    Timecodes and what was dropped are not kept, nor is the rate in a table; whole or not at all.

    Args:
        path: A .csv file, a table of times and weights; or .npz, the arrays ``names``, ``times``,
            ``weights`` and ``rate``. For animated rigs see ``elastomorph animate``.
        performance: The weights over time.

    Raises:
        FileError: The file cannot be written.
        FormatError: The suffix is neither.
        ParameterError: A name cannot stand in a table, or this is no performance.
    """
    require_name(path)
    if not isinstance(performance, Performance):
        raise ParameterError(f"expected a Performance, found {type(performance).__name__}")
    suffix = Path(path).suffix.lower()
    if suffix == ".csv":
        write_performance_csv(path, performance)
    elif suffix == ".npz":
        arrays = {name: np.asarray(getattr(performance, name)) for name in (*_MEMBERS, "rate")}
        write_arrays(path, arrays)
    else:
        raise FormatError(
            path, f"a performance goes into .csv or .npz, found {suffix or 'no suffix'}"
        )


def _in_arrays(path: str | Path) -> Performance:
    with open_npz(path) as members:
        missing = [name for name in _MEMBERS if name not in members.names]
        if missing:
            raise FormatError(
                path,
                f"there is no array '{missing[0]}': a performance has names (N,), times (T,) and "
                f"weights (T, N), found {members.listed()}",
            )
        names = members.texts("names")
        times = members.array("times", "fiu", (None,)).astype(np.float64)
        weights = members.array("weights", "fiu", (len(times), len(names))).astype(np.float64)
        rate = float(members.array("rate", "fiu", ())) if "rate" in members.names else None
    with naming_file(path):
        if rate is None:
            rises = bool(len(times)) and bool((np.diff(times) > 0).all())
            rate = frame_rate(times) if rises else 30.0  # where they do not, that is refused
        return Performance(names, times, weights, rate, source=str(path))


def _in_clip(path: str | Path, name: str | None) -> Performance:
    rig = rig_as_stored(path)
    clips = read_weight_clips(path, rig.sliders)
    if not clips:
        raise FormatError(
            path, "no animation in it moves a slider of its rig; name a file with a take"
        )
    clip = chosen_clip(path, clips, name, rig.sliders)
    moved = np.flatnonzero(clip.weights.any(axis=0))
    names = [rig.names[column] for column in moved]
    weights = clip.weights[:, moved]
    if clip.turn is not None and not any(map(is_rotation, names)):
        names += HEAD_ANGLES
        weights = np.hstack([weights, clip.turn.angles])
    with naming_file(path):
        return Performance(names, clip.times, weights, frame_rate(clip.times), source=str(path))
