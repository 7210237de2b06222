"""The built-in head, its expressions and its recorded motion."""

from elastomorph.samples.built_in_head import (
    built_in_rig,
    expressions,
    head,
    landmarks,
    recorded_motion,
    shapes,
)

__all__ = ["built_in_rig", "expressions", "head", "landmarks", "recorded_motion", "shapes"]
