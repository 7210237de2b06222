"""FBX: meshes with blend shapes, as Maya, 3ds Max, MotionBuilder and Blender write them.

Reading needs ufbx (``pip install 'elastomorph[fbx]'``) and happens in a process of its own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from elastomorph._lazy import lazy_names

if TYPE_CHECKING:
    from elastomorph.io.fbx.reader import read_fbx

__all__ = ["read_fbx"]

__getattr__ = lazy_names(__name__, {"reader": ("read_fbx",)})
