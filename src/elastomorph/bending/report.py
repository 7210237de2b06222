"""What bending a character did, or would do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class BentTarget:
    """A target that bends.

    Attributes:
        name: Its name.
        gain: The largest distance between its path and the straight line, fraction of D.
        error: How far what is stored may be from the path, fraction of D.
        method: How the path was made, and why.
        bends: How many bends it has.
        targets: How many morph targets were added for it, in all meshes together.
        bytes: What they take in the buffers.
        folded: Whether the weight of the target itself follows a curve.
    """

    name: str
    gain: float
    error: float
    method: str
    bends: int
    targets: int
    bytes: int
    folded: bool


@dataclass(frozen=True)
class BendReport:
    """What `elastomorph.bend` did.

    Attributes:
        path: The character.
        output: What was written; None where nothing was, as where nothing bends.
        extent: D, the largest distance between two vertices that targets move, in the unit of the
            file.
        bent: The targets that bend.
        straight: Names of those that stay on their straight lines.
        left_out: Those that bend too, but for which there was no room.
        targets_before: Morph targets of the mesh that has most of them.
        targets: As many as that mesh has with bends.
        meshes: Names of the meshes that got targets.
        clips: How many animations play bent.
        added_keys: How many keys were added to them.
        bytes_before: Size of the file, with the files beside it that it is made of.
        bytes: Size of what was written, or would be.
        storage_error: How far rounding to the numbers of the file may move a vertex, fraction
            of D.
        key_error: How far a clip may be from its path between keys, fraction of D.
        was_bent: Whether the file was bent before, and has been bent anew from its original.
        matched: Where curves were given back: how many targets were known by "name", "index" and
            "shape".
        notes: What else there is to know: which expressions of a VRM override others.
    """

    path: Path
    output: Path | None
    extent: float
    bent: tuple[BentTarget, ...]
    straight: tuple[str, ...]
    left_out: tuple[BentTarget, ...]
    targets_before: int
    targets: int
    meshes: tuple[str, ...]
    clips: int
    added_keys: int
    bytes_before: int
    bytes: int
    storage_error: float
    key_error: float
    was_bent: bool
    matched: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def largest_error(self) -> float:
        """How far a vertex may be from its path, one target at a time, fraction of D.

        Of a target for which there was no room that is all that its path bends by.
        """
        held = [own.error for own in self.bent] + [own.gain for own in self.left_out]
        return max(held, default=0.0) + self.storage_error + self.key_error
