"""Performances: recorded weights over time, matched to the sliders of a rig and played on it."""

from elastomorph.rig.performance.matching import Drive, Match, match
from elastomorph.rig.performance.performance import Performance, play, slider_weights

__all__ = ["Drive", "Match", "Performance", "match", "play", "slider_weights"]
