"""Which photographs are from the same camera of a rig: those of one name or number in each pose."""

from __future__ import annotations

import re
from collections.abc import Mapping

from elastomorph.capturing.photographs.photographs import Photograph, Photographs
from elastomorph.errors import CaptureError

LARGEST_SHARE = 0.5
"""Of the photographs of a pose: as many have to be from cameras that took the neutral."""


def same_cameras(poses: Mapping[str, Photographs], neutral: str) -> dict[str, dict[str, str]]:
    """Which photograph of the neutral is from the same camera: pose → photograph → that one's name.

    Args:
        poses: Photographs by pose.
        neutral: Name of the neutral.

    Raises:
        CaptureError: Photographs of a pose are not named or numbered as those of the neutral.
    """
    found = {}
    for key in (_stem, _number):
        named = {key(photograph): photograph.name for photograph in poses[neutral].taken}
        found = {
            pose: {
                photograph.name: named[key(photograph)]
                for photograph in photographs.taken
                if key(photograph) in named
            }
            for pose, photographs in poses.items()
        }
        if len(named) == len(poses[neutral].taken) and all(
            len(set(same.values())) == len(same) >= LARGEST_SHARE * len(poses[pose].taken)
            for pose, same in found.items()
        ):
            return found
    for pose, photographs in poses.items():
        if len(found[pose]) < LARGEST_SHARE * len(photographs.taken):
            raise CaptureError(
                f"pose '{pose}': its photographs are not named or numbered as those of "
                f"'{neutral}' ({photographs.taken[0].name}, {poses[neutral].taken[0].name}), so "
                "which camera took which is not known; name them alike, or leave out --rig fixed"
            )
    raise CaptureError("photographs of one pose have the same number; give each camera its own")


def _stem(photograph: Photograph) -> str:
    return photograph.path.stem.lower()


def _number(photograph: Photograph) -> str:
    numbers = re.findall(r"\d+", photograph.path.stem)
    return numbers[-1].lstrip("0") if numbers else photograph.path.stem.lower()
