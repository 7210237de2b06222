"""Bends a character in its own file: the whole of it stays, and what bends need is added."""

from __future__ import annotations

from elastomorph.bending.character import bend, unbend
from elastomorph.bending.report import BendReport, BentTarget

__all__ = ["BendReport", "BentTarget", "bend", "unbend"]
