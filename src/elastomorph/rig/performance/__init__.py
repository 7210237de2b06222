"""Performances: recorded weights over time, matched to the sliders of a rig and played on it."""

from elastomorph.rig.naming import is_rotation
from elastomorph.rig.performance.matching import Drive, Match, match
from elastomorph.rig.performance.performance import (
    HEAD_ANGLES,
    HeadTurn,
    Performance,
    angles_of,
    head_angles,
    head_quaternions,
    head_rotations,
    play,
    slider_weights,
)
from elastomorph.rig.performance.poses import fitted_poses, through_poses, unknown_sliders

__all__ = [
    "HEAD_ANGLES",
    "Drive",
    "HeadTurn",
    "Match",
    "Performance",
    "angles_of",
    "fitted_poses",
    "head_angles",
    "head_quaternions",
    "head_rotations",
    "is_rotation",
    "match",
    "play",
    "slider_weights",
    "through_poses",
    "unknown_sliders",
]
