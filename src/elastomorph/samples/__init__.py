"""The built-in head, its expressions and its recorded motion."""

from elastomorph.samples.built_in_head import expressions, head, recorded_motion, shapes

__all__ = ["expressions", "head", "recorded_motion", "shapes"]
