"""Our files, plain and compressed, after glTF-Transform: what is kept, and a word on the rest."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from glb_samples import chunks_of, glb, sheet
from scipy.spatial import cKDTree
from viewer_checks import run

import needs
from elastomorph.errors import ElastomorphWarning
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig

KEPT = (
    "dedup",
    "prune",
    "join",
    "flatten",
    "palette",
    "resample",
    "quantize",
    "dequantize",
    "draco",
)
REORDERED = ("weld", "reorder", "meshopt")


@pytest.fixture(scope="module")
def transforming() -> str:
    return needs.node("@gltf-transform/core", "draco3dgltf", "meshoptimizer")


@pytest.mark.parametrize("compress", [False, True])
@pytest.mark.parametrize("step", [*KEPT, *REORDERED])
def test_what_glb_transform_makes_of_it_is_read(
    tmp_path: Path, transforming: str, step: str, compress: bool
) -> None:
    """Shapes and bends stay; the polygons with the order of vertices, or a warning says so."""
    rig = sheet(24, 4)
    write_glb(tmp_path / "a.glb", rig, compress=compress)
    done = run(transforming, "transform.mjs", tmp_path / "a.glb", tmp_path / "b.glb", step)
    assert done.returncode == 0, done.stderr
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", ElastomorphWarning)
        back = read_glb(tmp_path / "b.glb")
    assert back.names == rig.names
    # Every other of the bends is zero, and was left out.
    assert [len(morph.bends) for morph in back.morphs.values()] == [0, 1, 0, 1]
    size = rig.neutral.diameter
    posed, expected = (own.pose({"lift 1": 0.5, "lift 2": 1.0}) for own in (back, rig))
    if step in KEPT:
        assert not told
        assert back.neutral.faces == rig.neutral.faces
        assert np.abs(posed - expected).max() < 5e-4 * size
    else:
        assert "its polygons are lost" in str(told[0].message)
        assert cKDTree(posed).query(expected)[0].max() < 1e-3 * size


def test_other_numbers_of_vertices_are_noticed_where_all_else_fits(tmp_path: Path) -> None:
    """Fans of triangles stay fans when vertices are renumbered; their numbers would be believed."""
    rig = sheet(5, 1)
    write_glb(tmp_path / "a.glb", rig, normals="none")
    document, blob = chunks_of(tmp_path / "a.glb")
    accessor = document["accessors"][document["meshes"][0]["primitives"][0]["indices"]]
    view = document["bufferViews"][accessor["bufferView"]]
    start = view["byteOffset"] + accessor.get("byteOffset", 0)
    corners = np.frombuffer(blob, "<u2", accessor["count"], start)
    turned = (24 - corners).astype("<u2").tobytes()
    blob = blob[:start] + turned + blob[start + len(turned) :]
    (tmp_path / "b.glb").write_bytes(glb(document, blob))
    with pytest.warns(ElastomorphWarning, match="vertices or triangles in another order"):
        read_glb(tmp_path / "b.glb")
    del document["meshes"][0]["extras"]["elastomorph"]["surface"]["corners"]
    (tmp_path / "b.glb").write_bytes(glb(document, blob))
    assert len(read_glb(tmp_path / "b.glb").neutral.faces) == 16  # a file of an older version


@pytest.mark.parametrize("by", [1, 2])
def test_triangles_that_begin_with_another_corner_are_turned_back(tmp_path: Path, by: int) -> None:
    """Packing triangles may turn them; fans of several still tell which corner came first."""
    mesh = Mesh(
        [[0, 0, 0], [1, 0, 0], [2, 1, 0], [1, 2, 0], [0, 2, 0], [3, 0, 0], [3, 3, 0]],
        [[0, 1, 2, 3, 4], [1, 5, 6, 2], [5, 6, 1]],
    )
    write_glb(tmp_path / "a.glb", Rig(mesh, {}), normals="none")
    document, blob = chunks_of(tmp_path / "a.glb")
    accessor = document["accessors"][document["meshes"][0]["primitives"][0]["indices"]]
    view = document["bufferViews"][accessor["bufferView"]]
    start = view["byteOffset"] + accessor.get("byteOffset", 0)
    corners = np.frombuffer(blob, "<u2", accessor["count"], start).reshape(-1, 3).copy()
    corners[[0, 2, 4]] = np.roll(corners[[0, 2, 4]], by, axis=1)
    content = corners.tobytes()
    blob = blob[:start] + content + blob[start + len(content) :]
    (tmp_path / "b.glb").write_bytes(glb(document, blob))
    found = [list(face) for face in read_glb(tmp_path / "b.glb").neutral.faces]
    assert found == [[0, 1, 2, 3, 4], [1, 5, 6, 2], [5, 6, 1]]
    corners[[0, 5]] = np.roll(corners[[0, 5]], by, axis=1)  # a triangle alone stays turned
    content = corners.tobytes()
    blob = blob[:start] + content + blob[start + len(content) :]
    (tmp_path / "b.glb").write_bytes(glb(document, blob))
    *others, alone = [list(face) for face in read_glb(tmp_path / "b.glb").neutral.faces]
    assert others == [[0, 1, 2, 3, 4], [1, 5, 6, 2]]
    assert sorted(alone) == [1, 5, 6]
