"""A production rig through glTF: sizes, exactness, and normals between the ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from viewer_checks import drawn, validated

import elastomorph as em
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.io.gltf.morph_targets import NormalField, normal_deltas

pytestmark = pytest.mark.realdata
TARGETS = ("jawOpen", "mouthSmile_L", "eyeBlink_R", "cheekPuff_L")


@pytest.fixture(scope="module")
def neutral(data_dir: Path) -> em.Mesh:
    return em.read(data_dir / "ict-facekit" / "generic_neutral_mesh.obj")


@pytest.fixture(scope="module", params=["linear", "beam:2"])
def rig(request: pytest.FixtureRequest, data_dir: Path, neutral: em.Mesh) -> em.Rig:
    to = em.prepare(neutral, request.param)
    folder = data_dir / "ict-facekit"
    return em.Rig(neutral, {name: to(em.read(folder / f"{name}.obj")) for name in TARGETS})


def test_polygons_seams_and_materials_come_back(tmp_path: Path, rig: em.Rig) -> None:
    report = write_glb(tmp_path / "a.glb", rig, tolerance=0)
    back = read_glb(tmp_path / "a.glb")
    mesh = rig.neutral
    assert back.neutral.faces == mesh.faces
    assert mesh.uv is not None
    assert back.neutral.uv is not None
    assert back.neutral.uv.coordinates.tobytes() == mesh.uv.coordinates.tobytes()
    assert np.array_equal(back.neutral.uv.corners, mesh.uv.corners)
    assert mesh.materials is not None
    assert back.neutral.materials is not None
    assert back.neutral.materials.names == mesh.materials.names
    assert np.array_equal(back.neutral.materials.of_face, mesh.materials.of_face)
    for name in TARGETS:
        away = np.abs(back.pose({name: 0.4}) - rig.pose({name: 0.4})).max()
        assert away < 1e-6 * mesh.diameter
    assert report.rounding_error < 1e-7


def test_leaving_out_what_hardly_moves_makes_the_file_smaller(tmp_path: Path, rig: em.Rig) -> None:
    """And no face differs by more than the report says."""
    whole = write_glb(tmp_path / "whole.glb", rig, normals="none", tolerance=0)
    report = write_glb(tmp_path / "a.glb", rig, normals="none", tolerance=1e-5)
    assert report.dropped_error <= 1.1e-5
    if report.bends:
        # Materials that a target leaves where they are cost nothing in either file.
        assert report.parts["positions"] < 0.72 * whole.parts["positions"]
    back = read_glb(tmp_path / "a.glb")
    for name in TARGETS:
        away = np.linalg.norm(back.pose({name: 0.5}) - rig.pose({name: 0.5}), axis=1).max()
        assert away <= (report.dropped_error + report.rounding_error) * rig.neutral.diameter


def test_viewers_agree(tmp_path: Path, rig: em.Rig, node: str) -> None:
    path = tmp_path / "a.glb"
    report = write_glb(path, rig, clips=True)
    validated(node, path)
    expected = rig.pose({"jawOpen": 0.31})
    for arguments, allowed in (
        (["jawOpen=0.31"], 1e-6),
        (["--clip", "jawOpen", "--time", "0.31"], report.largest_error + 2e-7),
    ):
        found = drawn(node, path, *arguments)[: len(expected)]
        away = np.linalg.norm(found - expected, axis=1).max()
        assert away <= allowed * rig.neutral.diameter


def degrees(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    one = one / np.linalg.norm(one, axis=1, keepdims=True)
    return np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(one - other, axis=1) / 2, 0, 1)))


def test_normals_in_between(neutral: em.Mesh, rig: em.Rig) -> None:
    """Mean error over moved vertices of jawOpen: linear 0.7°, bent 0.25°; unturned 0.7 to 7.4°.

    Without normals for its bends a bent path would be 1.7 to 2.4° off, so they are written.
    """
    morph = rig.morphs["jawOpen"]
    field = NormalField.of(neutral.faces)
    at_rest = field.normals(neutral.vertices)
    deltas = normal_deltas(field, morph, range(len(morph.bends)), at_rest)
    moved = np.linalg.norm(morph.delta, axis=1) > 1e-3
    for t in (0.25, 0.5, 0.75):
        true = field.normals(morph.at(t))[moved]
        weights = np.array([t, *(float(curve(t)) for curve in morph.bend_curves)])
        full = degrees((at_rest + np.tensordot(weights, deltas, axes=1))[moved], true)
        plain = degrees((at_rest + t * deltas[0])[moved], true)
        assert full.mean() < (0.25 if len(morph.bends) else 0.7)
        assert np.quantile(full, 0.95) < (0.8 if len(morph.bends) else 2.1)
        if len(morph.bends):
            assert plain.mean() > 1.7


def test_by_default_faces_come_back_within_a_millionth(tmp_path: Path, rig: em.Rig) -> None:
    """Written and read, every target posed anywhere within 1e-6 of D."""
    write_glb(tmp_path / "a.glb", rig)
    back = read_glb(tmp_path / "a.glb")
    for name in TARGETS:
        for t in (0.25, 0.6, 1.0):
            away = np.linalg.norm(back.pose({name: t}) - rig.pose({name: t}), axis=1).max()
            assert away < 1e-6 * rig.neutral.diameter


def test_compressed_files_keep_polygons_and_stay_within_the_error(
    tmp_path: Path, rig: em.Rig, node: str
) -> None:
    report = write_glb(tmp_path / "a.glb", rig, compress=True)
    assert report.rounding_error <= 1.002e-4
    back = read_glb(tmp_path / "a.glb")
    assert back.neutral.faces == rig.neutral.faces
    assert back.neutral.uv is not None
    assert rig.neutral.uv is not None
    assert back.neutral.uv.coordinates.tobytes() == rig.neutral.uv.coordinates.tobytes()
    allowed = (report.rounding_error + report.dropped_error) * rig.neutral.diameter
    for name in TARGETS:
        for t in (0.0, 0.4, 1.0):
            away = np.linalg.norm(back.pose({name: t}) - rig.pose({name: t}), axis=1).max()
            assert away <= 1.001 * allowed
    validated(node, tmp_path / "a.glb")
    found = drawn(node, tmp_path / "a.glb", "jawOpen=0.4")[: len(rig.neutral.vertices)]
    away = np.linalg.norm(found - rig.pose({"jawOpen": 0.4}), axis=1).max()
    assert away <= 1.01 * allowed


@pytest.mark.slow
def test_bends_add_two_fifths_and_compressing_leaves_a_sixth(
    data_dir: Path, tmp_path: Path
) -> None:
    """All 57 targets and pair bends: at most 1.4 times the straight file; compressed 4 MiB."""
    sizes = {}
    for method in ("linear", "auto"):
        rig = em.read_rig(data_dir / "ict-facekit", method=method)
        sizes[method] = write_glb(tmp_path / "a.glb", rig).bytes
    assert sizes["auto"] <= 1.4 * sizes["linear"]
    report = write_glb(tmp_path / "b.glb", rig, compress=True)
    assert report.bytes <= 4 * 2**20
    assert report.rounding_error + report.dropped_error <= 1e-4
    assert report.parts["normals"] > 0
