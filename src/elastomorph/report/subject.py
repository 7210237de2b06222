"""The face that the paper's experiments run on: the built-in head, or a rig in a folder."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from elastomorph.errors import FileError
from elastomorph.evaluation.rigid_parts import RigidParts, find_rigid_parts
from elastomorph.io import read
from elastomorph.mesh import Mesh, require_same_topology
from elastomorph.paper_expressions import EXPRESSIONS, compose_expressions
from elastomorph.sequence import MeshSequence

__all__ = ["Subject", "built_in_subject", "rig_subject"]


@dataclass(frozen=True, eq=False)
class Subject:
    """A face and what is known of its motion.

    Attributes:
        name: For titles.
        neutral: The face at rest.
        targets: Single shapes by name.
        expressions: The paper's five, or what the rig has of them.
        jaw: Name of the target that opens the jaw, or of the one that moves most.
        motion: A recorded motion, where there is one.
        rigid_parts: Parts that turn rigidly with the jaw: the only ground truth a rig holds.
    """

    name: str
    neutral: Mesh
    targets: dict[str, Mesh]
    expressions: dict[str, Mesh]
    jaw: str
    motion: MeshSequence | None = None
    rigid_parts: RigidParts | None = field(default=None)


def built_in_subject() -> Subject:
    """The built-in head with its shapes, its expressions and its recorded motion."""
    from elastomorph.samples import expressions, head, recorded_motion, shapes

    return Subject("built-in head", head(), shapes(), expressions(), "jawOpen", recorded_motion())


def rig_subject(folder: str | Path, say: Callable[[str], None] = lambda _: None) -> Subject:
    """A rig from a folder of mesh files, one of them named like a neutral.

    Args:
        folder: The folder, or one that holds it as ``ict-facekit``.
        say: Told which file is being read.

    Raises:
        FileError: No folder, no neutral, or no targets.
        TopologyError: A target has other vertices or polygons than the neutral.
    """
    place = Path(folder)
    if (place / "ict-facekit").is_dir():
        place = place / "ict-facekit"
    if not place.is_dir():
        raise FileError(folder, "there is no such folder; name one with a neutral and its targets")
    files = sorted(f for f in place.iterdir() if f.suffix.lower() in (".obj", ".ply"))
    neutrals = [f for f in files if "neutral" in f.stem.lower()]
    if len(neutrals) != 1 or len(files) < 2:
        found = ", ".join(f.name for f in neutrals) or "none"
        raise FileError(
            place,
            "expected mesh files (.obj, .ply), exactly one of them with 'neutral' in its name; "
            f"{len(files)} mesh files, neutrals: {found}",
        )
    neutral = read(neutrals[0])
    targets: dict[str, Mesh] = {}
    for file in files:
        if file != neutrals[0]:
            say(f"reading {file.name}")
            mesh = read(file)
            require_same_topology(neutral, mesh)
            targets[file.stem] = neutral.with_vertices(mesh.vertices)
    jaw = "jawOpen" if "jawOpen" in targets else _farthest(neutral, targets)
    return Subject(
        place.name,
        neutral,
        targets,
        compose_expressions(neutral, targets) or dict(list(targets.items())[: len(EXPRESSIONS)]),
        jaw,
        rigid_parts=find_rigid_parts(neutral, targets[jaw]),
    )


def _farthest(neutral: Mesh, targets: dict[str, Mesh]) -> str:
    return max(targets, key=lambda name: abs(targets[name].vertices - neutral.vertices).max())
