"""Rigs that hold together where several of their shapes meet."""

from elastomorph.holding.correction import Correction
from elastomorph.holding.hold import Held, hold

__all__ = ["Correction", "Held", "hold"]
