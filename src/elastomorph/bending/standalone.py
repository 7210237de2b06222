"""A document as one file of chunks that needs no other, and one that shows some of its meshes.

Numbers of nodes, meshes, accessors and views stay what they are, so that all that names them holds.
"""

from __future__ import annotations

import copy
from collections.abc import Collection
from typing import Any

from elastomorph.errors import ElastomorphError
from elastomorph.io.gltf.clips import POINTER
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.looks import image_kind
from elastomorph.io.gltf.meshopt import EXTENSIONS as MESHOPT

__all__ = ["showing_only", "standalone"]


def standalone(file: GltfFile) -> GltfFile:
    """A file with everything inside; itself where it is so.

    Raises:
        ElastomorphError: Bytes of its meshes are not to be had. An image that is not is left out.
    """
    entries = [own for kind in ("buffers", "images") for own in file.items(kind)]
    if file.is_glb and not any(isinstance(own, dict) and "uri" in own for own in entries):
        return file
    document, chunk = copy.deepcopy(file.document), bytearray()
    _take_buffers(file, document, chunk)
    _take_images(file, document, chunk)
    if chunk:
        document["buffers"][0]["byteLength"] = len(chunk)
    content = bytes(chunk) if chunk else None
    return GltfFile(file.path, document, content, file.size + len(chunk), file.rest or b"")


def _take_buffers(file: GltfFile, document: dict[str, Any], chunk: bytearray) -> None:
    """Put all buffers that have bytes into one; those that are announced alone follow it."""
    starts: dict[int, tuple[int, int]] = {}  # of each buffer: its number, and where it begins
    others: list[dict[str, Any]] = []
    for number in range(len(file.items("buffers"))):
        entry = file.item("buffers", number, "the document")
        if "uri" in entry or (number == 0 and file.chunk is not None):
            chunk += bytes(-len(chunk) % 8)
            starts[number] = 0, len(chunk)
            chunk += file.buffer(number)
        else:
            others.append(entry)
            starts[number] = len(others), 0
    document["buffers"] = [{"byteLength": len(chunk)}, *others]
    for number in range(len(file.items("bufferViews"))):
        file.item("bufferViews", number, "the document")
        view = document["bufferViews"][number]
        packed = file.object_in(view, "extensions", f"buffer view {number}")
        places = [view, *(packed[name] for name in MESHOPT if isinstance(packed.get(name), dict))]
        for place in places:
            of = f"buffer view {number}"
            own = file.whole_in(place, "buffer", of)
            if own not in starts:
                file.refuse(f"{of} names a buffer that does not exist")
            place["buffer"], start = starts[own]
            place["byteOffset"] = start + file.whole_in(place, "byteOffset", of, default=0)


def _take_images(file: GltfFile, document: dict[str, Any], chunk: bytearray) -> None:
    """Put images in too, each once; what cannot be had is an image without bytes."""
    views: dict[str, tuple[int, str | None]] = {}
    for number, image in enumerate(file.items("images")):
        uri = image.get("uri") if isinstance(image, dict) else None
        if not isinstance(uri, str):
            continue
        entry = document["images"][number]
        del entry["uri"]
        if uri not in views:
            try:
                content = file.uri_content(uri, f"image {number}")
            except ElastomorphError:
                continue
            chunk += bytes(-len(chunk) % 8)
            place = {"buffer": 0, "byteOffset": len(chunk), "byteLength": len(content)}
            chunk += content
            own = document.setdefault("bufferViews", [])
            own.append(place)
            views[uri] = len(own) - 1, image_kind(content)
        entry["bufferView"], kind = views[uri]
        if kind is not None:
            entry["mimeType"] = kind


def showing_only(file: GltfFile, nodes: Collection[int | None]) -> GltfFile:
    """A file whose other nodes show no mesh; what moved the weights of those is left out.

    Raises:
        FormatError: What is to be shown is in no node.
    """
    if None in nodes:
        file.refuse("no node of its scene shows the meshes that were named")
    document = copy.deepcopy(file.document)
    emptied = set()
    for number, node in enumerate(document["nodes"]):
        if isinstance(node, dict) and "mesh" in node and number not in nodes:
            emptied.add(number)
            for key in ("mesh", "skin", "weights"):
                node.pop(key, None)
    animations = []
    for animation in file.list_in(document, "animations", "the document"):
        if isinstance(animation, dict) and isinstance(animation.get("channels"), list):
            own = animation["channels"]
            animation["channels"] = [each for each in own if not _moves(each, emptied)]
            if own and not animation["channels"]:
                continue
        animations.append(animation)
    document.pop("animations", None)
    if animations:
        document["animations"] = animations
    return GltfFile(file.path, document, file.chunk, file.size, file.rest)


def _moves(channel: Any, nodes: Collection[int]) -> bool:
    """Whether a channel of an animation moves weights of some nodes."""
    target = channel.get("target") if isinstance(channel, dict) else None
    if not isinstance(target, dict):
        return False
    if target.get("path") != "pointer":
        return target.get("path") == "weights" and target.get("node") in nodes
    extensions = target.get("extensions")
    own = extensions.get(POINTER) if isinstance(extensions, dict) else None
    pointer = own.get("pointer") if isinstance(own, dict) else None
    parts = pointer.split("/") if isinstance(pointer, str) else []
    named = parts[1:2] == ["nodes"] and parts[3:4] == ["weights"] and parts[2].isdecimal()
    return named and len(parts[2]) < 10 and int(parts[2]) in nodes
