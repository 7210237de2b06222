"""Performances: recorded weights over time, matched to the sliders of a rig and played on it."""

from elastomorph.performance.matching import Drive, Match, match
from elastomorph.performance.performance import Performance
from elastomorph.performance.play import play, slider_weights

__all__ = ["Drive", "Match", "Performance", "match", "play", "slider_weights"]
