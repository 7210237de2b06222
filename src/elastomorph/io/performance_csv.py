"""Performances as plain comma-separated text: a column of seconds and one column a weight.

::

    time,jawOpen,browInnerUp
    0,0,0.25
    0.0333333,0.1,0.5

The column ``time`` (or ``seconds``) may stand anywhere; its numbers must rise. Files are in UTF-8.
Semicolons or tabs between columns, decimal commas, milliseconds and percent are recognised, and a
warning says what was taken for what; ``seconds`` in place of ``time`` has all numbers taken as they
are (see `elastomorph.io.performance_units`).
"""

from __future__ import annotations

import csv
import io
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ElastomorphWarning, FormatError, ParameterError
from elastomorph.io.atomic import replacing
from elastomorph.io.csv_table import CsvTable, numbers, read_table
from elastomorph.io.livelink import is_livelink, livelink_performance
from elastomorph.io.performance_units import TIME_COLUMNS, AmbiguousUnitsError, units_of
from elastomorph.io.untrusted import naming_file
from elastomorph.rig.performance import Performance

__all__ = ["read_performance", "read_performance_csv", "write_performance_csv"]

_RATES = (24000 / 1001, 24.0, 25.0, 30000 / 1001, 30.0, 48.0, 50.0, 60000 / 1001, 60.0, 120.0)
_SAME_RATE = 5e-4
_LATEST = 1e15


def read_performance(path: str | Path, timecode_rate: float | None = None) -> Performance:
    """The performance in a file: a take of Live Link Face, or plain columns with a time.

    Args:
        path: A .csv file.
        timecode_rate: Frames a second that timecodes count, as for `read_livelink`.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is neither, or nothing tells in which units its numbers are; the message
            names the line.
        ParameterError: No timecode counts at ``timecode_rate``, or there are none.
    """
    table = read_table(path)
    if not is_livelink(table) and timecode_rate is not None:
        raise ParameterError(
            f"{path} has times in seconds and no timecodes: leave the timecode rate out"
        )
    if is_livelink(table):
        performance = livelink_performance(table, timecode_rate)
        _say(table, table.said)
        return performance
    return _plain(table)


def read_performance_csv(path: str | Path) -> Performance:
    """The performance in a file with a column ``time`` and one column a weight.

    The rate is that of the file as a whole, or of a standard one where it is that close.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is no such file, or nothing tells in which units its numbers are; the
            message names the line.
    """
    return _plain(read_table(path))


def write_performance_csv(path: str | Path, performance: Performance) -> None:
    """Write times and weights, whole or not at all; they come back bit for bit.

    Timecodes and what was dropped are not kept. The column of times is called ``time``, or
    ``seconds`` where numbers would otherwise be taken for milliseconds or percent.

    Args:
        path: The file; its folder must exist.
        performance: The performance.

    Raises:
        FileError: The file cannot be written.
        ParameterError: A name cannot be that of a column.
    """
    for name in performance.names:
        if (
            name.casefold() in TIME_COLUMNS
            or not name
            or name != name.strip()
            or not name.isprintable()
        ):
            raise ParameterError(
                f"a weight cannot be called {name!r} in a file with columns; rename it"
            )
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([_time_column(performance), *performance.names])
    table = np.column_stack([performance.times, performance.weights])
    writer.writerows([repr(value) for value in row] for row in table.tolist())
    with replacing(path) as file:
        file.write(text.getvalue().encode())


def _time_column(performance: Performance) -> str:
    """A name under which the numbers are read as they are."""
    try:
        units = units_of("time", performance.names, performance.times, performance.weights)
    except AmbiguousUnitsError:
        return "seconds"
    return "seconds" if units.said else "time"


def _plain(table: CsvTable) -> Performance:
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
            names, when, values[:, 1:] * units.weights, _rate(when), source=str(table.path)
        )
    _say(table, (*table.said, *units.said))
    return performance


def _say(table: CsvTable, said: Sequence[str]) -> None:
    if said:
        warnings.warn(f"{table.path}: {'; '.join(said)}", ElastomorphWarning, stacklevel=4)


def _rate(times: NDArray[np.float64]) -> float:
    """Frames a second: of the whole where times are even, else of most frames."""
    if len(times) == 1:
        return 30.0
    steps = np.diff(times)
    usual = float(np.median(steps))
    mean = float(steps.mean())
    rate = 1 / (mean if abs(mean - usual) < 0.05 * usual else usual)
    nearest = min(_RATES, key=lambda known: abs(known - rate))
    return nearest if abs(nearest - rate) <= _SAME_RATE * nearest else rate
