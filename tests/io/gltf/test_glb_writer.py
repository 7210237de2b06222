"""What is in the file, byte by byte, for a rig small enough to work out by hand."""

from __future__ import annotations

import io
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import chunks_of, seamed_mesh, triangle, triangle_rig

from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh, UVMap
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig
from small_meshes import grid


def floats_of(document: dict[str, Any], blob: bytes, number: int) -> np.ndarray:
    """An accessor of floats, dense or sparse, read without any library."""
    accessor = document["accessors"][number]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[accessor["type"]]
    assert accessor["componentType"] == 5126
    values = np.zeros((accessor["count"], width))

    def start(holder: dict[str, Any]) -> int:
        view = document["bufferViews"][holder["bufferView"]]
        return int(view.get("byteOffset", 0) + holder.get("byteOffset", 0))

    if "bufferView" in accessor:
        flat = struct.unpack_from(f"<{values.size}f", blob, start(accessor))
        values[:] = np.reshape(flat, values.shape)
    if "sparse" in accessor:
        sparse = accessor["sparse"]
        places = struct.unpack_from(f"<{sparse['count']}H", blob, start(sparse["indices"]))
        flat = struct.unpack_from(f"<{sparse['count'] * width}f", blob, start(sparse["values"]))
        values[list(places)] = np.reshape(flat, (-1, width))
    return values


def test_an_open_file_gets_the_same_bytes(tmp_path: Path) -> None:
    file = io.BytesIO()
    report = write_glb(file, triangle_rig())
    assert report == write_glb(tmp_path / "a.glb", triangle_rig())
    assert file.getvalue() == (tmp_path / "a.glb").read_bytes()
    assert report.bytes == len(file.getvalue())


def test_a_file_has_a_clip_a_slider_where_they_are_asked_for(tmp_path: Path) -> None:
    rig = triangle_rig()
    assert write_glb(tmp_path / "a.glb", rig).parts.get("animations") is None
    write_glb(tmp_path / "b.glb", rig, clips=True)
    assert "animations" not in chunks_of(tmp_path / "a.glb")[0]
    clips = chunks_of(tmp_path / "b.glb")[0]["animations"]
    assert [clip["name"] for clip in clips] == list(rig.morphs)


def test_a_triangle_worked_out_by_hand(tmp_path: Path) -> None:
    """Vertex 2 goes from (0, 1, 0) to (0, 0, 1), bent by (0, -½, -½); its normal from z to -y."""
    report = write_glb(tmp_path / "a.glb", triangle_rig(), clips=True)
    document, blob = chunks_of(tmp_path / "a.glb")
    mesh = document["meshes"][0]
    assert mesh["extras"]["targetNames"] == ["lift", "lift.bend1"]
    assert mesh["weights"] == [0, 0]
    (primitive,) = mesh["primitives"]
    read = lambda number: floats_of(document, blob, number).tolist()  # noqa: E731
    assert read(primitive["attributes"]["POSITION"]) == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert read(primitive["attributes"]["NORMAL"]) == [[0, 0, 1]] * 3
    lift, bend = primitive["targets"]
    assert read(lift["POSITION"]) == [[0, 0, 0], [0, 0, 0], [0, -1, 1]]
    assert read(bend["POSITION"]) == [[0, 0, 0], [0, 0, 0], [0, 0.5, 0.5]]
    np.testing.assert_allclose(read(lift["NORMAL"]), [[0, -1, -1]] * 3, atol=1e-7)
    bounds = document["accessors"][lift["POSITION"]]
    assert (bounds["min"], bounds["max"]) == ([0, -1, 0], [0, 0, 1])
    (clip,) = document["animations"]
    assert clip["name"] == "lift"
    assert clip["channels"] == [{"sampler": 0, "target": {"node": 0, "path": "weights"}}]
    times = np.array(read(clip["samplers"][0]["input"]))[:, 0]
    weights = np.array(read(clip["samplers"][0]["output"])).reshape(-1, 2)
    np.testing.assert_allclose(weights, np.stack([times, times - times**2], axis=1), atol=1e-7)
    assert (times[0], times[-1]) == (0, 1)
    assert (report.vertices, report.triangles, report.targets, report.bends) == (3, 1, 2, 1)
    assert report.bytes == (tmp_path / "a.glb").stat().st_size
    assert report.largest_error == report.key_error + report.rounding_error
    assert 0 < report.key_error <= 1e-4


def test_extras_are_plain_numbers_that_give_the_curve(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", triangle_rig())
    stored = chunks_of(tmp_path / "a.glb")[0]["meshes"][0]["extras"]["elastomorph"]
    assert stored["version"] == 1
    (morph,) = stored["morphs"]
    assert (morph["name"], morph["target"], morph["method"]) == ("lift", "lift", "by hand")
    assert morph["bends"] == [
        {"target": "lift.bend1", "curve": {"breaks": [0, 1], "coefficients": [[0, 1, -1]]}}
    ]


def rig_of_sizes(*sizes: float) -> Rig:
    """One bend t² - t on each vertex of a mesh with D = 1, of four times the given size."""
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0.5, 0.1, 0]], [[0, 1, 2]])
    bends = np.zeros((len(sizes), 3, 3))
    bends[:, 0, 2] = np.multiply(4, sizes)
    curve = BendCurve.power(2)
    return Rig(mesh, {"m": Morph(mesh, mesh, bends, (curve,) * len(sizes), bake_error=0.5e-6)})


def test_bends_below_the_tolerance_are_left_out_and_the_error_is_told(tmp_path: Path) -> None:
    """max|t² - t| = ¼, so a bend of size 4s moves its vertex by s."""
    rig = rig_of_sizes(1e-3, 2e-6, 0.9e-5, 1.1e-5)
    report = write_glb(tmp_path / "a.glb", rig, tolerance=1e-5)
    assert report.dropped_bends == ("m.bend2", "m.bend3")
    assert report.dropped_error == pytest.approx(1.1e-5, rel=1e-3)
    names = chunks_of(tmp_path / "a.glb")[0]["meshes"][0]["extras"]["targetNames"]
    assert names == ["m", "m.bend1", "m.bend4"]
    assert read_glb(tmp_path / "a.glb").morphs["m"].bake_error == pytest.approx(1.15e-5, rel=1e-3)
    report = write_glb(tmp_path / "a.glb", rig, tolerance=0)
    assert report.dropped_bends == ()
    assert report.dropped_error == 0


def test_a_kept_bend_leaves_out_the_vertices_it_hardly_moves(tmp_path: Path) -> None:
    rig = rig_of_sizes(1e-2)
    bends = rig.morphs["m"].bends.copy()
    bends[0, 1, 1] = 4 * 3e-6
    morph = Morph(rig.neutral, rig.neutral, bends, (BendCurve.power(2),))
    report = write_glb(tmp_path / "a.glb", Rig(rig.neutral, {"m": morph}), tolerance=1e-5)
    assert report.dropped_error == pytest.approx(3e-6, rel=1e-3)
    back = read_glb(tmp_path / "a.glb").morphs["m"].bends
    assert np.flatnonzero(back[0].any(axis=1)).tolist() == [0]


def test_a_bend_of_zero_costs_nothing(tmp_path: Path) -> None:
    report = write_glb(tmp_path / "a.glb", rig_of_sizes(0), tolerance=0)
    assert report.dropped_bends == ("m.bend1",)


def test_the_rounding_error_is_that_of_single_precision(tmp_path: Path) -> None:
    """Far from the origin single precision is coarser: 1000.1 is off by 1.4e-5 in each axis."""
    far = Mesh(triangle().vertices + 1000.1, [[0, 1, 2]])
    report = write_glb(
        tmp_path / "a.glb", Rig(far, {"m": Morph(far, far, np.zeros((0, 3, 3)), ())})
    )
    away = np.float32(1000.1).astype(float) - 1000.1
    assert report.rounding_error == pytest.approx(abs(away) * np.sqrt(3) / np.sqrt(2), rel=0.9)
    assert report.rounding_error > 1e-6


def test_a_bend_is_never_called_like_a_morph(tmp_path: Path) -> None:
    one = triangle_rig().morphs["lift"]
    rig = Rig(one.neutral, {"a": one, "a.bend1": one})
    write_glb(tmp_path / "a.glb", rig)
    names = chunks_of(tmp_path / "a.glb")[0]["meshes"][0]["extras"]["targetNames"]
    assert names == ["a", "a.bend1_", "a.bend1", "a.bend1.bend1"]
    assert read_glb(tmp_path / "a.glb").names == ("a", "a.bend1")


def bumps(mesh: Mesh, moved: int) -> Rig:
    up = mesh.vertices.copy()
    up[:moved, 2] += 1 + np.arange(moved) / 7
    target = mesh.with_vertices(up)
    return Rig(mesh, {"bump": Morph(mesh, target, np.zeros((0, *up.shape)), ())})


def test_targets_are_sparse_exactly_where_that_is_smaller(tmp_path: Path) -> None:
    """12 bytes a vertex, against 12 + 2 for a moved one: up to 6/7 of the vertices."""
    mesh = grid(7, 7)
    for moved, sparse in ((0, True), (41, True), (42, False), (49, False)):
        write_glb(tmp_path / "a.glb", bumps(mesh, moved), normals="none")
        document = chunks_of(tmp_path / "a.glb")[0]
        target = document["meshes"][0]["primitives"][0]["targets"][0]
        accessor = document["accessors"][target["POSITION"]]
        assert ("bufferView" not in accessor) == sparse
        assert ("sparse" in accessor) == (sparse and moved > 0)
    write_glb(tmp_path / "a.glb", bumps(mesh, 1), sparse=False)
    assert not any("sparse" in each for each in chunks_of(tmp_path / "a.glb")[0]["accessors"])


def test_without_turning_normals_the_file_has_only_those_of_the_neutral(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", triangle_rig(), normals="none")
    (primitive,) = chunks_of(tmp_path / "a.glb")[0]["meshes"][0]["primitives"]
    assert "NORMAL" in primitive["attributes"]
    assert all(set(target) == {"POSITION"} for target in primitive["targets"])


def test_equal_targets_are_stored_once(tmp_path: Path) -> None:
    one = triangle_rig().morphs["lift"]
    write_glb(tmp_path / "a.glb", Rig(one.neutral, {"a": one, "b": one}))
    first, _, second, _ = chunks_of(tmp_path / "a.glb")[0]["meshes"][0]["primitives"][0]["targets"]
    assert first == second


def test_equal_numbers_of_another_use_are_stored_apart(tmp_path: Path) -> None:
    """Times 0, 1 and weights 0, 1; and a target whose displacements are the normals."""
    flat = triangle()
    up = flat.with_vertices(flat.vertices + [0, 0, 1])
    write_glb(
        tmp_path / "a.glb", Rig(flat, {"up": Morph(flat, up, np.zeros((0, 3, 3)), ())}), clips=True
    )
    document = chunks_of(tmp_path / "a.glb")[0]
    (sampler,) = document["animations"][0]["samplers"]
    assert sampler["input"] != sampler["output"]
    (primitive,) = document["meshes"][0]["primitives"]
    target = primitive["targets"][0]["POSITION"]
    assert target != primitive["attributes"]["NORMAL"]
    assert document["accessors"][target]["max"] == [0, 0, 1]


def test_both_sides_of_a_seam_are_lit_alike(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", Rig(replace(seamed_mesh(), materials=None), {}))
    document, blob = chunks_of(tmp_path / "a.glb")
    normals = floats_of(
        document, blob, document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"]
    )
    np.testing.assert_array_equal(normals[[7, 8]], normals[[1, 2]])


def test_both_sides_of_two_materials_are_lit_alike(tmp_path: Path) -> None:
    """At rest and as the target turns what only one of them is moved by."""
    mesh = replace(seamed_mesh(), uv=None)
    up = mesh.with_vertices(mesh.vertices + np.eye(7)[:, :1] * [0, 0, 1.0])
    write_glb(tmp_path / "a.glb", Rig(mesh, {"up": Morph(mesh, up, np.zeros((0, 7, 3)), ())}))
    document, blob = chunks_of(tmp_path / "a.glb")
    found = []
    for own in document["meshes"][:2]:
        (primitive,) = own["primitives"]
        places = [v["attributes"]["POSITION"] for v in (primitive,)]
        at = floats_of(document, blob, places[0])
        rest = floats_of(document, blob, primitive["attributes"]["NORMAL"])
        turned = floats_of(document, blob, primitive["targets"][0]["NORMAL"])
        found.append(
            {tuple(p): (*n, *d) for p, n, d in zip(at.tolist(), rest, turned, strict=True)}
        )
    shared = set(found[0]) & set(found[1])
    assert len(shared) == 2
    assert all(found[0][place] == found[1][place] for place in shared)
    assert any(any(found[0][place][3:]) for place in shared)


def test_a_performance_takes_the_place_of_the_sliders(tmp_path: Path) -> None:
    rig = triangle_rig()
    times, weights = [0.0, 0.5, 1.5], [[0.0], [0.5], [2.0]]
    report = write_glb(tmp_path / "a.glb", rig, animation=(times, weights, "take 1"))
    document, blob = chunks_of(tmp_path / "a.glb")
    (clip,) = document["animations"]
    assert clip["name"] == "take 1"
    found = floats_of(document, blob, clip["samplers"][0]["output"]).reshape(-1, 2)
    np.testing.assert_allclose(found, [[0, 0], [0.5, 0.25], [2, -1]])  # straight on beyond 1
    assert report.key_error == 0


@pytest.mark.parametrize(
    "wrong",
    [
        {"normals": "smooth"},
        {"tolerance": -1},
        {"tolerance": float("nan")},
        {"keys_tolerance": float("inf")},
        {"fps": 0},
        {"fps": float("nan")},
    ],
)
def test_settings_out_of_range_are_refused(tmp_path: Path, wrong: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match=next(iter(wrong))):
        write_glb(tmp_path / "a.glb", triangle_rig(), **wrong)
    assert not list(tmp_path.iterdir())


def test_what_single_precision_cannot_hold_is_refused(tmp_path: Path) -> None:
    huge = Mesh(triangle().vertices * 1e38, [[0, 1, 2]])
    with pytest.raises(FormatError, match="too large"):
        write_glb(tmp_path / "a.glb", Rig(huge, {}))
    uv = UVMap(np.array([[np.nan, 0.0]]), np.zeros(3, dtype=np.int32))
    with pytest.raises(FormatError, match="texture"):
        write_glb(tmp_path / "a.glb", Rig(Mesh(triangle().vertices, [[0, 1, 2]], uv=uv), {}))
    flat = triangle()
    unknown = Morph(flat, flat, np.zeros((0, 3, 3)), (), bake_error=float("nan"))
    with pytest.raises(FormatError, match="bake error"):
        write_glb(tmp_path / "a.glb", Rig(flat, {"m": unknown}))
    with pytest.raises(FileError, match="does not exist"):
        write_glb(tmp_path / "no folder" / "a.glb", triangle_rig())


def test_a_file_whose_size_the_header_cannot_count_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    size = write_glb(tmp_path / "a.glb", triangle_rig()).bytes
    monkeypatch.setattr("elastomorph.io.gltf.writer._LARGEST_FILE", size - 1)
    with pytest.raises(FormatError, match="4 GiB"):
        write_glb(tmp_path / "b.glb", triangle_rig())
    assert not (tmp_path / "b.glb").exists()
