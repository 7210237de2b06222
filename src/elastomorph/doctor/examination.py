"""What a doctor is told before examining a rig, and what it has to say afterwards."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.checks.material import BeamSettings
from elastomorph.doctor.checks.surface import SurfaceFacts
from elastomorph.doctor.findings import KINDS, SEVERITIES, Finding, Severity, finding
from elastomorph.doctor.side_names import SIDES
from elastomorph.doctor.thresholds import Thresholds
from elastomorph.errors import ElastomorphError, FileError, ParameterError
from elastomorph.model.mesh import Mesh

__all__ = ["Examination", "Repaired", "Settings", "in_order", "unreadable", "unreadable_neutral"]


@dataclass(frozen=True, eq=False)
class Settings:
    """What is known about a rig before it is examined.

    Attributes:
        seeds: Pairs (vertex of the neutral, vertex of the targets) for targets in another order.
        sides: How names of targets tell left and right.
        still: (N,) vertices that no target should move; targets are aligned to them.
        steady: Whether to take out the motion of the head where one is found.
        beam: A material to try on the curves of the face.
        thresholds: From where on to report.
    """

    seeds: tuple[tuple[int, int], ...] = ()
    sides: tuple[tuple[str, str], ...] = SIDES
    still: NDArray[np.int64] | None = None
    steady: bool = False
    beam: BeamSettings | None = None
    thresholds: Thresholds = field(default_factory=Thresholds)

    def require_vertices(self, neutral: Mesh, file: str) -> None:
        """Check that the vertices named are there.

        Raises:
            ParameterError: The neutral has no such vertex, or there are too few to align to.
        """
        wanted = np.array([pair[0] for pair in self.seeds], dtype=np.int64)
        if self.still is not None:
            wanted = np.concatenate([wanted, self.still])
            if len(np.unique(self.still)) < 3:
                raise ParameterError("--align needs three vertices or more that are not on a line")
        bad = wanted[(wanted >= len(neutral.vertices)) | (wanted < 0)]
        if bad.size:
            raise ParameterError(
                f"{file} has no vertex {int(bad[0]):,}, only 0 to {len(neutral.vertices) - 1:,}"
            )


@dataclass(frozen=True, eq=False)
class Repaired:
    """A mesh as it should have been.

    Attributes:
        mesh: In order, unit and axes of the rig.
        done: What was done, in a few words each.
    """

    mesh: Mesh
    done: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Examination:
    """What was found.

    Attributes:
        neutral: File of the neutral, or of a rig that holds neutral and targets.
        targets: Files of the targets, or their names in the rig.
        facts: What the neutral is made of; None where it could not be read.
        symmetric: Whether the neutral has a plane of symmetry; None where nobody asked.
        findings: The gravest first, then by kind and file.
        repaired: Meshes that can be repaired, by file.
        beyond_repair: Files of meshes that do not fit and could not be repaired.
        settings: What was known beforehand.
        meshes: The meshes of a rig, by name as above; empty where each is a file of its own.
    """

    neutral: str
    targets: tuple[str, ...]
    facts: SurfaceFacts | None
    symmetric: bool | None
    findings: tuple[Finding, ...]
    repaired: Mapping[str, Repaired]
    beyond_repair: tuple[str, ...]
    settings: Settings = field(default_factory=Settings)
    meshes: Mapping[str, Mesh] = field(default_factory=dict)

    def count(self, severity: Severity) -> int:
        """How many findings are that grave."""
        return sum(found.severity == severity for found in self.findings)

    def worst_is(self, severity: Severity) -> bool:
        """Whether there is a finding that grave or graver."""
        grave = SEVERITIES[: SEVERITIES.index(severity) + 1]
        return any(found.severity in grave for found in self.findings)

    @property
    def unreadable(self) -> bool:
        """Whether a file could not be read."""
        return any(found.name == "unreadable" for found in self.findings)


def in_order(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings, the gravest first, then by kind; those of a kind stay in the order of files."""
    kinds = list(KINDS)
    return tuple(
        sorted(findings, key=lambda f: (SEVERITIES.index(f.severity), kinds.index(f.name)))
    )


def unreadable(file: str, error: ElastomorphError) -> Finding:
    """The finding for a file that could not be read."""
    line = error.line if isinstance(error, FileError) else None
    message = str(error).removeprefix(f"{file}: ").removeprefix(f"{file}, line {line}: ")
    return finding("unreadable", file, message, line=line)


def unreadable_neutral(file: str, error: ElastomorphError, targets: Iterable[str]) -> Examination:
    """What is left to say where the neutral itself cannot be read."""
    names = tuple(targets)
    return Examination(file, names, None, None, (unreadable(file, error),), {}, names)
