"""Serves a rig to a browser as the command line does, with all that the page may ask for."""

from __future__ import annotations

from pathlib import Path

import elastomorph as em
from elastomorph.cli.view import _scene, _services
from elastomorph.viewer import ViewerServer, serve
from elastomorph.viewer.listening import Offer
from small_head import head, shapes

NAMES = ("eyeBlink_L", "jawOpen", "mouthSmile_L")


def write_folder(folder: Path) -> Path:
    """The small head with three of its expressions, as meshes."""
    folder.mkdir()
    em.write(folder / "neutral.obj", head())
    for name in NAMES:
        em.write(folder / f"{name}.obj", shapes()[name])
    return folder


def serving(file: Path) -> ViewerServer:
    shelf: dict[str, Offer] = {}
    scene = _scene([str(file)], [], "cm", None, None, lambda _: None)
    services = _services([str(file)], [], "cm", None, None, shelf)
    return serve(scene, 0, services, shelf)
