"""An evaluation as CSV and JSON text; writing files is the caller's business."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from elastomorph.errors import MissingExtraError
from elastomorph.evaluation.conclusions import conclusions
from elastomorph.evaluation.summary import summaries

if TYPE_CHECKING:
    from pandas import DataFrame

    from elastomorph.evaluation.results import Evaluation


_MEASURED = (
    "average",
    "maximum",
    "path_times",
    "path_average_times",
    "path_average",
    "path_maximum",
)
"""Of a method in each frame, and but for times on each curve."""


def summary_csv(evaluation: Evaluation) -> str:
    """One line a method. Errors and seam are fractions of D, in full precision."""
    return _csv(_summary_rows(evaluation))


def long_csv(evaluation: Evaluation) -> str:
    """One line for each method, curve and frame: E_A and E_M at the time and with free timing.

    ``path_maximum`` is taken at ``path_time``, ``path_average`` at ``path_average_time``.
    """
    return _csv(_long_rows(evaluation))


def data_frame(evaluation: Evaluation, long: bool) -> DataFrame:
    """One of the two as a table of pandas."""
    try:
        from pandas import DataFrame
    except ImportError:
        raise MissingExtraError("pandas") from None
    header, *rows = _long_rows(evaluation) if long else _summary_rows(evaluation)
    return DataFrame(rows, columns=header)


def _summary_rows(evaluation: Evaluation) -> list[list[Any]]:
    rows = [asdict(line) for line in summaries(evaluation)]
    return [list(rows[0]), *(list(row.values()) for row in rows)]


def _long_rows(evaluation: Evaluation) -> list[list[Any]]:
    header = [name.replace("times", "time") for name in _MEASURED]
    rows: list[list[Any]] = [["method", "curve", "frame", "time", *header]]
    truth = evaluation.truth
    for result in evaluation.results:
        measured = [getattr(result, name) for name in _MEASURED]
        for number, curve in enumerate(_curve_names(evaluation)):
            own = [each if each.ndim == 1 else each[number] for each in measured]
            columns = (each.tolist() for each in (truth.times, *own))
            rows += [
                [result.label, curve, *values] for values in zip(truth.names, *columns, strict=True)
            ]
    return rows


def evaluation_json(evaluation: Evaluation) -> str:
    """Everything measured, as strict JSON (an infinite stretch becomes null).

    Errors and seam are fractions of ``diameter``. ``average``, ``maximum``, ``path_average`` and
    ``path_maximum`` hold one row a curve and one column a frame; ``path_maximum`` is taken at
    ``path_times``, ``path_average`` at ``path_average_times``.
    """
    lines = summaries(evaluation)
    methods = []
    for line, result in zip(lines, evaluation.results, strict=True):
        entry = {
            name: value if isinstance(value, str) or math.isfinite(value) else None
            for name, value in asdict(line).items()
        }
        for name in sorted(_MEASURED, key=lambda name: "times" not in name):
            entry[name] = getattr(result, name).tolist()
        methods.append(entry)
    page = {
        "unit": "fraction of diameter",
        "diameter": evaluation.diameter,
        "frames": list(evaluation.truth.names),
        "times": evaluation.truth.times.tolist(),
        "curves": [
            {"name": name, "vertices": len(curve.vertices), "closed": bool(curve.closed)}
            for name, curve in zip(_curve_names(evaluation), evaluation.curves, strict=True)
        ],
        "methods": methods,
        "conclusions": conclusions(lines),
    }
    if evaluation.settings is not None:
        page["settings"] = dict(evaluation.settings)
    return json.dumps(page, allow_nan=False, ensure_ascii=False) + "\n"


def _curve_names(evaluation: Evaluation) -> list[str]:
    """The name of each curve, or its number where it has none."""
    return [curve.name or str(number) for number, curve in enumerate(evaluation.curves)]


def _csv(rows: Iterable[list[Any]]) -> str:
    page = io.StringIO()
    csv.writer(page, lineterminator="\n").writerows(rows)
    return page.getvalue()
