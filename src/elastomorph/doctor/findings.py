"""One thing found in one file, and the words and numbers in its sentence."""

from __future__ import annotations

from collections.abc import Iterable, Sized
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.kinds import KINDS, Severity
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh

__all__ = [
    "Finding",
    "Outcome",
    "counted",
    "finding",
    "listed",
    "percent",
    "polygon_finding",
]


@dataclass(frozen=True)
class Finding:
    """One thing found in one file.

    Attributes:
        name: A key of `KINDS`, which is also its place in the documentation.
        severity: ``error``, ``warning`` or ``note``.
        file: The file it was found in.
        message: What was found.
        remedy: What to do about it.
        line: Line of the file, counted from 1, where one is known.
        vertices: The vertices concerned, counted from 0, where there are any.
    """

    name: str
    severity: Severity
    file: str
    message: str
    remedy: str
    line: int | None = None
    vertices: tuple[int, ...] = ()

    @property
    def title(self) -> str:
        """The kind of finding in a few words."""
        return KINDS[self.name].title

    @property
    def link(self) -> str:
        """Where the documentation explains it."""
        return f"docs/findings.md#{self.name}"


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of one mesh in a check that may put it right.

    Attributes:
        mesh: The mesh as it should be; None where that cannot be known.
        findings: What was wrong.
        repair: What was done, in a few words; empty where nothing was wrong, or nothing helped.
        reversed: (F,) polygons of the neutral that it only runs the other way round; None where
            there are none, or anything else was wrong.
    """

    mesh: Mesh | None
    findings: tuple[Finding, ...] = ()
    repair: str = ""
    reversed: NDArray[np.bool_] | None = None


def finding(
    name: str,
    file: str,
    message: str,
    *,
    line: int | None = None,
    vertices: Iterable[int] | NDArray[np.integer] = (),
    severity: Severity | None = None,
) -> Finding:
    """A finding with the severity, unless another is given, and the remedy of its kind.

    Raises:
        ParameterError: No such kind.
    """
    kind = KINDS.get(name)
    if kind is None:
        raise ParameterError(f"unknown kind of finding {name!r}; one of {', '.join(KINDS)}")
    numbers = tuple(int(vertex) for vertex in vertices)
    return Finding(name, severity or kind.severity, file, message, kind.remedy, line, numbers)


def polygon_finding(
    name: str, mesh: Mesh, file: str, polygons: NDArray[np.integer], message: str
) -> Finding:
    """A finding about polygons, rising: with the line of the first, and the vertices of all."""
    lines = mesh.source.face_lines if mesh.source else None
    corners = np.isin(mesh.faces.corner_faces, polygons)
    return finding(
        name,
        file,
        message,
        line=None if lines is None else int(lines[polygons[0]]),
        vertices=np.unique(mesh.faces.indices[corners]),
    )


def counted(things: Sized | int, one: str, many: str) -> str:
    """A number and its noun: ``1 edge has``, ``2,000 edges have``."""
    count = things if isinstance(things, int) else len(things)
    return f"{count:,} {one if count == 1 else many}"


def listed(things: Iterable[object], most: int = 5) -> str:
    """The first few things, and dots if there are more."""
    names = [str(thing) for thing in things]
    return ", ".join(names[:most]) + (", …" if len(names) > most else "")


def percent(share: float) -> str:
    """A share in percent with as many digits as say something: ``0.67 %``, ``12 %``."""
    value = 100.0 * share
    if 0.0 < value < 0.0005:
        return "less than 0.001 %"
    digits = 0 if value >= 9.95 else 1 if value >= 0.995 else 2 if value >= 0.0995 else 3
    return f"{value:,.{digits}f} %"
