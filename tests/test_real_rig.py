"""The methods on a production rig: 26,719 vertices, 57 targets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.evaluation.rigid_bodies import find_rigid_parts
from elastomorph.evaluation.shape import ShapeProbe, closure_seams

METHODS = ("linear", "ease:2", "beam:1", "beam:2", "beam:3")
pytestmark = pytest.mark.realdata


@pytest.fixture(scope="module")
def rig(data_dir: Path) -> Path:
    return data_dir / "ict-facekit"


@pytest.fixture(scope="module")
def neutral(rig: Path) -> em.Mesh:
    return em.read(rig / "generic_neutral_mesh.obj")


@pytest.fixture(scope="module")
def jaw(rig: Path) -> em.Mesh:
    return em.read(rig / "jawOpen.obj")


@pytest.fixture(scope="module")
def curves(neutral: em.Mesh) -> em.CurveNetwork:
    return em.extract_curves(neutral)


@pytest.mark.slow
def test_every_target_by_every_method(rig: Path, neutral: em.Mesh, curves: em.CurveNetwork) -> None:
    """Exact ends, finite in-betweens, and no vertex that Δ leaves alone is moved far."""
    prepared = {method: em.prepare(neutral, method, curves=curves) for method in METHODS}
    files = sorted(set(rig.glob("*.obj")) - {rig / "generic_neutral_mesh.obj"})
    assert len(files) == 57
    for file in files:
        target = em.read(file)
        for method, to in prepared.items():
            path = to(target)
            ends = path.at([0, 0.5, 1])
            assert ends[0].tobytes() == neutral.vertices.tobytes(), (file.name, method)
            assert ends[2].tobytes() == target.vertices.tobytes(), (file.name, method)
            assert np.isfinite(ends[1]).all()
            limit = neutral.vertices + (0.5 + path.limit_law(0.5)) * path.delta
            away = np.linalg.norm(ends[1] - limit, axis=1).max()
            assert away < 2e-3 * neutral.diameter, (file.name, method)


def test_the_mean_decides_whether_the_face_tears(
    neutral: em.Mesh, jaw: em.Mesh, curves: em.CurveNetwork
) -> None:
    """Halfway to jawOpen the limit closure is whole; unforced tears lips and forehead."""
    seams = {seam.closure: seam.shape for seam in closure_seams(neutral, jaw, curves)}
    assert seams["limit"].seam < 5e-4
    assert seams["limit"].flips == 0
    assert seams["unforced"].seam > 0.02
    assert seams["unforced"].flips > 20
    assert seams["limit"].seam == min(shape.seam for shape in seams.values())


def test_the_jaw_turns_about_its_joint(neutral: em.Mesh, jaw: em.Mesh) -> None:
    """2,204 vertices of teeth, 25.3° about +X through (0, -0.55, 1.82); linear is 0.67 % off."""
    parts = find_rigid_parts(neutral, jaw)
    assert parts is not None
    assert len(parts.vertices) == 2204
    assert np.degrees(parts.screw.angle) == pytest.approx(25.3, abs=0.1)
    np.testing.assert_allclose(parts.screw.axis, [1, 0, 0], atol=1e-3)
    np.testing.assert_allclose(parts.screw.centre[1:], [-0.55, 1.82], atol=0.01)
    assert parts.residual * neutral.diameter <= 0.023
    halfway = em.interpolate(neutral, jaw, "linear").at(0.5)[parts.vertices]
    off = np.linalg.norm(halfway - parts.truth.frames[5], axis=1).max() / neutral.diameter
    assert off == pytest.approx(0.0067, abs=0.0004)


@pytest.mark.slow
def test_rotation_turns_no_polygon_over(rig: Path, neutral: em.Mesh) -> None:
    """Of no target, at a quarter, a half and three quarters, against both its ends."""
    to = em.prepare(neutral, "rotation")
    none = np.zeros(len(neutral.vertices), dtype=int)
    for file in sorted(set(rig.glob("*.obj")) - {rig / "generic_neutral_mesh.obj"}):
        path = to(em.read(file))
        probe = ShapeProbe.of(neutral, path.target, none)
        assert path.bake_error <= 1e-4, file.name
        if file.stem != "mouthClose":  # a corrective, meaningless without jawOpen
            flips = [probe.flips(path.at(t)) for t in (0.25, 0.5, 0.75)]
            assert flips == [0, 0, 0], file.name


def test_rotation_swings_the_jaw_about_its_joint(neutral: em.Mesh, jaw: em.Mesh) -> None:
    """Teeth within 0.08 %, gums within 0.25 % of D of the true hinge; linear is off by 0.67 %."""
    parts = find_rigid_parts(neutral, jaw)
    assert parts is not None
    screw, mouth = parts.screw, np.arange(14062, 17039)
    residual = np.linalg.norm(screw.at(1.0, neutral.vertices[mouth]) - jaw.vertices[mouth], axis=1)
    gums = mouth[residual <= 0.023]
    assert len(gums) > 1600
    path = em.interpolate(neutral, jaw, "rotation")
    for t in (0.25, 0.5, 0.75):
        here = path.at(t)
        for body, allowed in ((parts.vertices, 0.0008), (gums, 0.0025)):
            away = here[body] - screw.at(t, neutral.vertices[body])
            assert np.linalg.norm(away, axis=1).max() <= allowed * neutral.diameter
