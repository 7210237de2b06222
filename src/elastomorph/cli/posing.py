"""What ``--pose`` asks for: weights by name, a pose of a file, or all poses of a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING

from elastomorph.cli.options import named_numbers
from elastomorph.cli.takes import named_part
from elastomorph.errors import ParameterError, warn

if TYPE_CHECKING:
    from elastomorph.rig import Rig

_SHOWN = 8


@dataclass(frozen=True)
class PoseWords:
    """Poses as the command line names them, their files read.

    Attributes:
        weights: Those given by name; they come on top.
        poses: Those of files: by their words, or by their names of a whole file.
        file: Where all of them come from, if a whole file was named.
    """

    weights: dict[str, float]
    poses: dict[str, dict[str, float]]
    file: str | None = None

    @classmethod
    def of(cls, texts: Sequence[str]) -> PoseWords:
        """Read ``smile=0.7,jawOpen=0.4``, ``poses.json#Smile`` and ``poses.json``."""
        from elastomorph.io.poses import POSE_SUFFIXES, read_poses

        inline: list[str] = []
        poses: dict[str, dict[str, float]] = {}
        for text in texts:
            file, name = named_part(text.strip())
            if not file.lower().endswith(POSE_SUFFIXES):
                inline += [part.strip() for part in text.split(",")]
                continue
            found = read_poses(file)
            if name is None:
                if len(texts) > 1:
                    raise ParameterError(
                        f"{file} is a sheet of all its poses: name one, as in "
                        f"{file}#{next(iter(found))}, or leave the other --pose out"
                    )
                return cls({}, found, file)
            _require(name, found, file)
            poses[text] = found[name]
        return cls(named_numbers(inline, "--pose"), poses)

    @property
    def sheet(self) -> bool:
        """Whether they are all poses of a file."""
        return self.file is not None

    def __bool__(self) -> bool:
        return bool(self.weights or self.poses)

    def on(self, rig: Rig) -> dict[str, dict[str, float]]:
        """The weights of the rig's sliders in each pose; in one without a name, if not a sheet."""
        from elastomorph.rig.performance import fitted_poses, unknown_sliders

        if self and not rig.names:
            raise ParameterError("this is a mesh without sliders, so there is nothing to --pose")
        fitted, unknown = fitted_poses(self.poses, rig.names)
        if unknown:
            sentence = unknown_sliders(unknown, rig.names)
            if not any(fitted.values()):
                raise ParameterError(f"{sentence}: these poses are for another rig")
            warn(f"{sentence}: left out")
        if self.sheet:
            return fitted
        together: dict[str, float] = {}
        for weights in (*fitted.values(), self.weights):
            together |= weights
        rig.sliders.row(together)
        return {"": together}


def _require(name: str, poses: dict[str, dict[str, float]], file: str) -> None:
    if name in poses:
        return
    near = get_close_matches(name, poses, n=1, cutoff=0.5)
    shown = ", ".join(list(poses)[:_SHOWN]) + (", …" if len(poses) > _SHOWN else "")
    hint = f"did you mean {near[0]!r}?" if near else f"there are {shown}"
    raise ParameterError(f"{file} has no pose {name!r}: {hint}")
