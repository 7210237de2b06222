"""Examines a neutral and its targets: every check once, in an order in which none misleads another.

A target is first put into the order of the neutral, then into its unit and axes, then the motion
of the head is taken out; what is looked for after that is looked for in the target as it should
have been, so that one fault is one finding.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.checks.area import AreaCheck
from elastomorph.doctor.checks.bends import BendCheck
from elastomorph.doctor.checks.frame import examine_frame
from elastomorph.doctor.checks.head import align, examine_head
from elastomorph.doctor.checks.jumps import JumpCheck
from elastomorph.doctor.checks.material import BeamSettings, examine_material
from elastomorph.doctor.checks.order import NeutralOrder
from elastomorph.doctor.checks.same_shape import does_nothing, examine_doubles
from elastomorph.doctor.checks.scramble import examine_scramble
from elastomorph.doctor.checks.surface import SurfaceFacts, examine_surface, surface_facts
from elastomorph.doctor.checks.symmetry import examine_names, examine_symmetry
from elastomorph.doctor.checks.welding import examine_welding
from elastomorph.doctor.findings import KINDS, SEVERITIES, Finding, Severity, finding
from elastomorph.doctor.mirror import find_mirror
from elastomorph.doctor.side_names import SIDES, sided_pairs
from elastomorph.doctor.thresholds import Thresholds
from elastomorph.errors import ElastomorphError, FileError, ParameterError
from elastomorph.mesh import Mesh

__all__ = ["Examination", "Repaired", "Settings", "examine", "in_order", "unreadable_neutral"]


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


@dataclass(frozen=True, eq=False)
class Repaired:
    """A target as it should have been.

    Attributes:
        mesh: In order, unit and axes of the neutral.
        done: What was done, in a few words each.
    """

    mesh: Mesh
    done: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Examination:
    """What was found.

    Attributes:
        neutral: File of the neutral.
        targets: Files of the targets.
        facts: What the neutral is made of; None where it could not be read.
        symmetric: Whether the neutral has a plane of symmetry; None where nobody asked.
        findings: The gravest first, then by kind and file.
        repaired: Targets that can be repaired, by file.
        beyond_repair: Files of targets that do not fit the neutral and could not be repaired.
    """

    neutral: str
    targets: tuple[str, ...]
    facts: SurfaceFacts | None
    symmetric: bool | None
    findings: tuple[Finding, ...]
    repaired: Mapping[str, Repaired]
    beyond_repair: tuple[str, ...]

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


def examine(
    neutral: Mesh,
    targets: Iterable[tuple[str, Mesh | ElastomorphError]],
    settings: Settings | None = None,
    *,
    file: str = "",
    say: Callable[[str], None] = lambda _: None,
) -> Examination:
    """Examine a neutral and its targets.

    Args:
        neutral: The neutral.
        targets: File and mesh of each target, or the error it could not be read for.
        settings: What is known beforehand.
        file: File of the neutral; by default where it was read from.
        say: Told what is being done.

    Raises:
        ParameterError: Vertices to align to that the neutral does not have, or a beam of no such
            order or closure.
    """
    settings = settings or Settings()
    patient = _Patient(neutral, file or neutral.name, settings)
    say(f"examining {patient.file}")
    patient.examine_neutral()
    for name, target in targets:
        say(f"examining {name}")
        patient.examine_target(name, target)
    say("comparing targets")
    return patient.result()


class _Patient:
    def __init__(self, neutral: Mesh, file: str, settings: Settings) -> None:
        self.neutral, self.file, self.settings = neutral, file, settings
        limits = settings.thresholds
        self.order = NeutralOrder(neutral, settings.seeds, limits.scale)
        self.areas = AreaCheck(neutral, limits.area)
        self.jumps = JumpCheck(neutral, limits)
        self.bends = BendCheck(neutral, limits.bend)
        self.findings: list[Finding] = []
        self.files: list[str] = []
        self.well: dict[str, Mesh] = {}
        self.repaired: dict[str, Repaired] = {}
        self.lost: list[str] = []
        _require_vertices(neutral, settings, file)

    def examine_neutral(self) -> None:
        self.findings += examine_surface(self.neutral, self.file)
        self.findings += self.areas.neutral(self.neutral, self.file)
        self.findings += examine_welding(self.neutral, self.file)
        if self.settings.beam is not None:
            self.findings += examine_material(self.neutral, self.file, self.settings.beam)

    def examine_target(self, file: str, target: Mesh | ElastomorphError) -> None:
        self.files.append(file)
        if isinstance(target, ElastomorphError):
            self.findings.append(_unreadable(file, target))
            self.lost.append(file)
            return
        limits, still = self.settings.thresholds, self.settings.still
        ordered = self.order.examine(target, file)
        self.findings += ordered.findings
        framed = None
        if ordered.mesh is not None:
            framed = examine_frame(self.neutral, ordered.mesh, file, limits.scale)
            self.findings += framed.findings
        if framed is None or framed.mesh is None:
            self.lost.append(file)
            return
        torn = examine_scramble(self.neutral, framed.mesh, file, limits.torn)
        if torn:
            self.findings += torn
            self.lost.append(file)
            return
        if ordered.findings and not ordered.repair:
            self.lost.append(file)
        steadied = examine_head(
            self.neutral, framed.mesh, file, allowed=limits.head, steadier=limits.steadier
        )
        self.findings += steadied.findings
        done = [text for text in (ordered.repair, framed.repair) if text]
        whole, best = framed.mesh, steadied.mesh
        if still is not None:
            best = align(self.neutral, framed.mesh, still)
            farthest = float(np.abs(best.vertices - whole.vertices).max())
            if farthest > limits.nothing * (self.neutral.diameter or 1.0):
                whole = best
                done.append("aligned to the vertices named")
        elif self.settings.steady and steadied.moved:
            whole = best
            done.append("motion of the head taken out")
        if done:
            self.repaired[file] = Repaired(whole, tuple(done))
        nothing = does_nothing(self.neutral, best, file, limits.nothing)
        self.findings += nothing
        if not nothing:
            self.findings += self.jumps.target(best, file)
            self.findings += self.areas.target(best, file)
            self.findings += self.bends.target(best, file)
            self.well[file] = best

    def result(self) -> Examination:
        limits, sides = self.settings.thresholds, self.settings.sides
        self.findings += examine_doubles(self.neutral, self.well, limits.nothing)
        names = {Path(file).stem: file for file in self.files}
        self.findings += examine_names(names, sides)
        meshes = {name: self.well[file] for name, file in names.items() if file in self.well}
        symmetric = None
        if sided_pairs(meshes, sides)[0]:
            mirror = find_mirror(self.neutral)
            symmetric = mirror is not None
            if mirror is not None:
                at_fault = {name: self._vertices_at_fault(file) for name, file in names.items()}
                self.findings += examine_symmetry(
                    self.neutral, meshes, names, mirror, limits, sides, at_fault
                )
        lost = tuple(file for file in self.lost if file not in self.repaired)
        return Examination(
            self.file,
            tuple(self.files),
            surface_facts(self.neutral),
            symmetric,
            in_order(self.findings),
            self.repaired,
            lost,
        )

    def _vertices_at_fault(self, file: str) -> list[int]:
        return [vertex for f in self.findings if f.file == file for vertex in f.vertices]


def in_order(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings, the gravest first, then by kind; those of a kind stay in the order of files."""
    kinds = list(KINDS)
    return tuple(
        sorted(findings, key=lambda f: (SEVERITIES.index(f.severity), kinds.index(f.name)))
    )


def _unreadable(file: str, error: ElastomorphError) -> Finding:
    line = error.line if isinstance(error, FileError) else None
    message = str(error).removeprefix(f"{file}: ").removeprefix(f"{file}, line {line}: ")
    return finding("unreadable", file, message, line=line)


def unreadable_neutral(file: str, error: ElastomorphError, targets: Iterable[str]) -> Examination:
    """What is left to say where the neutral itself cannot be read."""
    names = tuple(targets)
    return Examination(file, names, None, None, (_unreadable(file, error),), {}, names)


def _require_vertices(neutral: Mesh, settings: Settings, file: str) -> None:
    wanted = np.array([pair[0] for pair in settings.seeds], dtype=np.int64)
    if settings.still is not None:
        wanted = np.concatenate([wanted, settings.still])
        if len(np.unique(settings.still)) < 3:
            raise ParameterError("--align needs three vertices or more that are not on a line")
    bad = wanted[(wanted >= len(neutral.vertices)) | (wanted < 0)]
    if bad.size:
        raise ParameterError(
            f"{file} has no vertex {int(bad[0]):,}, only 0 to {len(neutral.vertices) - 1:,}"
        )
