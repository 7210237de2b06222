"""A rig: named morphs on one neutral, posed one face at a time or by the million."""

from elastomorph.rig import timing
from elastomorph.rig.rig import Rig

__all__ = ["Rig", "timing"]
