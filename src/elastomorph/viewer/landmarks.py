"""The page where landmarks are placed: served until somebody has finished, or written as a file."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

from elastomorph.capturing.landmarks.landmarks import parse_landmarks, write_landmarks
from elastomorph.errors import ParameterError
from elastomorph.io.atomic import read_bytes, replacing, size_of
from elastomorph.viewer.answers import HTML, Answer, Offer, Receiver, Resource, Sent, text
from elastomorph.viewer.landmark_task import LandmarkPlace, LandmarkTask, PackedSurface
from elastomorph.viewer.server import ViewerServer
from elastomorph.viewer.shipped import (
    alone_head,
    built_page,
    filled,
    json_block,
    require_web_page,
    served_policy,
)

_PAGE = "landmarks_page"
_FINISHED = "finish"
_MOST_IN_A_PAGE = 350_000_000  # bytes; as text they are a third more
_ADDRESS = "landmarks.json"
_KINDS = {".png": "image/png"}
_NOT_SHOWN = (".tif", ".tiff")


def serve_landmarks(task: LandmarkTask, file: str | Path, port: int = 0) -> ViewerServer:
    """A server that shows the page and writes what is placed; enter it with ``with``.

    The file is written again after every change, whole. Its `wait` ends when somebody has pressed
    the button that says so.

    Args:
        task: What points are placed on.
        file: The file of landmarks.
        port: Port of 127.0.0.1; a free one for 0.

    Raises:
        ParameterError: The port is taken or not allowed.
        FileError: The page was not built.
    """
    resources: dict[str, Offer] = {}
    sources: list[str] = []
    images: list[list[str]] = []
    for number, place in enumerate(task.places):
        kind, loads, own = _parts(place)
        sources.append(f"place-{number}")
        images.append([f"place-{number}-{image}" for image in range(len(own))])
        resources[sources[-1]] = Resource(kind, loads)
        for address, image in zip(images[-1], own, strict=True):
            resources[address] = Resource(_image_kind(image), image)
    saving = {"save": _ADDRESS, "file": Path(file).name}
    page = filled(built_page(_PAGE), _block(task, sources, images, saving))
    resources[""] = Resource(HTML, page.encode(), served_policy(page))

    def receive(sent: Sent) -> Answer:
        placed = parse_landmarks(file, sent.read())
        # Those are not placed in the page, and stay what they were.
        write_landmarks(file, replace(placed, distances=task.known.distances))
        return Answer(text("saved"), finished=sent.words == _FINISHED)

    resources[_ADDRESS] = Receiver(receive)
    return ViewerServer(resources, port)


def write_landmark_page(path: str | Path, task: LandmarkTask, file: str = _ADDRESS) -> None:
    """Write the page with all photographs and surfaces in it; what is placed is downloaded.

    Args:
        path: The page, ``.html``; its folder must exist.
        task: What points are placed on.
        file: What the download is called.

    Raises:
        FormatError: The suffix is another.
        ParameterError: The photographs are more than browsers open in a page.
        FileError: The page cannot be written, or was not built.
    """
    require_web_page(path)
    total = sum(size_of(each.content) for each in task.places if isinstance(each.content, Path))
    if total > _MOST_IN_A_PAGE:
        raise ParameterError(
            f"{path}: a page with all {total / 1e6:,.0f} MB of photographs is more than browsers "
            f"open; name fewer, {_MOST_IN_A_PAGE / 1e6:,.0f} MB at most, or have it served"
        )
    sources = [f"#place-{number}" for number in range(len(task.places))]
    parts = [_parts(place) for place in task.places]
    images = [
        [f"{source}-{image}" for image in range(len(own))]
        for source, (_, _, own) in zip(sources, parts, strict=True)
    ]
    page = built_page(_PAGE)
    block = _block(task, sources, images, {"save": None, "file": file})
    before, _, after = filled(page, f"{alone_head(page)}\n{block}").partition("</head>")
    with replacing(path) as unfinished:
        unfinished.write(before.encode())
        # One after another: all photographs together may be more than there is memory.
        for source, addresses, (_, loads, own) in zip(sources, images, parts, strict=True):
            content = loads if isinstance(loads, bytes) else loads()
            for address, each in [(source, content), *zip(addresses, own, strict=True)]:
                text = base64.b64encode(each)
                opening = f'<script type="application/octet-stream" id="{address[1:]}">'
                unfinished.write(opening.encode() + text + b"</script>\n")
        unfinished.write(f"</head>{after}".encode())


def _parts(place: LandmarkPlace) -> tuple[str, Any, tuple[bytes, ...]]:
    """Kind of a place, its content or what loads it, and the images that belong to it."""
    if isinstance(place.content, PackedSurface):
        return "application/octet-stream", place.content.content, place.content.images
    suffix = place.content.suffix.lower()
    loads = _as_jpeg if suffix in _NOT_SHOWN else read_bytes
    return _KINDS.get(suffix, "image/jpeg"), partial(loads, place.content), ()


def _as_jpeg(photograph: Path) -> bytes:
    """A photograph in a format that browsers do not show, pixel for pixel."""
    from PIL import Image

    from elastomorph.capturing.photographs.pixels import read_upright

    content = BytesIO()
    Image.fromarray(read_upright(photograph)).save(content, "JPEG", quality=95, subsampling=0)
    return content.getvalue()


def _image_kind(content: bytes) -> str:
    return "image/png" if content.startswith(b"\x89PNG") else "image/jpeg"


def _block(
    task: LandmarkTask,
    sources: Sequence[str],
    images: Sequence[Sequence[str]],
    saving: Mapping[str, str | None],
) -> str:
    document = {**task.document(sources, images), **saving}
    return json_block("elastomorph-landmarks", json.dumps(document, allow_nan=False))
