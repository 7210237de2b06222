"""The face that the paper's experiments run on: the built-in head, or a rig in a folder."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.bending.character import BENDABLE
from elastomorph.draw.head import head_of
from elastomorph.errors import FormatError
from elastomorph.evaluation.rigid_bodies import RigidParts, find_rigid_parts
from elastomorph.model.geometry import least_motion
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.rig import Rig
from elastomorph.rig.naming import shape_of
from elastomorph.samples.paper_expressions import EXPRESSIONS, compose_expressions


@dataclass(frozen=True, eq=False)
class Subject:
    """A face and what is known of its motion.

    Attributes:
        name: For titles.
        neutral: The face at rest.
        targets: Single shapes by name.
        expressions: The paper's five, or what the rig has of them.
        jaw: Name of the target that opens the jaw, or of the one that moves most of the face.
        take: A recorded mesh sequence, where there is one.
        rigid_parts: Parts that turn rigidly with the jaw: the only ground truth a rig holds.
        unit: Unit of the coordinates, or an empty string where nobody knows it.
        command: What writes the face with bent paths.
        head: (N,) vertices of the head of a character with a body; None where that is all.
        paths: Those of ``auto`` to targets and expressions, where they are made already.
    """

    name: str
    neutral: Mesh
    targets: dict[str, Mesh]
    expressions: dict[str, Mesh]
    jaw: str
    take: MeshSequence | None = None
    rigid_parts: RigidParts | None = field(default=None)
    unit: str = ""
    command: str = ""
    head: NDArray[np.int64] | None = None
    paths: Mapping[str, Morph] = field(default_factory=dict)


def built_in_subject() -> Subject:
    """The built-in head with its shapes, its expressions and its recorded motion."""
    from elastomorph.samples import built_in_rig, expressions, head, recorded_motion, shapes

    neutral, targets = head(), shapes()
    return Subject(
        "built-in head",
        neutral,
        targets,
        expressions(),
        "jawOpen",
        recorded_motion(),
        find_rigid_parts(neutral, targets["jawOpen"]),
        unit="cm",
        command=_command("built-in"),
        paths=built_in_rig().morphs,
    )


def rig_subject(place: str | Path, rig: Rig) -> Subject:
    """A rig that was read from a file or a folder.

    Raises:
        FormatError: It has no targets.
    """
    place = Path(place)
    if not rig.names:
        raise FormatError(place, "there are no targets in it; name a rig with shapes to judge")
    neutral = rig.neutral
    targets = rig.targets
    jaw = _jaw(neutral, targets)
    return Subject(
        place.stem if place.is_file() else place.name or place.resolve().name,
        neutral,
        targets,
        compose_expressions(neutral, targets) or dict(list(targets.items())[: len(EXPRESSIONS)]),
        jaw,
        rigid_parts=find_rigid_parts(neutral, targets[jaw]),
        command=_command(str(place)),
        head=head_of(neutral, rig.morphs.values()),
    )


def _command(source: str) -> str:
    """A file that may hold more than a face keeps it; of others the rig is written anew."""
    stem, suffix = Path(source).stem, Path(source).suffix.lower()
    if suffix in BENDABLE:
        return f"elastomorph bend {shlex.quote(source)} -o {shlex.quote(f'{stem}.bent{suffix}')}"
    return f"elastomorph export {shlex.quote(source)} -o bent.glb"


def _jaw(neutral: Mesh, targets: dict[str, Mesh]) -> str:
    """The target called so, unless it is empty, as avatars have some; else the widest one."""
    least = least_motion(neutral.vertices, (each.vertices for each in targets.values()))

    def widely(name: str) -> int:
        away = np.linalg.norm(targets[name].vertices - neutral.vertices, axis=1)
        return int(np.count_nonzero(away > least))

    called = next((name for name in targets if shape_of(name) == "jawOpen"), None)
    return called if called is not None and widely(called) else max(targets, key=widely)
