"""Shapes that meet: what goes wrong where several sliders act at once, and what mends it."""
