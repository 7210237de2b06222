"""The photographs of a pose, as what was found out of each before any work."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

FEWEST = 6  # photographs of a pose; fewer leave most of a face seen by less than three cameras


@dataclass(frozen=True)
class Photograph:
    """A photograph as its header describes it.

    Attributes:
        path: The file.
        size: Width and height in pixels, upright.
        focal: Focal length in pixels by EXIF, or None.
        doubt: Why a focal length that EXIF gives is not used, or empty.
        lens: What took it: camera, focal length in mm and size; photographs with the same share
            one set of lens parameters.
        digest: Hash of the content.
        mask: File of its mask, or None.
        sharpness: Of `sharpness`, at the size that is looked at; 0 where it was not.
    """

    path: Path
    size: tuple[int, int]
    focal: float | None
    doubt: str
    lens: str
    digest: str
    mask: Path | None = None
    sharpness: float = 0.0

    @property
    def name(self) -> str:
        """File name without its folder."""
        return self.path.name


@dataclass(frozen=True)
class Photographs:
    """The photographs of one pose that are of use.

    Attributes:
        pose: Name of the pose.
        taken: Those to work with, in the order of their names.
        rejected: File name of each other one, and why.
        remarks: Sentences about what is unusual without being an error.
    """

    pose: str
    taken: tuple[Photograph, ...]
    rejected: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
