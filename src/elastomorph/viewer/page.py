"""The viewer's page with a scene in it, and what a page may do: run its own scripts, no more."""

from __future__ import annotations

import base64
import hashlib
import html
import re
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import replacing
from elastomorph.viewer.scene import Scene

PLACE = "<!-- elastomorph scene -->"
_SCRIPT = re.compile(r"<script(?P<attributes>[^>]*)>(?P<content>.*?)</script>", re.DOTALL)
# Pictures and workers that the page makes itself have addresses of blob: and data:.
_WITHIN = (
    "style-src 'unsafe-inline'; img-src data: blob:; media-src data: blob:; font-src data:; "
    "worker-src blob:; frame-src blob: data:; base-uri 'none'; form-action 'none'"
)
# Browsers take this from a server only, and complain about it within a page.
_NOT_FRAMED = "frame-ancestors 'none'"


def viewer_page(scene: Scene) -> str:
    """The page that shows a scene, with everything in it; browsers keep it from the network."""
    names = [f"elastomorph-glb-{number}" for number in range(len(scene.models))]
    policy = html.escape(alone_policy(shipped_page()))
    blocks = [f'<meta http-equiv="Content-Security-Policy" content="{policy}" />']
    blocks += [_scene_block(scene, [f"#{name}" for name in names])]
    for name, model in zip(names, scene.models, strict=True):
        text = base64.b64encode(model.glb).decode("ascii")
        blocks.append(f'<script type="application/octet-stream" id="{name}">{text}</script>')
    return _filled("\n".join(blocks))


def page_beside(scene: Scene, addresses: Sequence[str]) -> str:
    """The page that fetches the models of a scene from addresses relative to its own."""
    return _filled(_scene_block(scene, addresses))


def write_viewer(path: str | Path, scene: Scene) -> None:
    """Write the page that shows a scene, the whole of it or nothing.

    Args:
        path: The file, ``.html``; its folder must exist.
        scene: What to show.

    Raises:
        FormatError: The suffix is another.
        FileError: The file cannot be written, or the page was not built.
    """
    if Path(path).suffix.lower() not in (".html", ".htm"):
        raise FormatError(path, "a viewer is a web page; name it with the suffix .html")
    content = viewer_page(scene).encode()
    with replacing(path) as file:
        file.write(content)


def shipped_page() -> str:
    """The page as it comes with the package, without a scene."""
    place = files("elastomorph.viewer") / "page" / "index.html"
    try:
        return place.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise FileError(
            str(place),
            "the viewer's page is not here; in a source checkout build it with "
            "'npm ci --prefix web' and 'npm run build --prefix web'",
        ) from None


def _scene_block(scene: Scene, addresses: Sequence[str]) -> str:
    # Without < no text of a scene can end the element it stands in.
    text = scene.to_json(addresses).replace("<", "\\u003c")
    return f'<script type="application/json" id="elastomorph-scene">{text}</script>'


def _filled(content: str) -> str:
    page = shipped_page()
    if page.count(PLACE) != 1:
        raise FileError(
            "viewer/page/index.html",
            f"the viewer's page must have one line {PLACE}, found {page.count(PLACE)}; build it "
            "anew with 'npm run build --prefix web'",
        )
    return page.replace(PLACE, content)


def alone_policy(page: str) -> str:
    """The policy of a page that is one file: its own scripts run, and nothing is fetched."""
    return f"{_own_scripts(page)}; {_WITHIN}; connect-src data: blob:"


def served_policy(page: str) -> str:
    """The policy of a page beside its models: these are fetched too, from where it came from."""
    return f"{_own_scripts(page)}; {_WITHIN}; connect-src 'self' data: blob:; {_NOT_FRAMED}"


def report_policy() -> str:
    """The policy of a finished page: whatever is within it may run, and nothing is fetched."""
    scripts = "script-src 'unsafe-inline' blob:"
    return f"default-src 'none'; {scripts}; {_WITHIN}; connect-src data: blob:; {_NOT_FRAMED}"


def _own_scripts(page: str) -> str:
    """Scripts of a page by their hashes: none that got into it by other ways would run."""
    digests = [
        base64.b64encode(hashlib.sha256(found["content"].encode()).digest()).decode("ascii")
        for found in _SCRIPT.finditer(page)
        if 'type="' not in found["attributes"] or 'type="module"' in found["attributes"]
    ]
    allowed = [f"'sha256-{digest}'" for digest in digests] or ["'none'"]
    return f"default-src 'none'; script-src {' '.join(allowed)}"
