"""Takes of Live Link Face (.csv): a timecode and the weights of ARKit a frame.

The header is ``Timecode,BlendShapeCount,EyeBlinkLeft,…``: 52 shapes, and nine angles of the head
and the eyes that most takes have. Timecodes are ``HH:MM:SS:FF.fff`` with FF counting 24 to 60 and
more a second, whatever the rate of the recording, and fff thousandths of a frame.
"""

from __future__ import annotations

from pathlib import Path

from elastomorph.errors import FormatError
from elastomorph.io.performance.table import CsvTable, numbers, read_table
from elastomorph.io.performance.timecode import Timecode, TimingError, parse_timecode, take_timing
from elastomorph.rig.performance import Performance

__all__ = ["is_livelink", "livelink_performance", "read_livelink"]

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
