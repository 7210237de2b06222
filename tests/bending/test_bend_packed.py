"""A file that meshoptimizer packed stays packed, and what bends add to it is packed too."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_characters import SmallFile, flap_character

import elastomorph as em
from elastomorph.io.gltf import meshopt
from elastomorph.io.gltf.container import open_gltf


def packed(file: SmallFile, name: str) -> SmallFile:
    """The file with its views packed, all but those whose rows are no fours of bytes."""
    views = file.json["bufferViews"]
    strides = {
        own["bufferView"]: 4 * {"VEC3": 3}.get(own["type"], 0)
        for own in file.json["accessors"]
        if own["componentType"] == 5126
    }
    plain, blob, length = bytes(file.blob), bytearray(), 0
    for number, view in enumerate(views):
        content = plain[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        stride = strides.get(number, 0)
        stored = meshopt.encode_attributes(content, stride) if stride else content
        place: dict[str, Any] = {"buffer": 0, "byteOffset": len(blob), "byteLength": len(stored)}
        blob += stored + bytes(-len(stored) % 4)
        if stride:
            own = {"byteStride": stride, "mode": "ATTRIBUTES", "count": len(content) // stride}
            extensions = {"extensions": {name: place | own}}
            place = {"buffer": 1, "byteOffset": length, "byteLength": len(content)} | extensions
            length += len(content)
        view.clear()
        view.update(place)
    file.blob = blob
    file.json["extensionsUsed"] = file.json["extensionsRequired"] = [name]
    file.json["fallback"] = {"byteLength": length, "extensions": {name: {"fallback": True}}}
    return file


def write(file: SmallFile, path: Path) -> Path:
    """With a second buffer that has no bytes."""
    fallback = file.json.pop("fallback")
    file.write(path)
    # The writer of small files knows one buffer.
    content = path.read_bytes()
    document = open_gltf(path).document
    document["buffers"].append(fallback)
    from elastomorph.io.gltf.container import glb_chunks

    blob = content[-len(file.blob) - -len(file.blob) % 4 :]
    path.write_bytes(b"".join(glb_chunks(json.dumps(document).encode(), blob)))
    return path


@pytest.mark.parametrize("suffix", ["glb", "gltf"])
def test_what_is_added_is_packed_where_that_is_asked(tmp_path: Path, suffix: str) -> None:
    """Rounded by a little; the rest of the file, and the way back, are as without."""
    path = flap_character(normals=True).write(tmp_path / f"a.{suffix}")
    plain, small = (
        em.bend(path, tmp_path / f"{name}.{suffix}", compress=name == "packed")
        for name in ("plain", "packed")
    )
    assert plain.output is not None
    assert small.output is not None
    files = [open_gltf(own) for own in (path, small.output)]
    first = len(files[0].document["bufferViews"])
    views = files[1].document["bufferViews"]
    assert views[:first] == files[0].document["bufferViews"]
    assert all(meshopt.EXTENSIONS[0] in own["extensions"] for own in views[first:])
    assert meshopt.EXTENSIONS[0] in files[1].document["extensionsRequired"]
    found, expected = em.read_rig(small.output), em.read_rig(plain.output)
    for t in (0.3, 0.7):
        straight = em.read_rig(path, method="linear").pose({"open": t})
        bent = np.abs(expected.pose({"open": t}) - straight).max()
        away = np.abs(found.pose({"open": t}) - expected.pose({"open": t})).max()
        assert 0 < away < 2e-4 * bent
    em.unbend(small.output, tmp_path / f"back.{suffix}")
    back = open_gltf(tmp_path / f"back.{suffix}")
    assert back.document == files[0].document
    assert back.buffer(0) == files[0].buffer(0)
    again = em.bend(path, tmp_path / f"again.{suffix}")  # nothing of it is left in the source
    assert again.bytes == plain.bytes


@pytest.mark.parametrize("name", meshopt.EXTENSIONS)
def test_bends_of_a_packed_file_are_packed(tmp_path: Path, name: str) -> None:
    path = write(packed(flap_character(normals=True), name), tmp_path / "a.glb")
    em.bend(path, tmp_path / "b.glb")
    original, bent = open_gltf(path), open_gltf(tmp_path / "b.glb")
    first = len(original.document["bufferViews"])
    added = bent.document["bufferViews"][first:]
    assert added
    for view in added:
        assert view["buffer"] == 1
        own = view["extensions"][name]
        assert own["byteLength"] < view["byteLength"] == own["count"] * own["byteStride"]
        assert view["byteOffset"] + view["byteLength"] <= bent.document["buffers"][1]["byteLength"]
    plain = flap_character(normals=True).write(tmp_path / "plain.glb")
    em.bend(plain, tmp_path / "bent plain.glb")
    found, expected = em.read_rig(tmp_path / "b.glb"), em.read_rig(tmp_path / "bent plain.glb")
    for t in (0.3, 0.7):
        np.testing.assert_array_equal(found.pose({"open": t}), expected.pose({"open": t}))
    em.unbend(tmp_path / "b.glb", tmp_path / "c.glb")
    assert open_gltf(tmp_path / "c.glb").document == original.document
    assert open_gltf(tmp_path / "c.glb").buffer(0) == original.buffer(0)
