"""Examines a neutral and its targets: every check once, in an order in which none misleads another.

A target is first put into the order of the neutral, then into its unit and axes, then the motion
of the head is taken out; what is looked for after that is looked for in the target as it should
have been, so that one fault is one finding. Where most targets agree with each other against the
neutral, it is the neutral that is repaired.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.checks import order, placement, sides, surface
from elastomorph.doctor.checks import targets as shapes
from elastomorph.doctor.checks.order import NeutralOrder
from elastomorph.doctor.checks.sides import find_mirror
from elastomorph.doctor.findings import (
    Examination,
    Finding,
    Outcome,
    Repaired,
    counted,
    listed,
    polygon_finding,
    rank,
    unreadable,
)
from elastomorph.doctor.frames import Frame, frame_between
from elastomorph.doctor.neutral import Neutral
from elastomorph.doctor.settings import ExaminationSettings
from elastomorph.errors import ElastomorphError
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig

Say = Callable[[str], None]

_TARGET_CHECKS: tuple[Callable[[Neutral, Mesh, str], list[Finding]], ...] = (
    shapes.jumping_vertices,
    surface.lost_area,
    shapes.in_between_pays,
)
# Findings that leave no vertex as it should be, so that another comparison says nothing new.
_EVERYWHERE = frozenset({"noise", "baked-in-target"})
_MOST = "in most targets"
_WOUND = f"polygons wound as {_MOST}"


def examine(
    neutral: Mesh,
    targets: Iterable[tuple[str, Mesh | ElastomorphError]],
    settings: ExaminationSettings | None = None,
    *,
    file: str = "",
    say: Say = lambda _: None,
) -> Examination:
    """Examine a neutral and its targets.

    Args:
        neutral: The neutral.
        targets: File and mesh of each target, or the error it could not be read for. Those without
            a name, or with that of another, are told by their number.
        settings: What is known beforehand.
        file: File of the neutral; by default where it was read from.
        say: Told what is being done.

    Raises:
        ParameterError: Vertices to align to that the neutral does not have, or a beam of no such
            order or closure.
    """
    examiner = _Examiner(neutral, file or neutral.name, settings or ExaminationSettings(), say)
    return examiner.examine(targets, lambda name: Path(name).stem, {})


def examine_rig(
    rig: Rig,
    settings: ExaminationSettings | None = None,
    *,
    file: str = "",
    say: Say = lambda _: None,
) -> Examination:
    """Examine the shapes of a rig: its neutral, and the target at the end of every path.

    Args:
        rig: The rig.
        settings: What is known beforehand.
        file: What to call it; by default the file its neutral was read from.
        say: Told what is being done.

    Returns:
        The examination; its targets are called as in the rig.

    Raises:
        ParameterError: As `examine`.
    """
    targets = rig.targets
    name = file or rig.neutral.name
    if name in targets:
        name = f"{name} (rig)"
    examiner = _Examiner(rig.neutral, name, settings or ExaminationSettings(), say)
    return examiner.examine(targets.items(), str, {name: rig.neutral, **targets})


@dataclass(eq=False)
class _Target:
    """One target on its way through all checks."""

    mesh: Mesh  # as it would be repaired: in order, then in unit and axes of the neutral
    reversed: NDArray[np.bool_]  # (F,) polygons of the neutral that it runs the other way round
    done: list[str]  # in a few words each
    clean: Mesh | None = None  # as it should be, which a repair may not have been asked for


class _Examiner:
    """One rig on its way through all checks."""

    def __init__(self, neutral: Mesh, file: str, settings: ExaminationSettings, say: Say) -> None:
        settings.require_vertices(neutral, file)
        self.file, self.settings, self.limits, self.say = file, settings, settings.thresholds, say
        # The neutral as it should be, as it would be repaired, and what was done to it.
        self.neutral, self.mesh = Neutral(neutral, self.limits), neutral
        self.done: list[str] = []
        self.findings: list[Finding] = []
        # Targets by file that still belong to the rig, and files of meshes that do not.
        self.targets: dict[str, _Target] = {}
        self.lost: list[str] = []

    def examine(
        self,
        targets: Iterable[tuple[str, Mesh | ElastomorphError]],
        name_of: Callable[[str], str],
        meshes: Mapping[str, Mesh],
    ) -> Examination:
        """Every check; ``name_of`` tells the name of a target from its file."""
        self.say(f"examining {self.file}")
        self.findings += surface.examine_surface(self.neutral, self.file)
        if beam := self.settings.beam:
            self.findings += shapes.examine_material(self.neutral.mesh, self.file, beam)
        order = NeutralOrder(self.neutral.mesh, self.settings.seeds, self.limits.scale)
        files: list[str] = []
        for number, (given, target) in enumerate(targets):
            name = given or f"target {number}"
            if name == self.file or name in files:
                name = f"{name} ({number})"
            self.say(f"comparing {name}")
            files.append(name)
            self._put_in_order(name, target, order)
        self._wind()
        self._put_in_frame()
        for name, own in list(self.targets.items()):
            self.say(f"examining {name}")
            self._examine_target(name, own)
        self.say("comparing targets")
        clean = {file: own.clean for file, own in self.targets.items() if own.clean is not None}
        self.findings += shapes.noisy_targets(self.neutral, clean)
        self.findings += shapes.duplicate_targets(self.neutral, clean)
        self.findings += shapes.baked_targets(self.neutral, clean, self.settings.sides, name_of)
        self._turn_inside_out()
        symmetric = self._compare_sides({name_of(file): file for file in files}, clean)
        made = [(file, own.mesh, own.done) for file, own in self.targets.items()]
        made += [] if self.file in self.lost else [(self.file, self.mesh, self.done)]
        repaired = {file: Repaired(mesh, tuple(done)) for file, mesh, done in made if done}
        return Examination(
            self.file,
            tuple(files),
            surface.surface_facts(self.neutral.mesh),
            symmetric,
            tuple(sorted(self.findings, key=rank)),
            repaired,
            tuple(self.lost),
            self.settings,
            meshes,
        )

    def _put_in_order(
        self, file: str, target: Mesh | ElastomorphError, order: NeutralOrder
    ) -> None:
        """Give a target the vertices and polygons of the neutral."""
        if isinstance(target, ElastomorphError):
            self.findings.append(unreadable(file, target))
            self.lost.append(file)
            return
        ordered = order.examine(target, file)
        steps, mesh = [ordered], ordered.mesh
        if mesh is not None:
            shape = placement.saved_as_deltas(self.neutral.mesh, mesh, file, self.limits)
            if shape is not None:
                steps, mesh = [ordered, shape], shape.mesh
        self.findings += [found for step in steps for found in step.findings]
        if mesh is None:
            self.lost.append(file)
            return
        none = np.zeros(len(mesh.faces), dtype=bool)
        wrong = none if ordered.reversed is None else ordered.reversed
        self.targets[file] = _Target(mesh, wrong, [step.repair for step in steps if step.repair])

    def _wind(self) -> None:
        """Where most targets run polygons the other way round, turn those of the neutral."""
        wrong = order.common_reversal([own.reversed for own in self.targets.values()])
        if wrong is None:
            return
        which = np.flatnonzero(wrong)
        for file, own in self.targets.items():
            own.mesh = order.with_reversed(own.mesh, wrong)
            if np.array_equal(own.reversed, wrong):
                named = ("reversed-winding", file)
                self.findings = [f for f in self.findings if (f.name, f.file) != named]
                del own.done[0]
            elif not own.reversed.any():
                self.findings.append(order.reversed_finding(own.mesh, file, which, _MOST))
                own.done.append(_WOUND)
        mesh = self.neutral.mesh
        self.findings.append(order.reversed_finding(mesh, self.file, which, _MOST))
        self.mesh = order.with_reversed(mesh, wrong)
        self.neutral = Neutral(self.mesh, self.limits)
        self.done.append(_WOUND)

    def _put_in_frame(self) -> None:
        """Give neutral and targets one unit and the same axes, those of most of them."""
        mesh, frames = self.neutral.mesh, self._frames()
        common = placement.common_frame(list(frames.values()))
        # A mirror image shows its back: that of neutral and targets that does is the wrong one.
        if common is not None and (not common.mirrored or order.inside_out(mesh).any()):
            framed = placement.in_frame(mesh, common.inverse(), self.file, "most targets")
            self._take(self.file, framed, self.done)
            self.mesh = framed.mesh or mesh
            there = mesh.with_vertices(common.forth(mesh.vertices))
            self.neutral = Neutral(there, self.limits)
            frames = self._frames()
        for file, frame in frames.items():
            own = self.targets[file]
            framed = placement.in_frame(own.mesh, frame, file, "the neutral")
            self._take(file, framed, own.done)
            if framed.mesh is None:
                del self.targets[file]
            else:
                own.mesh = framed.mesh

    def _frames(self) -> dict[str, Frame]:
        here = self.neutral.mesh.vertices
        return {
            file: frame_between(here, own.mesh.vertices, self.limits.scale)
            for file, own in self.targets.items()
        }

    def _take(self, file: str, framed: Outcome, done: list[str]) -> None:
        self.findings += framed.findings
        if framed.mesh is None:
            self.lost.append(file)
        elif framed.repair:
            done.append(framed.repair)

    def _examine_target(self, file: str, own: _Target) -> None:
        """What is wrong with a target in the order, unit and axes of the neutral."""
        if scrambled := shapes.scrambled_vertices(self.neutral, own.mesh, file):
            self.findings += scrambled
            self.lost.append(file)
            del self.targets[file]
            return
        best = self._steadied(file, own)
        nothing = shapes.does_nothing(self.neutral, best, file)
        self.findings += nothing
        if not nothing:
            for check in _TARGET_CHECKS:
                self.findings += check(self.neutral, best, file)
            own.clean = best

    def _steadied(self, file: str, own: _Target) -> Mesh:
        """The target without the motion of its head, which is repaired if that was asked."""
        limits, still, neutral = self.limits, self.settings.still, self.neutral.mesh
        found = placement.steadied(neutral, own.mesh, file, limits)
        self.findings += found.findings
        best = found.mesh or own.mesh
        if still is not None:
            best = placement.align(neutral, own.mesh, still)
            farthest = float(np.abs(best.vertices - own.mesh.vertices).max())
            if farthest > limits.nothing * self.neutral.scale:
                own.mesh = best
                own.done.append("aligned to the vertices named")
        elif self.settings.steady and found.repair:
            own.mesh = best
            own.done.append(found.repair)
        return best

    def _turn_inside_out(self) -> None:
        """Wind what shows its back the other way round, in all files."""
        wrong = order.inside_out(self.neutral.mesh)
        if not wrong.any():
            return
        which = np.flatnonzero(wrong)
        shows = counted(which, "polygon shows its", "polygons show their")
        message = f"{shows} back, in all files alike: {listed(which)}"
        mesh = self.neutral.mesh
        self.findings.append(polygon_finding("inside-out", mesh, self.file, which, message))
        self.mesh = order.with_reversed(mesh, wrong)
        for own in self.targets.values():
            own.mesh = order.with_reversed(own.mesh, wrong)
        for done in (self.done, *(own.done for own in self.targets.values())):
            done.append("polygons turned to show their front")

    def _compare_sides(self, files: Mapping[str, str], clean: Mapping[str, Mesh]) -> bool | None:
        """Whether left and right could be compared: None without pairs, False without a plane."""
        neutral, words = self.neutral, self.settings.sides
        self.findings += sides.missing_sides(files, words)
        meshes = {name: clean[file] for name, file in files.items() if file in clean}
        pairs = sides.sided_pairs(meshes, words)[0]
        if not pairs:
            return None
        mirror = find_mirror(neutral.mesh)
        if mirror is None:
            return False
        faulty = {name: self._faulty_vertices(file) for name, file in files.items()}
        self.findings += sides.asymmetric_pairs(neutral, meshes, files, mirror, pairs, faulty)
        self.findings += sides.swapped_sides(neutral, meshes, files, mirror, pairs)
        return True

    def _faulty_vertices(self, file: str) -> list[int]:
        kinds = {f.name for f in self.findings if f.file == file and f.severity != "note"}
        if kinds & _EVERYWHERE:
            return list(range(len(self.neutral.mesh.vertices)))
        return [vertex for f in self.findings if f.file == file for vertex in f.vertices]
