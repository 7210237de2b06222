"""One rig on its way through all checks."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

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
from elastomorph.doctor.checks.winding import common_turn, reversed_finding
from elastomorph.doctor.examination import Examination, Repaired, Settings, in_order, unreadable
from elastomorph.doctor.findings import Finding
from elastomorph.doctor.frames import Frame, frame_between
from elastomorph.doctor.mirror import find_mirror
from elastomorph.doctor.neighbours import Neighbours
from elastomorph.doctor.side_names import sided_pairs
from elastomorph.errors import ElastomorphError
from elastomorph.model.mesh import Mesh

__all__ = ["Patient"]

# Findings that leave no vertex as it should be, so that another comparison says nothing new.
_EVERYWHERE = frozenset({"noise", "baked-in-target"})


class Patient:
    """One rig on its way through all checks.

    Attributes:
        neutral: The neutral, as it should be.
        file: Its file.
        files: Those of the targets.
        name_of: The name of a target, from its file.
        meshes: As in `Examination`.
        framed: Targets in the order, unit and axes of the neutral, by file.
        well: Targets as they should be, by file.
        turned: Polygons of the neutral that targets run the other way round, by file.
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
        self.turned: dict[str, NDArray[np.bool_]] = {}
        self.lost: list[str] = []
        settings.require_vertices(neutral, file)

    # Prepared once it is known in which unit the neutral should be.
    @cached_property
    def _areas(self) -> AreaCheck:
        return AreaCheck(self.neutral, self.settings.thresholds.area)

    @cached_property
    def _around(self) -> Neighbours:
        return Neighbours(self.neutral)

    @cached_property
    def _jumps(self) -> JumpCheck:
        return JumpCheck(self.neutral, self._around, self.settings.thresholds)

    @cached_property
    def _bends(self) -> BendCheck:
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
        mesh = ordered.mesh if deltas is None else deltas[1]
        if deltas is not None:
            self.findings.append(deltas[0])
        if mesh is None:
            self.lost.append(file)
            return
        if deltas is not None:
            self.done[file].append("added to the neutral")
        self.ordered[file] = mesh
        none = np.zeros(len(self.neutral.faces), dtype=bool)
        self.turned[file] = none if ordered.turned is None else ordered.turned

    def wind(self) -> None:
        """Where most targets run polygons the other way round, turn those of the neutral."""
        wrong = common_turn(list(self.turned.values()))
        if wrong is None:
            return
        which = np.flatnonzero(wrong)
        for file, own in self.turned.items():
            mesh = self.ordered[file]
            self.ordered[file] = turned(mesh, wrong)
            if np.array_equal(own, wrong):
                kept = (f for f in self.findings if (f.name, f.file) != ("reversed-winding", file))
                self.findings = list(kept)
                del self.done[file][0]
            elif not own.any():
                self.findings.append(reversed_finding(mesh, file, which, "in most targets"))
                self.done[file].append("polygons wound as in most targets")
        found = reversed_finding(self.neutral, self.file, which, "in most targets")
        self.findings.append(found)
        self.neutral = turned(self.neutral, wrong)
        self.done[self.file] = ["polygons wound as in most targets"]
        self.repaired[self.file] = Repaired(self.neutral, tuple(self.done[self.file]))

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
            self.rough[file] = roughness(self.neutral, best, self._around)
            self.findings += self._jumps.target(best, file)
            self.findings += self._areas.target(best, file)
            self.findings += self._bends.target(best, file)
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
