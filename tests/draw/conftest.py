"""A sphere to draw, and a small evaluation."""

from scenes import evaluation, rings, sphere

__all__ = ["evaluation", "rings", "sphere"]
