"""FBX: meshes with blend shapes, as Maya, 3ds Max, MotionBuilder and Blender write them.

Reading needs ufbx (``pip install 'elastomorph[fbx]'``) and happens in a process of its own.
"""

from elastomorph.io.fbx.reader import read_fbx

__all__ = ["read_fbx"]
