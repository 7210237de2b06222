"""The spellings of ARKit's shapes, for the tests."""

from __future__ import annotations

STYLES = ("arkit", "livelink", "sided", "lower")
DIRECTIONS = {"jawLeft", "jawRight", "mouthLeft", "mouthRight"}


def spelled(shape: str, style: str) -> str:
    """A shape as ARKit or Live Link Face has it, with its side as a letter, or in small letters."""
    if style == "livelink":
        return shape[0].upper() + shape[1:]
    if style == "sided" and shape not in DIRECTIONS:
        for side in ("Left", "Right"):
            if shape.endswith(side):
                return f"{shape.removesuffix(side)}_{side[0]}"
    return shape.lower() if style == "lower" else shape
