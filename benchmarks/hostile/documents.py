"""JSON documents with values replaced, and glTF files made to harm."""

from __future__ import annotations

import base64
import copy
import json
import struct
import zlib
from collections.abc import Iterator
from random import Random
from typing import Any

import numpy as np

from hostile.byte_changes import MOST_BYTES
from hostile.case import Case, Entry, Folder, Link, Pipe

__all__ = ["as_gltf", "chunks", "damaged_document", "glb", "glb_files", "gltf_folders"]

_STRANGE: tuple[Any, ...] = (
    *(None, True, False, 0, 1, 2, -1, 3, 5, 7, 255, 65535, 2**31, 2**32, 2**63, 10**30, 1.5, -0.0),
    *(1e308, 10**400, "", "x", "a", "2.0", "AAAA", [], {}, [0], [[]], {"x": 1}, [0, 1]),
    *([1e308, -1e308, 3], ["a"], "0", "NaN", "\ud800", [None], 1e-320, "data:,", "../a"),
)


def glb(document: dict[str, Any] | bytes, blob: bytes = b"") -> bytes:
    """A GLB container."""
    text = document if isinstance(document, bytes) else json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    blob += bytes(-len(blob) % 4)
    parts = struct.pack("<II", len(text), 0x4E4F534A) + text
    if blob:
        parts += struct.pack("<II", len(blob), 0x004E4942) + blob
    return b"glTF" + struct.pack("<II", 2, 12 + len(parts)) + parts


def chunks(content: bytes) -> tuple[dict[str, Any], bytes]:
    """The document and the binary chunk of a whole GLB file."""
    size = struct.unpack_from("<I", content, 12)[0]
    rest = struct.unpack_from("<I", content, 20 + size)[0]
    return json.loads(content[20 : 20 + size]), content[28 + size : 28 + size + rest]


def as_gltf(content: bytes) -> dict[str, bytes]:
    """A whole GLB file as a .gltf file with a .bin file beside it."""
    document, blob = chunks(content)
    document["buffers"] = [{"byteLength": len(blob), "uri": "face.bin"}]
    return {"face.gltf": json.dumps(document, indent=1).encode(), "face.bin": blob}


def damaged_document(random: Random, document: Any) -> tuple[str, Any]:
    """A copy of a JSON document of which one or two values are another, or gone."""
    changed = json.loads(json.dumps(document))
    labels = []
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        places = _places(changed, "")
        if not places:
            break
        holder, key, name = random.choice(places)
        if random.random() < 0.15:
            del holder[key]
            labels.append(f"{name} left out")
        elif random.random() < 0.1:
            holder[key] = _nested(random.choice((10, 100, 900, 960, 985)))
            labels.append(f"{name} nested")
        else:
            holder[key] = copy.deepcopy(random.choice(_STRANGE))
            labels.append(f"{name} = {str(holder[key])[:20]!a}")
    return ", ".join(labels), changed


def text_of(document: Any) -> bytes:
    """JSON text, also of what is nested too deeply for the library."""
    try:
        return json.dumps(document).encode()
    except RecursionError:
        return b"[" * 2000 + b"]" * 2000


def glb_files(whole: bytes) -> Iterator[tuple[str, bytes]]:
    """GLB files, each with what it is.

    Args:
        whole: A whole file of a rig.
    """
    document, blob = chunks(whole)
    text = json.dumps(document)
    for number in range(len(document["accessors"])):
        for key in ("count", "byteOffset", "componentType", "bufferView"):
            for value in (0, -1, 10**6, 10**11, 2**63, 10**30, 1e300, 4, 5126, 5120, 3.0):
                yield (
                    f"accessor {number} {key} {value}",
                    _with(text, blob, "accessors", number, key, value),
                )
    for number in range(len(document["bufferViews"])):
        for key in ("byteStride", "byteOffset", "byteLength", "buffer"):
            for value in (0, 1, -1, 3, 255, 10**11, 2**63):
                yield (
                    f"view {number} {key} {value}",
                    _with(text, blob, "bufferViews", number, key, value),
                )
    for place in (0, 4, 8, 12, 16):
        for value in (0, 1, 3, 20, 0x7FFFFFFF, 0xFFFFFFFF):
            lying = bytearray(whole)
            struct.pack_into("<I", lying, place, value)
            yield f"{value:x} at byte {place}", bytes(lying)
    yield (
        "empty chunks",
        b"glTF"
        + struct.pack("<II", 2, 12 + 8 * 100_000)
        + b"".join(struct.pack("<II", 0, 0x4E4F534A + i) for i in range(100_000)),
    )
    yield from _nested_documents(document, blob)
    yield from _crowded(document, blob)
    yield from _own_extras(text, blob)


def gltf_folders(whole: bytes) -> Iterator[Case]:
    """glTF files whose buffers lie in other files.

    Args:
        whole: A whole GLB file of a rig.
    """
    files = as_gltf(whole)
    document, blob = json.loads(files["face.gltf"]), files["face.bin"]
    away: dict[str, Entry] = {"../outside.bin": blob, "face.bin": blob}

    def pointing(uri: Any, **others: Entry) -> dict[str, Entry]:
        own = json.loads(json.dumps(document))
        own["buffers"][0]["uri"] = uri
        return {"face.gltf": json.dumps(own).encode(), **away, **others}

    yield Case("whole", "face.gltf", dict(files), "loaded")
    for uri in (
        *(
            "../outside.bin",
            "..%2foutside.bin",
            "%2e%2e/outside.bin",
            "..\\outside.bin",
            "..%5coutside.bin",
        ),
        *("x/../../outside.bin", "./../outside.bin", "/etc/passwd", "%2fetc%2fpasswd", "//host/a"),
        *(
            "file:///etc/passwd",
            "file:outside.bin",
            "http://localhost:9/a.bin",
            "HTTP://localhost/a",
        ),
        *("https://localhost/a", "ftp://localhost/a", "C:\\a.bin", "c:/a.bin", "\\\\host\\a", ""),
        *(".", "..", "./", "face.bin%00", "face.bin\0", "\ud800", "a" * 5000, "a/" * 3000 + "b"),
        *(
            "~/a.bin",
            "$HOME/a.bin",
            "/dev/zero",
            "/proc/self/environ",
            "face.bin/x",
            "data:",
            5,
            [],
        ),
        *(
            "data:;base64",
            "data:;base64,AA=A",
            "data:application/octet-stream,abc",
            "data:;base64,%41",
        ),
    ):
        yield Case(f"uri {str(uri)[:40]!a}", "face.gltf", pointing(uri), "refused")
    for uri in ("face.bin", "./face.bin", "face%2ebin", "./x/../face.bin"[:10]):
        yield Case(
            f"uri {uri}", "face.gltf", pointing(uri), "loaded" if ".." not in uri else "either"
        )
    whole_uri = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    yield Case("data uri", "face.gltf", pointing(whole_uri), "loaded")
    link: dict[str, Entry] = {"link.bin": Link("../../outside.bin"), "loop.bin": Link("loop.bin")}
    link |= {"in.bin": Link("face.bin"), "gone.bin": Link("nowhere"), "zero.bin": Link("/dev/zero")}
    link |= {"folder.bin": Folder(), "pipe.bin": Pipe(), "up": Link("..")}
    for name in ("link.bin", "loop.bin", "gone.bin", "zero.bin", "folder.bin", "pipe.bin"):
        yield Case(f"uri {name}", "face.gltf", pointing(name, **link), "refused")
    yield Case("uri up/outside.bin", "face.gltf", pointing("up/outside.bin", **link), "refused")
    yield Case("uri in.bin", "face.gltf", pointing("in.bin", **link), "loaded")
    yield Case("no buffer beside it", "face.gltf", {"face.gltf": files["face.gltf"]}, "refused")
    for length in range(0, len(blob), max(1, len(blob) // 60)):
        cut = {"face.gltf": files["face.gltf"], "face.bin": blob[:length]}
        yield Case(f"buffer cut to {length}", "face.gltf", dict(cut), "refused")
    many = _one_view_a_buffer("big.bin", 3000)
    yield Case(
        "one file for many buffers",
        "face.gltf",
        {"face.gltf": json.dumps(many).encode(), "big.bin": bytes(500_000)},
    )
    itself = _one_view_a_buffer("face.gltf", 3000)
    yield Case("itself for many buffers", "face.gltf", {"face.gltf": json.dumps(itself).encode()})


def _one_view_a_buffer(uri: str, count: int) -> dict[str, Any]:
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 36 + i, "uri": uri} for i in range(count)],
        "bufferViews": [{"buffer": i, "byteLength": 36} for i in range(count)],
        "accessors": [
            {"bufferView": i, "componentType": 5126, "count": 3, "type": "VEC3"}
            for i in range(count)
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": i}} for i in range(count)]}],
    }


def _with(text: str, blob: bytes, part: str, number: int, key: str, value: Any) -> bytes:
    document = json.loads(text)
    document[part][number][key] = value
    return glb(document, blob)


def _nested_documents(document: dict[str, Any], blob: bytes) -> Iterator[tuple[str, bytes]]:
    for depth in (100, 500, *range(900, 1001, 6), 100_000, 300_000):
        deep = b"[" * depth + b"]" * depth
        for key in ("extras", "scene", "nodes", "asset"):
            own = json.dumps({**document, key: "HERE"}).encode().replace(b'"HERE"', deep)
            yield f"{key} {depth} deep", glb(own[: MOST_BYTES - 2000], blob)
        for place in ('"POSITION": 0', '"uri": 0', '"coordinates": 0', '"breaks": 0'):
            name = place.split('"')[1]
            text = json.dumps(document)
            at = text.find(f'"{name}":')
            if at < 0:
                at, text = 1, f'{{"{name}": 0, {text[1:]}'
            stop = text.index(":", at)
            ends = [text.find(mark, stop + 1) for mark in (",", "}")]
            stop_value = min(end for end in ends if end > 0)
            own = text[: stop + 1].encode() + deep + text[stop_value:].encode()
            yield f"{name} {depth} deep", glb(own[: MOST_BYTES - 2000], blob)
    yield "a megabyte of objects", glb(b'{"a":' * 190_000)


def _crowded(document: dict[str, Any], blob: bytes) -> Iterator[tuple[str, bytes]]:
    """Files that name a little very often."""
    points = np.zeros((3, 3), "<f4").tobytes()

    def base(vertices: int = 3, **parts: Any) -> dict[str, Any]:
        return {
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": 12 * vertices}],
            "bufferViews": [{"buffer": 0, "byteLength": 12 * vertices}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3"},
                {"componentType": 5126, "count": vertices, "type": "VEC3"},
            ],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            **parts,
        }

    def compact(own: dict[str, Any], content: bytes = points) -> bytes:
        return glb(json.dumps(own, separators=(",", ":")).encode(), content)

    one = {"attributes": {"POSITION": 0}}
    for count in (1000, 5000, 10_000, 20_000, 28_000):
        yield f"{count} primitives", compact(base(meshes=[{"primitives": [one] * count}]))
        named = [{**one, "material": i} for i in range(count)][:20_000]
        yield (
            f"{count} materials",
            compact(base(meshes=[{"primitives": named}], materials=[{}] * count))[:1_200_000],
        )
        alone = [{"primitives": [one]}] * min(count, 20_000)
        yield f"{count} meshes", compact(base(meshes=alone))
        yield (
            f"{count} nodes",
            compact(
                base(
                    nodes=[{"mesh": 0}] * count,
                    scenes=[{"nodes": list(range(count))}],
                )
            ),
        )
        chain = [{"children": [i + 1]} for i in range(count)] + [{"mesh": 0}]
        yield f"a chain of {count} nodes", compact(base(nodes=chain, scenes=[{"nodes": [0]}]))
        scaled = [{"mesh": 0, "scale": [1, 1, 1]}] * min(count, 25_000)
        nodes = list(range(len(scaled)))
        yield f"{count} scaled nodes", compact(base(nodes=scaled, scenes=[{"nodes": nodes}]))
    for count in (1000, 5000, 20_000, 60_000, 100_000, 300_000):
        own = base()
        own["meshes"][0]["primitives"][0]["targets"] = [{}] * count
        yield f"{count} targets of nothing", compact(own)
        own = base()
        own["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 1}] * min(count, 60_000)
        yield f"{count} targets of zeros", compact(own)
        own["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}] * min(count, 55_000)
        yield f"{count} targets of one accessor", compact(own)
        own["meshes"][0]["extras"] = {"targetNames": ["a"] * min(count, 100_000)}
        yield f"{count} targets of one name", compact(own)
    for vertices in (10_000, 40_000, 75_000):
        content = bytes(12 * vertices)
        for targets in (1, 10, 30, 100, 300, 1000, 3000):
            own = base(vertices)
            own["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 1}] * targets
            yield f"{targets} targets of {vertices} vertices", compact(own, content)
            own = base(vertices)
            placed = [{"mesh": 0, "scale": [2, 1, 1]}] * targets
            own |= {"nodes": placed, "scenes": [{"nodes": list(range(targets))}]}
            yield f"{vertices} vertices shown {targets} times", compact(own, content)
            own = base(
                vertices,
                meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5}] * targets}],
            )
            yield f"{targets} strips of {vertices} vertices", compact(own, content)
            moved = np.zeros((vertices, 3), "<f4")
            moved[::2] = 1
            own = base(vertices)
            own["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}] * targets
            yield f"{targets} moving targets of {vertices} vertices", compact(own, moved.tobytes())


def _own_extras(text: str, blob: bytes) -> Iterator[tuple[str, bytes]]:
    """Strange things in what elastomorph itself leaves in a file."""

    def changed(path: tuple[Any, ...], value: Any) -> bytes:
        document = json.loads(text)
        holder = document["meshes"][0]["extras"]["elastomorph"]
        for key in path[:-1]:
            holder = holder[key]
        holder[path[-1]] = value
        return glb(document, blob)

    names = ["jawOpen", "smile", "Lächeln"]
    stored = json.loads(text)["meshes"][0]["extras"]["elastomorph"]
    surface = stored.get("surface", {})
    for key in surface:
        for value in (*_STRANGE, 2**31 - 1, "A" * 900_000):
            yield f"surface {key} {str(value)[:12]!a}", changed(("surface", key), value)
    for sizes in ([2**31 - 1], [2**31 - 1] * 3, [3, 3, 2**31 - 1], [3] * 100, [0], [-1] * 3):
        yield f"sizes {sizes[:4]}", changed(("surface", "sizes"), _packed(sizes))
        yield f"copies {sizes[:4]}", changed(("surface", "copies"), _packed(sizes))
    for key in ("breaks", "coefficients"):
        for value in (
            *_STRANGE,
            [0, 10**400],
            [[10**400]],
            [0.0] * 200_000,
            [[0.0] * 200_000],
            [["0", "0"]],
            [[0.0], [0.0]],
        ):
            path = ("morphs", 0, "limit_law", key)
            yield f"limit law {key} {str(value)[:12]!a}", changed(path, value)
    for value in (*_STRANGE, 1e300):
        yield f"bake error {str(value)[:12]!a}", changed(("morphs", 0, "bake_error"), value)
        yield f"name {str(value)[:12]!a}", changed(("morphs", 0, "name"), value)
        yield f"version {str(value)[:12]!a}", changed(("version",), value)
    long = [{"name": str(i), "members": [names[0]] * 5} for i in range(12_000)]
    yield "many groups", changed(("groups",), long)
    yield "a long group", changed(("groups",), [{"name": "g", "members": [names[1]] * 90_000}])
    yield "a wrong long group", changed(("groups",), [{"name": "g", "members": ["x"] * 90_000}])
    yield (
        "many drivers",
        changed(("correctives",), [{"name": names[2], "drivers": names[:1] * 90_000}]),
    )
    many = [f"m{i}" for i in range(4000)]
    document = json.loads(text)
    mesh = document["meshes"][0]
    empty = len(document["accessors"])
    count = document["accessors"][mesh["primitives"][0]["attributes"]["POSITION"]]["count"]
    document["accessors"].append({"componentType": 5126, "count": count, "type": "VEC3"})
    for primitive in mesh["primitives"]:
        primitive["targets"] = [{"POSITION": empty}] * len(many)
    mesh["extras"] = {
        "targetNames": many,
        "elastomorph": {
            "version": 1,
            "morphs": [],
            "groups": [{"name": "g", "members": [many[-1]] * 100_000}],
        },
    }
    yield "a long group of many morphs", glb(document, blob)


def _packed(values: list[int]) -> str:
    raw = np.diff(np.array(values, dtype=np.int64), prepend=0).astype("<u4").tobytes()
    return base64.b64encode(zlib.compress(raw)).decode()


def _nested(depth: int) -> Any:
    value: Any = 0
    for _ in range(depth):
        value = [value]
    return value


def _places(value: Any, name: str, depth: int = 0) -> list[tuple[Any, Any, str]]:
    found: list[tuple[Any, Any, str]] = []
    if depth < 20 and isinstance(value, dict | list):
        keys = list(value) if isinstance(value, dict) else range(len(value))
        for key in keys:
            found.append((value, key, f"{name}.{key}"))
            found += _places(value[key], f"{name}.{key}", depth + 1)
    return found
