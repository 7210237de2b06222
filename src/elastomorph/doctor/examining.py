"""Examines a neutral and its targets: every check once, in an order in which none misleads another.

A target is first put into the order of the neutral, then into its unit and axes, then the motion
of the head is taken out; what is looked for after that is looked for in the target as it should
have been, so that one fault is one finding. Where most targets agree with each other against the
neutral, it is the neutral that is repaired.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property
from pathlib import Path

import numpy as np

from elastomorph.doctor.checks.area import AreaCheck
from elastomorph.doctor.checks.baked import examine_baked
from elastomorph.doctor.checks.bends import BendCheck
from elastomorph.doctor.checks.deltas import examine_deltas
from elastomorph.doctor.checks.frame import InFrame, common_frame, in_frame
from elastomorph.doctor.checks.head import align, examine_head
from elastomorph.doctor.checks.inside_out import inside_out, inside_out_finding
from elastomorph.doctor.checks.jumps import JumpCheck
from elastomorph.doctor.checks.material import examine_material
from elastomorph.doctor.checks.noise import examine_noise, roughness
from elastomorph.doctor.checks.order import NeutralOrder
from elastomorph.doctor.checks.reordering import turned
from elastomorph.doctor.checks.same_shape import does_nothing, examine_doubles
from elastomorph.doctor.checks.scramble import examine_scramble
from elastomorph.doctor.checks.surface import examine_surface, surface_facts
from elastomorph.doctor.checks.symmetry import examine_names, examine_symmetry
from elastomorph.doctor.checks.welding import examine_welding
from elastomorph.doctor.examination import Examination, Repaired, Settings, in_order, unreadable
from elastomorph.doctor.findings import Finding
from elastomorph.doctor.frames import Frame, frame_between
from elastomorph.doctor.mirror import find_mirror
from elastomorph.doctor.neighbours import Neighbours
from elastomorph.doctor.side_names import sided_pairs
from elastomorph.errors import ElastomorphError, ParameterError
from elastomorph.mesh import Mesh
from elastomorph.rig import Rig

__all__ = ["examine", "examine_rig"]

Say = Callable[[str], None]

# Findings that leave no vertex as it should be, so that another comparison says nothing new.
_EVERYWHERE = frozenset({"noise", "baked-in-target"})


def examine(
    neutral: Mesh,
    targets: Iterable[tuple[str, Mesh | ElastomorphError]],
    settings: Settings | None = None,
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
    settings = settings or Settings()
    return _examined(_Patient(neutral, file or neutral.name, settings), targets, say)


def examine_rig(
    rig: Rig,
    settings: Settings | None = None,
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
    meshes = {morph: path.target for morph, path in rig.morphs.items()}
    name = file or rig.neutral.name
    if name in meshes:
        name = f"{name} (rig)"
    patient = _Patient(rig.neutral, name, settings or Settings())
    patient.name_of, patient.meshes = str, {name: rig.neutral, **meshes}
    return _examined(patient, meshes.items(), say)


def _examined(
    patient: _Patient, targets: Iterable[tuple[str, Mesh | ElastomorphError]], say: Say
) -> Examination:
    say(f"examining {patient.file}")
    patient.examine_neutral()
    for number, (given, target) in enumerate(targets):
        name = given or f"target {number}"
        if name == patient.file or name in patient.done:
            name = f"{name} ({number})"
        say(f"comparing {name}")
        patient.put_in_order(name, target)
    patient.put_in_frame()
    for name in list(patient.framed):
        say(f"examining {name}")
        patient.examine_target(name)
    say("comparing targets")
    return patient.result()


class _Patient:
    """One rig on its way through all checks.

    Attributes:
        neutral: The neutral, as it should be.
        file: Its file.
        files: Those of the targets.
        name_of: The name of a target, from its file.
        meshes: As in `Examination`.
        framed: Targets in the order, unit and axes of the neutral, by file.
        well: Targets as they should be, by file.
        rough: How noisy they are, by file.
        whole: Meshes as they would be repaired, by file.
        done: What was done to each file, in a few words each.
    """

    def __init__(self, neutral: Mesh, file: str, settings: Settings) -> None:
        self.neutral, self.file, self.settings = neutral, file, settings
        self.name_of: Callable[[str], str] = lambda name: Path(name).stem
        self.meshes: dict[str, Mesh] = {}
        self.order = NeutralOrder(neutral, settings.seeds, settings.thresholds.scale)
        self.findings: list[Finding] = []
        self.files: list[str] = []
        self.ordered: dict[str, Mesh] = {}
        self.framed: dict[str, Mesh] = {}
        self.well: dict[str, Mesh] = {}
        self.done: dict[str, list[str]] = {}
        self.rough: dict[str, float] = {}
        self.whole: dict[str, Mesh] = {}
        self.repaired: dict[str, Repaired] = {}
        self.lost: list[str] = []
        _require_vertices(neutral, settings, file)

    # Prepared once it is known in which unit the neutral should be.
    @cached_property
    def areas(self) -> AreaCheck:
        return AreaCheck(self.neutral, self.settings.thresholds.area)

    @cached_property
    def around(self) -> Neighbours:
        return Neighbours(self.neutral)

    @cached_property
    def jumps(self) -> JumpCheck:
        return JumpCheck(self.neutral, self.around, self.settings.thresholds)

    @cached_property
    def bends(self) -> BendCheck:
        return BendCheck(self.neutral, self.settings.thresholds.bend)

    def examine_neutral(self) -> None:
        """What is wrong with the neutral, whatever the targets are."""
        area = AreaCheck(self.neutral, self.settings.thresholds.area)
        self.findings += examine_surface(self.neutral, self.file)
        self.findings += area.neutral(self.neutral, self.file)
        self.findings += examine_welding(self.neutral, self.file)
        if self.settings.beam is not None:
            self.findings += examine_material(self.neutral, self.file, self.settings.beam)

    def put_in_order(self, file: str, target: Mesh | ElastomorphError) -> None:
        """Give a target the vertices and polygons of the neutral."""
        self.files.append(file)
        self.done[file] = []
        if isinstance(target, ElastomorphError):
            self.findings.append(unreadable(file, target))
            self.lost.append(file)
            return
        ordered = self.order.examine(target, file)
        self.findings += ordered.findings
        if ordered.repair:
            self.done[file].append(ordered.repair)
        if ordered.mesh is None:
            self.lost.append(file)
            return
        deltas = examine_deltas(self.neutral, ordered.mesh, file, self.settings.thresholds)
        if deltas is not None:
            self.findings.append(deltas[0])
            self.done[file].append("added to the neutral")
        self.ordered[file] = ordered.mesh if deltas is None else deltas[1]

    def put_in_frame(self) -> None:
        """Give neutral and targets one unit and the same axes, those of most of them."""
        frames = self._frames()
        common = common_frame(list(frames.values()))
        # A mirror image shows its back: that of neutral and targets that does is the wrong one.
        if common is not None and (not common.mirrored or inside_out(self.neutral).any()):
            self._take(
                self.file, in_frame(self.neutral, common.inverse(), self.file, "most targets")
            )
            self.neutral = self.neutral.with_vertices(common.forth(self.neutral.vertices))
            frames = self._frames()
        for file, mesh in self.ordered.items():
            framed = in_frame(mesh, frames[file], file, "the neutral")
            self._take(file, framed)
            if framed.mesh is not None:
                self.framed[file] = framed.mesh
        self.ordered.clear()

    def _frames(self) -> dict[str, Frame]:
        scale = self.settings.thresholds.scale
        return {
            file: frame_between(self.neutral.vertices, mesh.vertices, scale)
            for file, mesh in self.ordered.items()
        }

    def _take(self, file: str, framed: InFrame) -> None:
        self.findings += framed.findings
        if framed.mesh is None:
            self.lost.append(file)
        elif framed.repair:
            self.done.setdefault(file, []).append(framed.repair)
            self.repaired[file] = Repaired(framed.mesh, tuple(self.done[file]))

    def examine_target(self, file: str) -> None:
        """What is wrong with a target in the order, unit and axes of the neutral."""
        limits, mesh = self.settings.thresholds, self.framed.pop(file)
        torn = examine_scramble(self.neutral, mesh, file, limits.torn)
        if torn:
            self.findings += torn
            self.lost.append(file)
            self.repaired.pop(file, None)
            return
        best = self._steadied(file, mesh)
        nothing = does_nothing(self.neutral, best, file, limits.nothing)
        self.findings += nothing
        if not nothing:
            self.rough[file] = roughness(self.neutral, best, self.around)
            self.findings += self.jumps.target(best, file)
            self.findings += self.areas.target(best, file)
            self.findings += self.bends.target(best, file)
            self.well[file] = best

    def _steadied(self, file: str, mesh: Mesh) -> Mesh:
        """The target without the motion of its head, which is repaired if that was asked."""
        limits, still = self.settings.thresholds, self.settings.still
        steadied = examine_head(
            self.neutral, mesh, file, allowed=limits.head, steadier=limits.steadier
        )
        self.findings += steadied.findings
        done, whole, best = self.done[file], mesh, steadied.mesh
        if still is not None:
            best = align(self.neutral, mesh, still)
            farthest = float(np.abs(best.vertices - whole.vertices).max())
            if farthest > limits.nothing * (self.neutral.diameter or 1.0):
                whole = best
                done.append("aligned to the vertices named")
        elif self.settings.steady and steadied.moved:
            whole = best
            done.append("motion of the head taken out")
        if done:
            self.repaired[file] = Repaired(whole, tuple(done))
        self.whole[file] = whole
        return best

    def result(self) -> Examination:
        """Compare targets with each other, and sum up."""
        limits = self.settings.thresholds
        self.findings += examine_noise(self.rough, limits)
        self.findings += examine_doubles(self.neutral, self.well, limits.nothing)
        self.findings += examine_baked(
            self.neutral, self.well, limits, self.settings.sides, self.name_of
        )
        self._turn_inside_out()
        symmetric = self._compare_sides()
        return Examination(
            self.file,
            tuple(self.files),
            surface_facts(self.neutral),
            symmetric,
            in_order(self.findings),
            self.repaired,
            tuple(file for file in self.lost if file not in self.repaired),
            self.settings,
            self.meshes,
        )

    def _turn_inside_out(self) -> None:
        """Wind what shows its back the other way round, in all files."""
        wrong = inside_out(self.neutral)
        if not wrong.any():
            return
        self.findings.append(inside_out_finding(self.neutral, self.file, wrong))
        for file, mesh in {self.file: self.neutral, **self.whole}.items():
            self.done.setdefault(file, []).append("polygons turned to show their front")
            self.repaired[file] = Repaired(turned(mesh, wrong), tuple(self.done[file]))

    def _compare_sides(self) -> bool | None:
        limits, sides = self.settings.thresholds, self.settings.sides
        names = {self.name_of(file): file for file in self.files}
        self.findings += examine_names(names, sides)
        meshes = {name: self.well[file] for name, file in names.items() if file in self.well}
        if not sided_pairs(meshes, sides)[0]:
            return None
        mirror = find_mirror(self.neutral)
        if mirror is None:
            return False
        at_fault = {name: self._vertices_at_fault(file) for name, file in names.items()}
        self.findings += examine_symmetry(
            self.neutral, meshes, names, mirror, limits, sides, at_fault
        )
        return True

    def _vertices_at_fault(self, file: str) -> list[int]:
        kinds = {f.name for f in self.findings if f.file == file and f.severity != "note"}
        if kinds & _EVERYWHERE:
            return list(range(len(self.neutral.vertices)))
        return [vertex for f in self.findings if f.file == file for vertex in f.vertices]


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
