"""The viewer's page with a scene in it."""

from __future__ import annotations

import base64
import hashlib
import html
import re
import zlib
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path

from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io.atomic import replacing
from elastomorph.viewer.scene import Scene

# Pages as they come with the package, and what they may do: run their own scripts, no more.

PLACE = "<!-- elastomorph scene -->"
_SCRIPT = re.compile(r"<script(?P<attributes>[^>]*)>(?P<content>.*?)</script>", re.DOTALL)
_SOCKET = re.compile(r"(ws://127\.0\.0\.1:\d{1,5})/[\w/-]*$", re.ASCII)
# Pictures and workers that the page makes itself have addresses of blob: and data:.
_WITHIN = (
    "style-src 'unsafe-inline'; img-src data: blob:; media-src data: blob:; font-src data:; "
    "worker-src blob:; frame-src blob: data:; base-uri 'none'; form-action 'none'"
)
# Browsers take this from a server only, and complain about it within a page.
_NOT_FRAMED = "frame-ancestors 'none'"


def built_page(folder: str) -> str:
    """A page as it comes with the package, with nothing in it yet.

    Args:
        folder: Of `elastomorph.viewer`: ``page`` or ``landmarks_page``.

    Raises:
        FileError: It was not built.
    """
    place = files("elastomorph.viewer") / folder / "index.html"
    try:
        return place.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise FileError(
            str(place), "the page is not here; in a source checkout build it with 'make page'"
        ) from None


def filled(page: str, content: str) -> str:
    """A built page with what it shows in its head.

    Raises:
        FileError: It has no place for it.
    """
    if page.count(PLACE) != 1:
        raise FileError(
            "index.html",
            f"a page of the viewer must have one line {PLACE}, found {page.count(PLACE)}; build it "
            "anew with 'make page'",
        )
    return page.replace(PLACE, content)


def json_block(name: str, text: str) -> str:
    """JSON as an element of a page. Without < no text in it can end the element."""
    escaped = text.replace("<", "\\u003c")
    return f'<script type="application/json" id="{name}">{escaped}</script>'


def alone_head(page: str) -> str:
    """What tells browsers the policy of a page that is one file."""
    return (
        f'<meta http-equiv="Content-Security-Policy" content="{html.escape(alone_policy(page))}" />'
    )


def require_web_page(path: str | Path) -> None:
    """Refuse a file that browsers would not open as a page."""
    if Path(path).suffix.lower() not in (".html", ".htm"):
        raise FormatError(path, "this is a web page; name it with the suffix .html")


def alone_policy(page: str) -> str:
    """The policy of a page that is one file: its own scripts run, and nothing is fetched."""
    return f"{_own_scripts(page)}; {_WITHIN}; connect-src data: blob:"


def served_policy(page: str, sockets: Iterable[str] = ()) -> str:
    """The policy of a page beside its models: these are fetched too, from where it came from.

    Raises:
        ParameterError: An address is not that of a WebSocket of this machine.
    """
    origins = [_socket_origin(address) for address in sockets]
    connect = " ".join(["connect-src 'self' data: blob:", *origins])
    return f"{_own_scripts(page)}; {_WITHIN}; {connect}; {_NOT_FRAMED}"


def _socket_origin(address: str) -> str:
    found = _SOCKET.match(address)
    if found is None:
        raise ParameterError(f"{address!r} is no address such as ws://127.0.0.1:8000/secret/")
    return found[1]


def report_policy() -> str:
    """The policy of a finished page: whatever is within it may run, and nothing is fetched."""
    scripts = "script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:"
    return f"default-src 'none'; {scripts}; {_WITHIN}; connect-src data: blob:; {_NOT_FRAMED}"


def _own_scripts(page: str) -> str:
    """Scripts of a page by their hashes: none that got into it by other ways would run.

    Where one of them names WebAssembly, its decoders may be compiled too, and no text as a script.
    """
    digests = [
        base64.b64encode(hashlib.sha256(found["content"].encode()).digest()).decode("ascii")
        for found in _SCRIPT.finditer(page)
        if 'type="' not in found["attributes"] or 'type="module"' in found["attributes"]
    ]
    allowed = [f"'sha256-{digest}'" for digest in digests] or ["'none'"]
    if any("WebAssembly" in found["content"] for found in _SCRIPT.finditer(page)):
        allowed.append("'wasm-unsafe-eval'")
    return f"default-src 'none'; script-src {' '.join(allowed)}"


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
