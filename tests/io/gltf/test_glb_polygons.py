"""Polygons of other programs' files, as FB_ngon_encoding tells them by fans of triangles."""

from __future__ import annotations

import json
import subprocess
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import HandMade

import elastomorph as em
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.model.polygons import Polygons, polygon_normals
from foreign_files import chunks_of
from needs import WEB, node

# A row of a quad, a pentagon, a quad and a triangle.
PLACES = np.array(
    [
        *([0, 0, 0], [1, 0, 0.1], [1, 1, 0.2], [0, 1, 0]),
        *([2, 0, 0], [2.5, 0.5, 0.3], [2, 1, 0.1], [4, 0, 0.2], [4, 1, 0], [5, 0, 0.1]),
    ]
)
POLYGONS = [[0, 1, 2, 3], [1, 4, 5, 6, 2], [4, 7, 8, 5], [9, 8, 7]]
FANS = [[p[0], *pair] for p in POLYGONS for pair in pairwise(p[1:])]
# What begins with the same corner as the triangle before, and does not lie on it.
NO_FANS = [[0, 1, 2], [0, 3, 1], [2, 3, 0], [4, 5, 6], [4, 7, 8], [4, 5, 8]]


def row(triangles: list[list[int]], *, told: bool = True, **node: Any) -> HandMade:
    """The row with a target that lifts it, shown by one node."""
    file = HandMade()
    add(file, triangles, told=told)
    file.document["nodes"] = [{"mesh": 0, **node}]
    return file


def add(
    file: HandMade, triangles: list[list[int]], *, mesh: int = 0, told: bool = True, **more: Any
) -> None:
    if told:
        file.document["extensionsUsed"] = ["FB_ngon_encoding"]
        more["extensions"] = {"FB_ngon_encoding": {}}
    lift = np.outer(PLACES[:, 0], [0, 0, 0.2]) + np.outer(PLACES[:, 1] ** 2, [0, 0.3, 0])
    uv = PLACES[:, :2] / 5
    file.primitive(
        mesh,
        attributes={"POSITION": file.array(PLACES), "TEXCOORD_0": file.array(uv)},
        indices=file.array(np.array(triangles).reshape(-1), "<u2"),
        targets=[{"POSITION": file.array(lift)}],
        **more,
    )


def listed(faces: Polygons) -> list[list[int]]:
    return [own.tolist() for own in faces]


def test_fans_are_read_as_the_polygons_they_were(tmp_path: Path) -> None:
    neutral = em.read_rig(row(FANS).write(tmp_path / "a.glb")).neutral
    assert listed(neutral.faces) == POLYGONS
    np.testing.assert_array_equal(neutral.faces.triangles(), FANS)
    assert neutral.uv is not None
    shown = neutral.uv.coordinates[neutral.uv.corners] * 5  # v counts from the bottom
    places = PLACES[neutral.faces.indices]
    np.testing.assert_allclose(shown[:, 0], places[:, 0], atol=1e-6)
    np.testing.assert_allclose(5 - shown[:, 1], places[:, 1], atol=1e-6)
    np.testing.assert_array_equal(neutral.uv.corners, neutral.faces.indices)


def test_without_the_extension_triangles_stay_triangles(tmp_path: Path) -> None:
    neutral = read_glb(row(FANS, told=False).write(tmp_path / "a.glb")).neutral
    assert listed(neutral.faces) == FANS


def test_the_extension_on_strips_and_fans_says_nothing(tmp_path: Path) -> None:
    file = row([[0, 1, 2]])
    primitive = file.document["meshes"][0]["primitives"][0]
    primitive |= {"mode": 6, "indices": file.array([0, 1, 2, 3], "<u2")}
    neutral = read_glb(file.write(tmp_path / "a.glb")).neutral
    assert listed(neutral.faces) == [[0, 1, 2], [0, 2, 3]]


def test_triangles_that_are_no_fans_stay_triangles(tmp_path: Path) -> None:
    neutral = read_glb(row(NO_FANS).write(tmp_path / "a.glb")).neutral
    assert listed(neutral.faces) == NO_FANS


# All around a corner, to and fro, and around one that a polygon has already been to.
CLOSED = [
    [[0, 1, 2], [0, 2, 3], [0, 3, 1]],
    [[0, 1, 2], [0, 2, 1]],
    [[3, 0, 1], [3, 1, 2], [3, 2, 4], [3, 4, 1], [3, 1, 5]],
]


@pytest.mark.parametrize("triangles", CLOSED)
def test_no_polygon_has_a_corner_twice(triangles: list[list[int]], tmp_path: Path) -> None:
    """The polygons beside a fan that closes are read all the same."""
    around = [*FANS[:2], *triangles, *FANS[5:]]
    neutral = read_glb(row(around).write(tmp_path / "a.glb")).neutral
    assert listed(neutral.faces) == [POLYGONS[0], *triangles, *POLYGONS[2:]]


@pytest.mark.parametrize("extensions", [[], "FB_ngon_encoding", None])
def test_extensions_that_are_no_object_say_nothing(tmp_path: Path, extensions: Any) -> None:
    file = row(FANS)
    file.document["meshes"][0]["primitives"][0]["extensions"] = extensions
    assert listed(read_glb(file.write(tmp_path / "a.glb")).neutral.faces) == FANS


def test_polygons_of_a_mirrored_node_are_wound_the_other_way(tmp_path: Path) -> None:
    """From the same corner each; the vectors of area are those of the mirrored surface."""
    plain = read_glb(row(FANS).write(tmp_path / "a.glb")).neutral
    neutral = read_glb(row(FANS, scale=[-1, 1, 1]).write(tmp_path / "b.glb")).neutral
    assert listed(neutral.faces) == [[p[0], *p[:0:-1]] for p in POLYGONS]
    mirrored = polygon_normals(plain.vertices, plain.faces) * [-1, 1, 1]
    np.testing.assert_allclose(polygon_normals(neutral.vertices, neutral.faces), mirrored)


def test_each_primitive_begins_anew_with_materials_of_polygons(tmp_path: Path) -> None:
    """Neither fans nor labels run on into the next primitive, which may be of triangles."""
    file = row(FANS[:2])
    file.document["materials"] = [{"name": "skin"}, {"name": "lips"}]
    file.document["meshes"][0]["primitives"][0]["material"] = 0
    add(file, [[0, 3, 6], *FANS[2:]], material=1)
    add(file, FANS[:2], told=False)
    neutral = read_glb(file.write(tmp_path / "a.glb")).neutral
    assert neutral.faces.sizes.tolist() == [4, 3, 5, 4, 3, 3, 3]
    assert neutral.materials is not None
    assert neutral.materials.names == ("skin", "lips")
    assert neutral.materials.of_face.tolist() == [0, 1, 1, 1, 1, -1, -1]


def test_polygons_come_back_from_a_file_written_of_them(tmp_path: Path) -> None:
    rig = read_glb(row(FANS).write(tmp_path / "a.glb"))
    write_glb(tmp_path / "b.glb", rig)
    assert read_glb(tmp_path / "b.glb").neutral.faces == rig.neutral.faces


def test_bend_in_place_keeps_the_triangles_of_the_file(tmp_path: Path) -> None:
    path = row(FANS, scale=[-1, 1, 1]).write(tmp_path / "a.glb")
    em.bend(path, tmp_path / "b.glb", method="rotation")
    (before, old), (after, new) = (chunks_of(tmp_path / name) for name in ("a.glb", "b.glb"))

    def triangles(document: dict[str, Any], blob: bytes) -> tuple[bytes, Any]:
        primitive = document["meshes"][0]["primitives"][0]
        view = document["bufferViews"][document["accessors"][primitive["indices"]]["bufferView"]]
        start = view.get("byteOffset", 0)
        return blob[start : start + view["byteLength"]], primitive["extensions"]

    assert triangles(before, old) == triangles(after, new)
    assert listed(read_glb(tmp_path / "b.glb").neutral.faces) == [
        [p[0], *p[:0:-1]] for p in POLYGONS
    ]


def test_polygons_are_those_that_the_page_draws(tmp_path: Path) -> None:
    """By their edges: of fans, of what is none, mirrored and not."""
    two = row(FANS)
    two.document["meshes"].append({"primitives": []})
    two.document["nodes"].append({"mesh": 1, "translation": [0, 9, 0], "scale": [1, 1, -1]})
    two.document["scenes"] = [{"nodes": [0, 1]}]
    add(two, FANS, mesh=1)
    files = {
        "fans": row(FANS),
        "mirrored": row(FANS, scale=[1, -1, 1]),
        **{f"closed {n}": row([*FANS[:2], *own, *FANS[5:]]) for n, own in enumerate(CLOSED)},
        "mirrored closed": row([*FANS[:2], *CLOSED[2], *FANS[5:]], scale=[1, -1, 1]),
        "none": row(NO_FANS),
        "mirrored none": row(NO_FANS, scale=[1, -1, 1]),
        "untold": row(FANS, told=False),
        "two": two,
    }
    paths = [str(file.write(tmp_path / f"{name}.glb")) for name, file in files.items()]
    words = [node("vite"), str(WEB / "checks" / "edges.mjs"), *paths]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for path, edges in json.loads(done.stdout).items():
        drawn = {tuple(own) for own in np.reshape(edges, (-1, 2)).tolist()}
        assert drawn == {tuple(own) for own in read_glb(path).neutral.edges.tolist()}, path
