"""Every exception and warning of elastomorph.

    ElastomorphError
    ├── FileError             a file is missing, unreadable or cannot be written
    │   └── FormatError       a file is there, but its content is not what its format allows
    ├── MeshError             vertices or polygons do not form a mesh
    │   └── TopologyError     two meshes that must share vertices and polygons do not
    ├── CurveError            curves do not fit their mesh or each other
    ├── ParameterError        an argument is out of its range (also a ValueError)
    │   └── ResonanceError    a material and load at which a time law of the solution is singular
    ├── CaptureError          photographs or scans from which no pose can be made
    ├── ClusterError          machines that make a data set do not answer, or do not suit
    ├── BakeError             a path cannot be stored within the tolerance asked for
    └── MissingExtraError     an optional dependency is not installed

    ElastomorphWarning
    └── TimeLawWarning        a time law moves backwards or overshoots its target

A message names what was found, what was expected and what to do about it.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Any

__all__ = [
    "BakeError",
    "CaptureError",
    "ClusterError",
    "CurveError",
    "ElastomorphError",
    "ElastomorphWarning",
    "FileError",
    "FormatError",
    "MeshError",
    "MissingExtraError",
    "ParameterError",
    "ResonanceError",
    "TimeLawWarning",
    "TopologyError",
]


class ElastomorphError(Exception):
    """Base of every error that elastomorph raises on purpose."""

    def __reduce__(self) -> tuple[Any, ...]:
        # By its text: made again from its text alone, an error whose class asks for more would fail
        # on its way from another process.
        return _restored, (type(self), self.args), self.__dict__


def _restored(kind: type[ElastomorphError], words: tuple[object, ...]) -> ElastomorphError:
    return kind.__new__(kind, *words)


class FileError(ElastomorphError):
    """A file is missing, unreadable or cannot be written.

    Attributes:
        path: The file.
        line: Line number, counted from 1, where one is known.
    """

    def __init__(self, path: str | Path, problem: str, *, line: int | None = None) -> None:
        self.path = Path(path)
        self.line = line
        place = str(path) if line is None else f"{path}, line {line}"
        super().__init__(f"{place}: {problem}")


class FormatError(FileError):
    """A file is there, but its content is not what its format allows."""


class MeshError(ElastomorphError):
    """Vertices or polygons do not form a mesh."""


class TopologyError(MeshError):
    """Two meshes that must share their vertices and polygons do not."""


class CurveError(ElastomorphError):
    """Curves do not fit their mesh or each other."""


class ParameterError(ElastomorphError, ValueError):
    """An argument is out of its range."""


class ResonanceError(ParameterError):
    """A material and load at which a time law of the solution is singular.

    Attributes:
        mode: Number n of the first singular mode; 0 is the mean of the curve.
        stiffness: B of that mode (0 for the mean).
        safe_damping: The nearest damping at which every law is well behaved.
    """

    def __init__(self, problem: str, *, mode: int, stiffness: float, safe_damping: float) -> None:
        self.mode = mode
        self.stiffness = stiffness
        self.safe_damping = safe_damping
        super().__init__(problem)


class CaptureError(ElastomorphError):
    """Photographs or scans do not show what a pose could be made from."""


class ClusterError(ElastomorphError):
    """Machines that make a data set do not answer, are gone, or do not suit."""


class BakeError(ElastomorphError):
    """A path cannot be stored within the tolerance asked for."""


class MissingExtraError(ElastomorphError):
    """An optional dependency is not installed."""

    def __init__(self, package: str, extra: str | None = None) -> None:
        wanted = package if extra is None else f"'elastomorph[{extra}]'"
        super().__init__(
            f"this needs the package '{package}', which is not installed: run  pip install {wanted}"
        )


class ElastomorphWarning(UserWarning):
    """Base of every warning that elastomorph gives."""


class TimeLawWarning(ElastomorphWarning):
    """A time law moves backwards or overshoots its target by more than 1 %."""


def warn(message: str, category: type[Warning] = ElastomorphWarning) -> None:
    """Give a warning that points at the line that called the package.

    That is the nearest frame which is neither ours nor of the standard library, through which we
    call ourselves (caches, context managers, generated code, threads).
    """
    frame = sys._getframe(1)
    while frame.f_back is not None:
        module = str(frame.f_globals.get("__name__")).partition(".")[0]
        if module != "elastomorph" and module not in sys.stdlib_module_names:
            break
        frame = frame.f_back
    warnings.warn_explicit(
        message,
        category,
        frame.f_code.co_filename,
        frame.f_lineno,
        str(frame.f_globals.get("__name__")),
        frame.f_globals.setdefault("__warningregistry__", {}),
    )
