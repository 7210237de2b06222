"""The names of the head's polygon groups, and which cell of the layout belongs to which."""

from __future__ import annotations

from collections.abc import Callable

__all__ = [
    "BROWS",
    "EYES",
    "GUMS",
    "IRISES",
    "LASHES",
    "LIDS",
    "LIPS",
    "MOUTH",
    "NOSTRILS",
    "PUPILS",
    "SKIN",
    "TEETH",
    "TONGUE",
    "RingGroups",
    "ear_ring",
    "eye_ring",
    "mouth_ring",
    "nostril_ring",
]

SKIN = "skin"
BROWS = "brows"
LIDS = "lids"
LASHES = "lashes"
LIPS = "lips"
MOUTH = "mouth"
NOSTRILS = "nostrils"
TEETH = "teeth"
GUMS = "gums"
TONGUE = "tongue"
EYES = {"L": "eye_L", "R": "eye_R"}
IRISES = {"L": "iris_L", "R": "iris_R"}
PUPILS = {"L": "pupil_L", "R": "pupil_R"}

RingGroups = Callable[[int, int], str]


def eye_ring(ring: int, place: int) -> str:
    """Group of a cell between two rings around the eye; place starts at the inner upper corner."""
    if ring == 1 and place < 9:
        return BROWS
    if ring == 6:
        return LASHES
    return LIDS if ring > 6 else SKIN


def nostril_ring(ring: int, place: int) -> str:
    """Group of a cell between two rings of a nostril."""
    return SKIN if ring < 1 else NOSTRILS


def ear_ring(ring: int, place: int) -> str:
    """Group of a cell between two rings of an ear."""
    return SKIN


def mouth_ring(ring: int, place: int) -> str:
    """Group of a cell between two rings around the mouth."""
    return SKIN if ring < 4 else LIPS if ring < 10 else MOUTH
