"""What an examination has to say."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from elastomorph.doctor.checks.surface import SurfaceFacts
from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.kinds import KINDS, SEVERITIES, Severity
from elastomorph.doctor.settings import ExaminationSettings
from elastomorph.errors import ElastomorphError, FileError
from elastomorph.model.mesh import Mesh

__all__ = ["Examination", "Repaired", "in_order", "unreadable", "unreadable_neutral"]


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
    settings: ExaminationSettings = field(default_factory=ExaminationSettings)
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
