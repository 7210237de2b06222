"""Files with whole steps for coordinates, packed by meshoptimizer."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from glb_samples import chunks_of, rigs, seamed_mesh, sheet, triangle_rig
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from viewer_checks import drawn, validated

import needs
from elastomorph.errors import MissingExtraError
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.io.gltf.accessors import Grid, byte_normals, padded, within_reach
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig

needs.extra("meshopt", "gltf")
LARGEST_ERROR = 1.002e-4  # curves are searched for their largest value to within a thousandth


@given(rig=rigs())
@settings(
    max_examples=40,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
def test_a_rig_comes_back_within_what_the_report_says(tmp_path: Path, rig: Rig) -> None:
    report = write_glb(tmp_path / "a.glb", rig, compress=True)
    back = read_glb(tmp_path / "a.glb")
    assert report.rounding_error <= LARGEST_ERROR
    one, other = rig.neutral, back.neutral
    assert one.faces == other.faces
    assert (one.uv is None) == (other.uv is None) or not len(one.faces)
    if one.uv is not None and other.uv is not None:
        assert one.uv.coordinates.tobytes() == other.uv.coordinates.tobytes()
        np.testing.assert_array_equal(one.uv.corners, other.uv.corners)
    assert (one.materials is None) == (other.materials is None)
    assert list(rig.morphs) == list(back.morphs)
    assert rig.sliders.correctives == back.sliders.correctives
    size = one.diameter or 1.0
    allowed = report.rounding_error + report.dropped_error + 1e-6
    for name in rig.morphs:
        for t in (0.0, 0.3, 0.7, 1.0):
            away = np.linalg.norm(back.morphs[name].at(t) - rig.morphs[name].at(t), axis=-1)
            assert away.max() <= allowed * size + 1e-4 * report.dropped_error


def test_a_bend_that_is_rounded_away_is_left_out(tmp_path: Path) -> None:
    """Beside a displacement of 1, in steps of some 1e-5, one of 1e-5 is none."""
    neutral = Mesh(np.eye(3), [[0, 1, 2]])
    target = neutral.with_vertices(neutral.vertices + [1.0, 0.0, 0.0])
    curve = BendCurve.polynomial([0.0, 1.0, -1.0])
    morph = Morph(neutral, target, np.full((1, 3, 3), 1e-5), (curve,))
    report = write_glb(tmp_path / "a.glb", Rig(neutral, {"aside": morph}), compress=True)
    assert report.dropped_bends == ("aside.bend1",)
    assert 0 < report.dropped_error < 1e-5
    assert len(read_glb(tmp_path / "a.glb").morphs["aside"].bends) == 0  # and nobody is warned


def test_a_triangle_worked_out_by_hand(tmp_path: Path) -> None:
    """D is √3 to the last bit of single precision, and a parabola is at most ¼ of its bend.

    The step is 1e-4 D / (½√3 (1 + 1 + ¼)); positions count from the middle of the box.
    """
    rig = triangle_rig()
    write_glb(tmp_path / "a.glb", rig, normals="none", compress=True)
    document, _ = chunks_of(tmp_path / "a.glb")
    assert document["extensionsRequired"] == ["EXT_meshopt_compression", "KHR_mesh_quantization"]
    node = document["nodes"][0]
    step = 1e-4 * rig.neutral.diameter / (np.sqrt(3) / 2 * 2.25)
    np.testing.assert_allclose(node["scale"], 32767 * step, rtol=1e-3)
    np.testing.assert_array_equal(node["translation"], [0.5, 0.5, 0])
    primitive = document["meshes"][0]["primitives"][0]
    half = round(0.5 / node["scale"][0] * 32767)
    shown = document["accessors"][primitive["attributes"]["POSITION"]]
    assert (shown["min"], shown["max"]) == ([-half, -half, 0], [half, half, 0])
    assert shown["componentType"] == 5122
    assert shown["normalized"]
    delta = document["accessors"][primitive["targets"][0]["POSITION"]]
    one = round(1 / node["scale"][0] * 32767)
    assert (delta["min"], delta["max"]) == ([0, -one, 0], [0, 0, one])


def test_targets_share_the_steps_of_their_mesh(tmp_path: Path) -> None:
    mesh = seamed_mesh()
    step = Grid.of(Rig(mesh, {}), 1e-4).step
    targets = {
        "small": mesh.vertices + np.array([[100.4 * step, 0, 0]]),
        "large": mesh.vertices + np.array([[0, 0, 200 * step]]),
        "none": mesh.vertices,
        "beyond": mesh.vertices + np.array([[0, 1e6 * step, 0]]),
    }
    straight = np.zeros((0, *mesh.vertices.shape))
    morphs = {name: Morph(mesh, mesh.with_vertices(v), straight, ()) for name, v in targets.items()}
    write_glb(tmp_path / "a.glb", Rig(mesh, morphs), normals="none", compress=True)
    document, _ = chunks_of(tmp_path / "a.glb")
    primitive = document["meshes"][0]["primitives"][0]
    kinds = [document["accessors"][own["POSITION"]] for own in primitive["targets"]]
    assert [own["componentType"] for own in kinds] == [5122, 5122, 5122, 5126]
    assert ["normalized" in own for own in kinds] == [True, True, True, False]
    assert kinds[0]["max"] == [100, 0, 0]
    assert ["bufferView" in own for own in kinds] == [True, True, False, True]
    back = read_glb(tmp_path / "a.glb")
    np.testing.assert_allclose(back.morphs["large"].delta, [[0, 0, 200 * step]] * 7, rtol=1e-6)


@given(
    arrays(np.float64, (8, 3), elements=st.floats(-1, 1)),
    arrays(np.float64, (8, 3), elements=st.floats(-1, 1)),
)
def test_normals_within_reach_point_where_they_did(rest: np.ndarray, end: np.ndarray) -> None:
    rest, end = (
        np.where(np.linalg.norm(own, axis=1, keepdims=True) > 0.1, own, [0.0, 0.0, 1.0])
        for own in (rest, end)
    )
    rest /= np.linalg.norm(rest, axis=1, keepdims=True)
    end /= np.linalg.norm(end, axis=1, keepdims=True)
    found = within_reach(end - rest, rest)
    assert np.abs(found).max() <= 1 + 1e-12
    shown = rest + found
    # Of the same direction, however short; 0 only where a normal turns right round an axis.
    np.testing.assert_allclose(np.cross(shown, end), 0, atol=1e-12)
    assert (np.einsum("ni,ni->n", shown, end) >= -1e-12).all()
    near = np.abs(end - rest).max(axis=1) <= 1
    np.testing.assert_array_equal(found[near], (end - rest)[near])


def test_a_normal_that_turns_far_by_hand() -> None:
    """From x to −x tilted up: of (−0.8, 0, 0.6) only as much fits as keeps −1 ≤ δ."""
    found = within_reach(np.array([[-1.8, 0, 0.6]]), np.array([[1.0, 0, 0]]))
    np.testing.assert_allclose(found, [[-1.0, 0, 0.0]])
    found = within_reach(np.array([[-1.2, -0.6, 0]]), np.array([[0.6, 0.8, 0.0]]))
    np.testing.assert_allclose(found, [[-1.0, -0.8 + 0.4 / 0.6 * 0.2, 0]])
    np.testing.assert_array_equal(byte_normals(np.array([[1, -1, 0.5]])), [[127, -127, 64]])


def test_rows_are_filled_up_to_fours() -> None:
    rows = np.array([[1, 2, 3]], dtype="<i2")
    np.testing.assert_array_equal(padded(rows), [[1, 0, 2, 0, 3, 0, 0, 0]])


@pytest.mark.parametrize("normals", ["delta", "none"])
def test_the_validator_finds_no_error_and_no_warning(
    tmp_path: Path, node: str, normals: str
) -> None:
    paths = []
    flat = Rig(Mesh(np.eye(3)), {})
    for number, rig in enumerate([triangle_rig(), sheet(9, 4), Rig(seamed_mesh(), {}), flat]):
        paths.append(tmp_path / f"{number}.glb")
        write_glb(paths[-1], rig, normals=normals, compress=True)  # type: ignore[arg-type]
    output = validated(node, *paths)
    assert output.count("0 errors, 0 warnings") == len(paths)
    # It does not look into packed views, and takes their buffer for idle.
    known = ("UNSUPPORTED_EXTENSION", "UNUSED_OBJECT")
    remarks = [line for line in output.splitlines() if " errors, " not in line]
    assert all(any(code in line for code in known) for line in remarks)


@pytest.mark.parametrize("t", [0.0, 0.4, 1.0])
def test_three_draws_what_the_rig_poses(tmp_path: Path, node: str, t: float) -> None:
    rig = sheet(24, 6)
    report = write_glb(tmp_path / "a.glb", rig, compress=True)
    found = drawn(node, tmp_path / "a.glb", f"lift 3={t}", "lift 0=0.5")
    expected = rig.pose({"lift 3": t, "lift 0": 0.5})
    away = np.linalg.norm(found - expected, axis=1).max() / rig.neutral.diameter
    assert away <= 2 * report.rounding_error


def test_a_clip_plays_the_same_in_three(tmp_path: Path, node: str) -> None:
    rig = sheet(24, 6)
    report = write_glb(tmp_path / "a.glb", rig, compress=True, clips=True)
    found = drawn(node, tmp_path / "a.glb", "--clip", "lift 1", "--time", "0.5")
    away = np.linalg.norm(found - rig.pose({"lift 1": 0.5}), axis=1).max()
    assert away <= report.largest_error * rig.neutral.diameter


def test_the_file_is_a_fraction_of_the_plain_one(tmp_path: Path) -> None:
    rig = sheet(80, 20)
    plain = write_glb(tmp_path / "a.glb", rig)
    small = write_glb(tmp_path / "b.glb", rig, compress=True)
    assert small.bytes == (tmp_path / "b.glb").stat().st_size
    assert small.bytes < plain.bytes / 4
    assert set(small.parts) == set(plain.parts)
    assert sum(small.parts.values()) == pytest.approx(small.bytes, abs=40)


def test_what_little_is_left_of_many_small_targets_is_read(tmp_path: Path) -> None:
    """Each moves one vertex in twenty: a quarter of a byte a vertex, but memory for all of them."""
    mesh = sheet(170, 0).neutral
    shape = mesh.vertices.shape
    morphs = {}
    for number in range(60):
        moved = mesh.vertices.copy()
        moved[450 * number : 450 * number + 1445, 2] += np.sin(np.arange(1445)) / 20
        morphs[str(number)] = Morph(mesh, mesh.with_vertices(moved), np.zeros((0, *shape)), ())
    report = write_glb(tmp_path / "a.glb", Rig(mesh, morphs), normals="none", compress=True)
    assert report.bytes < 1_000_000
    back = read_glb(tmp_path / "a.glb")
    assert len(back.morphs) == 60


def test_the_same_rig_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.glb", "b.glb"):
        write_glb(tmp_path / name, sheet(12, 3), compress=True)
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_the_missing_package_says_how_to_install_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "meshopt", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'elastomorph\[gltf\]'"):
        write_glb(tmp_path / "a.glb", triangle_rig(), compress=True)
    assert not list(tmp_path.iterdir())
