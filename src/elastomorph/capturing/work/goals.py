"""What a capture makes, and how its cameras stand: known without opening any of it."""

from __future__ import annotations

from typing import Literal, get_args

__all__ = ["RIGS", "TO", "Goal", "RigOfCameras"]

Goal = Literal["cameras", "neutral", "poses"]
RigOfCameras = Literal["walking", "fixed"]
TO: tuple[str, ...] = get_args(Goal)
RIGS: tuple[str, ...] = get_args(RigOfCameras)
