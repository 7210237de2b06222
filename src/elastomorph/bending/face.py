"""The face that a character's meshes make up: as paths are computed, and back to its meshes.

Teeth, tongue, lashes and brows are meshes of their own, with targets of the same names as the skin.
Together, where the scene shows them at rest, they are one face, so that a jaw takes its teeth along
on the same arc.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.container import GltfFile, object_of
from elastomorph.io.gltf.mesh_extras import is_part
from elastomorph.io.gltf.nodes import PlacedMesh, placed_meshes
from elastomorph.io.gltf.primitives import Attributes
from elastomorph.io.gltf.reader import (
    ReadMesh,
    Sheet,
    named_bends,
    read_meshes,
    require_known_extensions,
    rig_of,
)
from elastomorph.io.gltf.rig_extras import described_meshes
from elastomorph.io.untrusted import naming_file, shortened
from elastomorph.model.mesh import Mesh
from elastomorph.paths.welding import Welding
from elastomorph.rig import Rig
from elastomorph.rig.build import bare_rig


@dataclass(frozen=True, eq=False)
class FaceMesh:
    """A mesh of the file that has targets.

    Attributes:
        number: Its number.
        names: Of its targets, in their order, each different from the others.
        morph_of: The morph that each target is Δ of, by its name.
        blocks: The vertices of its primitives.
        block_of: The block of each primitive, by its number; lines, which are not read, have none.
        rig_vertices: (N,) the vertex of the face that each of these vertices is.
        bends: Its bends, and how far each moves a vertex at most, by the names of their targets.
        bent: Whether its paths are bent in the file, which then says how.
        stored: ``extras.elastomorph`` of the mesh.
        diameter: Of the mesh where the scene shows it.
    """

    number: int
    names: tuple[str, ...]
    morph_of: Mapping[str, str]
    blocks: tuple[Attributes, ...]
    block_of: Mapping[int, int]
    rig_vertices: NDArray[np.int64]
    bends: Mapping[str, float]
    bent: bool
    stored: Mapping[str, Any]
    diameter: float


@dataclass(frozen=True, eq=False)
class Face:
    """All meshes of a file that have targets, as one."""

    file: GltfFile
    rig: Rig  # as the file shows it
    meshes: tuple[FaceMesh, ...]

    @classmethod
    def read(cls, file: GltfFile, *, bent: bool = False) -> Face:
        """The face in a file, whose paths must be straight unless they may be bent."""
        require_known_extensions(file)
        with naming_file(file.path):
            placed, described = placed_meshes(file), described_meshes(file)
            wanted = _with_targets(file, placed)
            if not wanted:
                file.refuse(
                    "none of its meshes has morph targets (blend shapes, shape keys), so there is "
                    "nothing to bend; export it with them"
                )
            shown = [own for own in placed if own in wanted or is_part(described.get(own.number))]
            meshes = read_meshes(file, shown)
            _require_curves(file, meshes)
            if not bent:
                _require_straight(file, meshes)
            return cls._of(file, meshes, rig_of(file, meshes))

    @classmethod
    def of(cls, file: GltfFile, meshes: Sequence[ReadMesh], rig: Rig) -> Face:
        """The face in a file of which some meshes were read, and the rig that they are together.

        Those without targets are a part of the rig, as of `elastomorph.io.gltf.read_glb`.
        """
        with naming_file(file.path):
            _require_straight(file, meshes)
            return cls._of(file, meshes, rig)

    @classmethod
    def _of(cls, file: GltfFile, meshes: Sequence[ReadMesh], rig: Rig) -> Face:
        starts = np.cumsum([0, *(len(own.part.mesh.vertices) for own in meshes)])
        sheets = [
            (own, sheet, start)
            for own, start in zip(meshes, starts, strict=False)
            for sheet in own.sheets
        ]
        wanted = _with_targets(file, [sheet.placed for _, sheet, _ in sheets])
        found = [
            _face_mesh(file, own, sheet, start)
            for own, sheet, start in sheets
            if any(sheet.placed is one for one in wanted)
        ]
        return cls(file, rig, tuple(found))

    @cached_property
    def welding(self) -> Welding:
        """The parts of it that move, without the seams of its exporter."""
        targets = [morph.target.vertices for morph in self.rig.morphs.values()]
        if all(np.array_equal(own, self.rig.neutral.vertices) for own in targets):
            self.file.refuse(
                "none of its morph targets moves any vertex that is seen, so there is nothing to "
                "bend; export it with blend shapes that move, in nodes of some size"
            )
        return Welding.of(self.rig.neutral, targets)

    def moving(self) -> Rig:
        """The face that paths are made for."""
        welding, sliders = self.welding, self.rig.sliders
        targets: dict[str, Mesh] = {
            name: welding.mesh(morph.target) for name, morph in self.rig.morphs.items()
        }
        bare = bare_rig(welding.neutral, targets)
        return Rig(
            welding.neutral, bare.morphs, correctives=sliders.correctives, groups=sliders.groups
        )


def _with_targets(file: GltfFile, shown: Sequence[PlacedMesh]) -> list[PlacedMesh]:
    """Those of some meshes that have targets, each once."""
    placed: dict[int, PlacedMesh] = {}
    for own in shown:  # of several nodes with one mesh, the first places it
        placed.setdefault(own.number, own)
    return [own for own in placed.values() if _target_count(file, own.number)]


def _target_count(file: GltfFile, number: int) -> int:
    """Targets of a mesh, as many in each of its primitives."""
    of = f"mesh {number}"
    mesh = file.item("meshes", number, "a node")
    counts = []
    for primitive in file.list_in(mesh, "primitives", of):
        if not isinstance(primitive, dict):
            file.refuse(f"a primitive of {of} is no object")
        targets = file.list_in(primitive, "targets", of)
        if not all(isinstance(target, dict) for target in targets):
            file.refuse(f"a morph target of {of} is no object")
        counts.append(len(targets))
    if len(set(counts)) > 1:
        file.refuse(
            f"the primitives of {of} have {min(counts)} to {max(counts)} morph targets; glTF asks "
            "for as many in each. Export it again, or give the others targets that move nothing"
        )
    return max(counts, default=0)


def _require_curves(file: GltfFile, meshes: Sequence[ReadMesh]) -> None:
    """Refuse targets named as bends are and without curves: of whoever they are, only users know.

    What gltfpack leaves of a bent file and what an artist called so are the same in the file.
    """
    lost = [sheet for own in meshes if own.gone for sheet in own.sheets]
    for sheet in lost:
        if _bends_unknown(sheet):
            file.refuse(
                "what elastomorph stored beside a mesh with bends no longer fits it, so that they "
                "would be bent again: 'elastomorph bend FILE --from BENT' gives their curves back "
                "from the bent file; or bend the original"
            )
    for bends in filter(None, (named_bends(sheet.primitives.targets) for sheet in lost)):
        file.refuse(
            f"{len(bends)} of its morph targets have names of bends, such as "
            f"{shortened(bends[0])!r}, and no curves: if another program has dropped the curves, "
            "'elastomorph bend FILE --from BENT' gives them back from the bent file; if these are "
            f"shapes of their own, rename them, such as to {shortened(_renamed(bends[0]))!r}, and "
            "bend again"
        )


def _is_bent(mesh: ReadMesh) -> bool:
    return any(morph.bends or morph.fold is not None for morph in mesh.stored.morphs)


def _require_straight(file: GltfFile, meshes: Sequence[ReadMesh]) -> None:
    if any(map(_is_bent, meshes)):
        file.refuse(
            "its paths are bent already, and not by 'elastomorph bend', or its original is lost; "
            "bend the character it was made from, or export that with --method linear"
        )


def _bends_unknown(sheet: Sheet) -> bool:
    """Whether a mesh that no longer is as described has more targets than morphs: its bends.

    With no more targets than that, somebody has taken the bends out.
    """
    morphs = sheet.said.get("morphs")
    entries = [object_of(entry) for entry in morphs] if isinstance(morphs, list) else []
    bent = any(entry.get("bends") for entry in entries)
    return bent and len(sheet.primitives.targets) > len(entries)


def _renamed(bend: str) -> str:
    """A name that is not one of a bend."""
    return "_bend".join(bend.rsplit(".bend", 1))


def _face_mesh(file: GltfFile, own: ReadMesh, sheet: Sheet, start: int) -> FaceMesh:
    placed, primitives = sheet.placed, sheet.primitives
    if not isinstance(file.item("meshes", placed.number, "a node").get("extras", {}), dict):
        of = f"mesh {placed.number}"
        file.refuse(f"'extras' of {of} are no object, so bend curves cannot be kept in them")
    morphs = own.stored.morphs
    names = tuple(primitives.targets)
    bends = {
        target: float(np.linalg.norm(own.part.morphs[morph.name].bends[k], axis=1).max())
        for morph in morphs
        for k, (target, _) in enumerate(morph.bends)
        if target in names
    }
    return FaceMesh(
        number=placed.number,
        names=names,
        morph_of={morph.target: morph.name for morph in morphs if morph.target in names},
        blocks=tuple(primitives.attributes),
        block_of=primitives.block_of,
        rig_vertices=start + sheet.rows.astype(np.int64),
        bends=bends,
        bent=_is_bent(own),
        stored=sheet.said,
        diameter=own.part.mesh.diameter,
    )
