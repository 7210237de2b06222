"""A neutral without shapes, as a GLB or a USD file, goes wherever a mesh file goes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from needs import installed
from small_meshes import grid

installed("pxr", "usd")

NEUTRALS = ["neutral.glb", "neutral.vrm", "neutral.usda", "neutral.usdc", "neutral.usdz"]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with one neutral in every format, a target, and a rig with that target."""
    from pxr import UsdUtils

    monkeypatch.chdir(tmp_path)
    neutral = grid(7, 6)
    raised = neutral.with_vertices(neutral.vertices + [0, 0, 3.0])
    em.write("target.obj", raised)
    em.write("neutral.glb", em.Rig(neutral, {}))
    Path("neutral.vrm").write_bytes(Path("neutral.glb").read_bytes())
    points = ", ".join(str(tuple(own)) for own in neutral.vertices.tolist())
    counts = np.diff(neutral.faces.offsets).tolist()
    Path("neutral.usda").write_text(
        '#usda 1.0\n( upAxis = "Y" )\ndef Mesh "face"\n{\n'
        f"    point3f[] points = [{points}]\n    int[] faceVertexCounts = {counts}\n"
        f"    int[] faceVertexIndices = {neutral.faces.indices.tolist()}\n}}\n"
    )
    from pxr import Sdf

    Sdf.Layer.FindOrOpen("neutral.usda").Export("neutral.usdc")
    assert UsdUtils.CreateNewUsdzPackage("neutral.usdc", "neutral.usdz")
    em.write("rig.glb", em.Rig(neutral, {"up": em.interpolate(neutral, raised, "linear")}))
    return tmp_path


@pytest.mark.parametrize("name", NEUTRALS)
class TestNeutrals:
    """Whatever the format, the neutral is the same mesh."""

    def test_by_read(self, name: str) -> None:
        mesh, expected = em.read(name), grid(7, 6)
        np.testing.assert_array_equal(mesh.vertices, expected.vertices)
        np.testing.assert_array_equal(mesh.faces.indices, expected.faces.indices)

    def test_by_verbs(self, name: str, capsys: pytest.CaptureFixture[str]) -> None:
        assert run("interpolate", name, "target.obj", "--method", "linear", "-o", "half.obj") == 0
        expected = grid(7, 6).vertices + [0, 0, 1.5]
        np.testing.assert_allclose(em.read("half.obj").vertices, expected, atol=1e-12)
        capsys.readouterr()
        assert run("inspect", name, "--json") == 0
        assert json.loads(capsys.readouterr().out)["vertices"] == 42
        assert run("curves", name, "-o", "curves.json") == 0


def test_a_rig_is_no_neutral() -> None:
    with pytest.raises(em.FormatError, match="targets: 1"):
        em.read("rig.glb")


def test_a_rig_is_asked_for_its_shapes() -> None:
    """Who reads a rig without any is told what to switch on."""
    with pytest.raises(em.FormatError, match="no mesh has blend shapes"):
        em.read_rig("neutral.usda")
