"""Performances as plain comma-separated text: a column of seconds and one column a weight.

::

    time,jawOpen,browInnerUp
    0,0,0.25
    0.0333333,0.1,0.5

The column ``time`` (or ``seconds``) may stand anywhere; its numbers must rise. Files are in UTF-8.
Semicolons or tabs between columns, decimal commas, milliseconds and percent are recognised, and a
warning says what was taken for what.

A face is recorded at 5 to 250 frames a second, and a weight is rarely above 2. So times that are 4
to 250 apart are milliseconds, and weights of up to 100 or so are percent, unless there is too
little to tell by: then the file is refused. A column ``seconds`` in place of ``time`` says that all
numbers are as they should be, ``milliseconds`` that times are these.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import replacing
from elastomorph.io.performance.table import CsvTable, numbers, read_table, say_how_read
from elastomorph.io.untrusted import naming_file
from elastomorph.rig.performance import Performance

__all__ = ["frame_rate", "plain_performance", "read_performance_csv", "write_performance_csv"]

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
