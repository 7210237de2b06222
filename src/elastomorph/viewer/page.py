"""The viewer's page with a scene in it."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from elastomorph.io.atomic import replacing
from elastomorph.viewer.scene import Scene
from elastomorph.viewer.shipped import (
    alone_head,
    built_page,
    filled,
    json_block,
    require_web_page,
)


def viewer_page(scene: Scene) -> str:
    """The page that shows a scene, with everything in it; browsers keep it from the network."""
    names = [f"elastomorph-glb-{number}" for number in range(len(scene.models))]
    page = shipped_page()
    blocks = [alone_head(page), _scene_block(scene, [f"#{name}" for name in names])]
    for name, model in zip(names, scene.models, strict=True):
        text = base64.b64encode(zlib.compress(model.glb, 9)).decode("ascii")
        blocks.append(f'<script type="application/zlib" id="{name}">{text}</script>')
    return filled(page, "\n".join(blocks))


def page_beside(scene: Scene, addresses: Sequence[str], services: Mapping[str, str]) -> str:
    """The page that fetches the models of a scene from addresses relative to its own.

    Services are what it may ask of the command that shows it, by name, each with its address.
    """
    return filled(shipped_page(), _scene_block(scene, addresses, services))


def write_viewer(path: str | Path, scene: Scene) -> None:
    """Write the page that shows a scene, the whole of it or nothing.

    Args:
        path: The file, ``.html``; its folder must exist.
        scene: What to show.

    Raises:
        FormatError: The suffix is another.
        FileError: The file cannot be written, or the page was not built.
    """
    require_web_page(path)
    content = viewer_page(scene).encode()
    with replacing(path) as file:
        file.write(content)


def shipped_page() -> str:
    """The page as it comes with the package, without a scene."""
    return built_page("page")


def _scene_block(
    scene: Scene, addresses: Sequence[str], services: Mapping[str, str] | None = None
) -> str:
    return json_block("elastomorph-scene", scene.to_json(addresses, services))
