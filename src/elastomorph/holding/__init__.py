"""Rigs that hold together where several of their shapes meet."""

from elastomorph.holding.correction import Correction
from elastomorph.holding.held import Held, hold

__all__ = ["Correction", "Held", "hold"]
