"""Performances: recorded weights over time, matched to the sliders of a rig and played on it."""

from elastomorph.rig.performance.matching import Drive, Match, match
from elastomorph.rig.performance.performance import Performance, play, slider_weights
from elastomorph.rig.performance.poses import fitted_poses, through_poses, unknown_sliders

__all__ = [
    "Drive",
    "Match",
    "Performance",
    "fitted_poses",
    "match",
    "play",
    "slider_weights",
    "through_poses",
    "unknown_sliders",
]
