"""The viewer: faces, their paths and what differs between them, in a browser.

A `Scene` is what there is to see; `viewer_page` makes it one file that asks the network for
nothing, and `serve` shows it on this machine only.
"""

from __future__ import annotations

from elastomorph.viewer.page import viewer_page, write_viewer
from elastomorph.viewer.rig_scenes import (
    comparison_scene,
    evaluation_scene,
    motion_morph,
    rig_scene,
)
from elastomorph.viewer.scene import Scene, SceneModel
from elastomorph.viewer.server import ViewerServer, serve

__all__ = [
    "Scene",
    "SceneModel",
    "ViewerServer",
    "comparison_scene",
    "evaluation_scene",
    "motion_morph",
    "rig_scene",
    "serve",
    "viewer_page",
    "write_viewer",
]
