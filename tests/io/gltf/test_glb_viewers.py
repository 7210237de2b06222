"""Others agree: the Khronos validator finds no fault, and three.js draws what the rig poses.

Needs Node.js and the packages of ``web``: run ``npm ci`` in that folder.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from glb_samples import SHARED_VERTICES, HandMade, rigs, seamed_mesh, triangle_rig
from hypothesis import HealthCheck, given, settings
from viewer_checks import drawn, run, validated

from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.bake import bake
from elastomorph.rig import Rig


def jaw_rig() -> Rig:
    """Three targets on a mesh with seams: a turn with baked bends, a spline, a straight one."""
    mesh = seamed_mesh()

    def turned(t: float) -> np.ndarray:
        cos, sin = np.cos(0.8 * t), np.sin(0.8 * t)
        return np.asarray(mesh.vertices @ np.array([[1, 0, 0], [0, cos, sin], [0, -sin, cos]]))

    jaw = bake(turned, mesh, mesh.with_vertices(turned(1)), tolerance=1e-6)
    spline = BendCurve([0, 0.5, 1], [[0, 3, 0, -4], [1, 0, -6, 4]])
    up = mesh.with_vertices(mesh.vertices + [0, 0, 0.3])
    brow = Morph(mesh, up, np.sin(mesh.vertices)[None] / 5, (spline,))
    straight = Morph(mesh, up, np.zeros((0, *mesh.vertices.shape)), ())
    return Rig(
        mesh,
        {"jaw": jaw, "brow": brow, "both = 1": straight},
        correctives={"both = 1": ["jaw", "brow"]},
    )


def test_the_validator_finds_no_error_and_no_warning(tmp_path: Path, node: str) -> None:
    paths = []
    for name, rig in {
        "triangle": triangle_rig(),
        "jaw": jaw_rig(),
        "no targets": Rig(seamed_mesh(), {}),
        "markers": Rig(Mesh(np.eye(3)), {}),
        "again": None,
    }.items():
        paths.append(tmp_path / f"{name}.glb")
        write_glb(paths[-1], rig or read_glb(tmp_path / "jaw.glb"), clips=True)
    for normals in ("delta", "none"):
        for sparse in (True, False):
            paths.append(tmp_path / f"{normals} {sparse}.glb")
            write_glb(paths[-1], jaw_rig(), normals=normals, sparse=sparse)
    paths.append(tmp_path / "take.glb")
    write_glb(paths[-1], jaw_rig(), animation=([0, 1], [[0, 0], [1, 0.5]], "take"))
    output = validated(node, *paths)
    assert output.count("0 errors, 0 warnings") == len(paths)
    # Texture coordinates wait for a texture; nothing else is remarked on.
    remarks = [line for line in output.splitlines() if " errors, " not in line]
    assert all("UNUSED_OBJECT" in line and "TEXCOORD_0" in line for line in remarks)


@given(rig=rigs())
@settings(
    max_examples=12,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
def test_the_validator_finds_no_error_in_any_rig(tmp_path: Path, node: str, rig: Rig) -> None:
    write_glb(tmp_path / "any.glb", rig)
    validated(node, tmp_path / "any.glb")


def test_the_validator_does_find_errors(tmp_path: Path, node: str) -> None:
    file = HandMade()
    file.primitive(attributes={"POSITION": file.array(np.eye(3))}, material=3)
    done = run(node, "validate.mjs", file.write(tmp_path / "bad.glb"))
    assert done.returncode == 1
    assert "UNRESOLVED_REFERENCE" in done.stdout


@pytest.mark.parametrize("t", [0.3, 0.317, 0.9, 1.0, 1.2, -0.2])
def test_three_poses_the_face_from_the_curves_in_the_extras(
    tmp_path: Path, node: str, t: float
) -> None:
    rig = jaw_rig()
    write_glb(tmp_path / "a.glb", rig)
    found = drawn(node, tmp_path / "a.glb", f"jaw={t}", f"brow={t / 2}", f"both = 1={t * t / 2}")
    expected = rig.pose({"jaw": t, "brow": t / 2})
    count = len(expected)
    away = np.linalg.norm(found[:count] - expected, axis=1).max()
    assert away < 1e-5 * 2 * rig.neutral.diameter
    np.testing.assert_array_equal(found[count:], found[[1, 2]])  # the copies along the seam


@pytest.mark.parametrize("seconds", [0.0, 0.3, 0.317, 0.7])
@pytest.mark.parametrize("name", ["jaw", "brow"])
def test_three_plays_the_animation_of_a_slider(
    tmp_path: Path, node: str, name: str, seconds: float
) -> None:
    rig = jaw_rig()
    report = write_glb(tmp_path / "a.glb", rig, keys_tolerance=5e-6, tolerance=1e-6, clips=True)
    found = drawn(node, tmp_path / "a.glb", "--clip", name, "--time", str(seconds))
    expected = rig.pose({name: seconds})
    away = np.linalg.norm(found[: len(expected)] - expected, axis=1).max()
    assert away < 1e-5 * rig.neutral.diameter
    assert report.largest_error < 1e-5


def test_players_hold_the_targets_of_a_material_for_its_own_vertices(
    tmp_path: Path, node: str
) -> None:
    """As three.js does it: 16 bytes a vertex and target, twice that with normals."""
    mesh = seamed_mesh()
    up = np.zeros((7, 3))
    up[6] = [0, 1, 0]
    morph = Morph(mesh, mesh.with_vertices(mesh.vertices + up), np.zeros((0, 7, 3)), ())
    path = tmp_path / "a.glb"
    write_glb(path, Rig(mesh, {"corner": morph}))
    told = json.loads(run(node, "morph_textures.mjs", path, SHARED_VERTICES).stdout)
    # "skin", 4 vertices, is lit otherwise; the last polygon, 3 vertices, moves; "teeth" do neither.
    assert told[str(path)] == (4 + 3) * 2 * 16
    assert told[str(SHARED_VERTICES)] == 3 * 9 * 2 * 3 * 16


def test_three_plays_a_performance(tmp_path: Path, node: str) -> None:
    rig = jaw_rig()
    weights = [[0.1, 0.9], [0.5, 0.2], [1.1, 0.4]]
    write_glb(tmp_path / "a.glb", rig, animation=([0, 0.5, 1], weights, "take"), tolerance=1e-6)
    found = drawn(node, tmp_path / "a.glb", "--clip", "take", "--time", "0.5")
    expected = rig.pose({"jaw": 0.5, "brow": 0.2})
    away = np.linalg.norm(found[: len(expected)] - expected, axis=1).max()
    assert away < 1e-5 * rig.neutral.diameter
