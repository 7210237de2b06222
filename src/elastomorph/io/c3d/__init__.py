"""C3D: markers as systems of motion capture record them.

Reading needs ezc3d (``pip install 'elastomorph[mocap]'``) and happens in a process of its own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from elastomorph._lazy import lazy_names

if TYPE_CHECKING:
    from elastomorph.io.c3d.reader import read_c3d

__all__ = ["read_c3d"]

__getattr__ = lazy_names(__name__, {"reader": ("read_c3d",)})
