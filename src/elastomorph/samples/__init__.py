"""The built-in head, its expressions and its recorded motion."""

from elastomorph.samples.assembly import head
from elastomorph.samples.motion import recorded_motion
from elastomorph.samples.shapes import expressions, shapes

__all__ = ["expressions", "head", "recorded_motion", "shapes"]
