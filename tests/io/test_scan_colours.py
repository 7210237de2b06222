"""Colours of vertices, in each of the formats that scans come in."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from elastomorph.io.obj import read_obj_colours
from elastomorph.io.rig_folder import rig_as_stored
from elastomorph.io.scan_colours import vertex_colours

COLOURS = np.array([[255, 0, 10], [1, 2, 3], [128, 127, 126]])


def obj(folder: Path, rows: list[str]) -> Path:
    (folder / "scan.obj").write_text("\n".join([*rows, "f 1 2 3", ""]))
    return folder / "scan.obj"


def vertices(colours: np.ndarray, weight: str = "") -> list[str]:
    return [
        f"v {i == 0:d} {i == 1:d} {i == 2:d}{weight} {' '.join(f'{v:.9g}' for v in own)}"
        for i, own in enumerate(colours)
    ]


@pytest.mark.parametrize("weight", ["", " 1.0"])
@pytest.mark.parametrize("largest", [1, 255])
def test_colours_behind_the_positions_of_an_obj(tmp_path: Path, largest: int, weight: str) -> None:
    file = obj(tmp_path, vertices(COLOURS / 255 * largest, weight))
    found = read_obj_colours(file)
    assert found is not None
    assert found.dtype == np.uint8
    np.testing.assert_array_equal(found, COLOURS)
    np.testing.assert_array_equal(vertex_colours(em.read(file)), COLOURS)


def test_an_obj_without_a_colour_for_each_vertex_has_none(tmp_path: Path) -> None:
    assert read_obj_colours(obj(tmp_path, ["v 0 0 0", "v 1 0 0", "v 0 1 0"])) is None
    assert read_obj_colours(obj(tmp_path, [*vertices(COLOURS)[:2], "v 0 1 0"])) is None
    assert read_obj_colours(obj(tmp_path, [])) is None


def test_what_is_no_colour_is_told_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(em.FormatError, match=r"line 2.*red"):
        read_obj_colours(obj(tmp_path, [vertices(COLOURS)[0], "v 0 1 0 red 0 0"]))


def gltf(folder: Path, *parts: tuple[np.ndarray, np.ndarray | None]) -> Path:
    """A mesh of a primitive for each three positions and their colours."""
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": []}],
        "accessors": [],
        "bufferViews": [],
    }
    content = b""

    def accessor(values: np.ndarray) -> int:
        nonlocal content
        view = {"buffer": 0, "byteOffset": len(content), "byteLength": values.nbytes}
        document["bufferViews"].append(view)
        content += values.tobytes()
        whole = values.dtype != np.float32
        document["accessors"].append(
            {
                "bufferView": len(document["bufferViews"]) - 1,
                "componentType": 5121 if whole else 5126,
                "count": len(values),
                "type": f"VEC{values.shape[1]}",
                **({"normalized": True} if whole else {}),
            }
        )
        return len(document["accessors"]) - 1

    for positions, colours in parts:
        attributes = {"POSITION": accessor(positions.astype(np.float32))}
        if colours is not None:
            attributes["COLOR_0"] = accessor(colours)
        document["meshes"][0]["primitives"].append({"attributes": attributes})
    uri = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
    document["buffers"] = [{"byteLength": len(content), "uri": uri}]
    (folder / "scan.gltf").write_text(json.dumps(document))
    return folder / "scan.gltf"


def test_colours_of_a_gltf_are_light_and_come_as_screens_show_them(tmp_path: Path) -> None:
    shown = COLOURS / 255
    light = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    eighths = np.array([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 9]], dtype=np.uint8)
    file = gltf(
        tmp_path,
        (np.eye(3), light.astype(np.float32)),
        (np.eye(3) + 1, None),
        (np.eye(3) + 2, eighths),
    )
    mesh = rig_as_stored(file).neutral
    found = vertex_colours(mesh)
    assert found is not None
    np.testing.assert_array_equal(found[mesh.vertices.max(axis=1) == 1], COLOURS)
    np.testing.assert_array_equal(found[mesh.vertices.max(axis=1) == 2], 255)
    np.testing.assert_array_equal(found[mesh.vertices.max(axis=1) == 3], eighths[:, :3])


@pytest.mark.parametrize("colours", [np.zeros((2, 3), np.uint8), np.zeros((3, 2), np.uint8)])
def test_colours_that_fit_no_vertices_are_told(tmp_path: Path, colours: np.ndarray) -> None:
    mesh = rig_as_stored(gltf(tmp_path, (np.eye(3), colours))).neutral
    with pytest.raises(em.FormatError, match="the colours of mesh 0"):
        vertex_colours(mesh)


def test_meshes_without_colours_have_none(tmp_path: Path) -> None:
    assert vertex_colours(rig_as_stored(gltf(tmp_path, (np.eye(3), None))).neutral) is None
    assert vertex_colours(em.Mesh(np.eye(3), [[0, 1, 2]])) is None
    file = obj(tmp_path, vertices(COLOURS))
    mesh = em.read(file)
    obj(tmp_path, [*vertices(COLOURS), "v 0 0 0 1 1 1"])
    assert vertex_colours(mesh) is None, "the file has other vertices by now"
    file.unlink()
    assert vertex_colours(mesh) is None, "nor is it there"
