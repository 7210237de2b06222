"""A neutral without shapes, as a GLB, USD or FBX file, goes wherever a mesh file goes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from elastomorph.capturing.scans.registered_files import read_face
from fbx_samples import Model, as_binary, scene
from needs import installed
from small_meshes import grid

installed("pxr", "usd")
installed("ufbx", "fbx")

NEUTRALS = [
    "neutral.glb",
    "neutral.vrm",
    "neutral.usda",
    "neutral.usdc",
    "neutral.usdz",
    "neutral.npz",
    "neutral.fbx",
]


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
    em.write("neutral.npz", em.Rig(neutral, {}))
    polygons = [polygon.tolist() for polygon in neutral.faces]
    model = Model("face", neutral.vertices.tolist(), polygons)
    Path("neutral.fbx").write_bytes(as_binary(scene(model)))
    em.write("rig.glb", em.Rig(neutral, {"up": em.interpolate(neutral, raised, "linear")}))
    return tmp_path


@pytest.mark.parametrize("kind", ["glb", "usda", "none.usda"])
def test_shapes_that_move_nothing_are_not_bent(kind: str) -> None:
    """One sentence about the file, whatever its format."""
    neutral = grid(7, 6)
    still = {} if kind == "none.usda" else {"up": em.interpolate(neutral, neutral, "linear")}
    em.write(f"still.{kind}", em.Rig(neutral, still))
    with pytest.raises(em.FormatError, match=r"still\..*so there is nothing to bend; export it"):
        em.bend(f"still.{kind}", f"bent.{kind}")


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
        assert run("inspect", name, "target.obj", "--json") == 0
        assert json.loads(capsys.readouterr().out)["targets"]["target.obj"]["moved"] == 42
        assert run("curves", name, "-o", "curves.json") == 0
        assert run("doctor", name, "target.obj") == 0

    def test_as_a_template(self, name: str) -> None:
        """As `register` and `capture` read it."""
        np.testing.assert_array_equal(read_face(name).mesh.vertices, grid(7, 6).vertices)

    @pytest.mark.parametrize("door", ["folder", "settings"])
    def test_beside_its_targets(self, name: str, door: str) -> None:
        """A folder, and settings, with targets in other files."""
        place = Path("character")
        place.mkdir()
        for file in (name, "target.obj"):
            (place / file).write_bytes(Path(file).read_bytes())
        if door == "settings":
            (place / "elastomorph.toml").write_text(f'[character]\nneutral = "{name}"\n')
        assert run("export", str(place), "-o", "made.glb") == 0
        made = em.read_rig("made.glb")
        np.testing.assert_array_equal(made.neutral.vertices, grid(7, 6).vertices)
        assert list(made.morphs) == ["target"]

    def test_without_sliders_there_is_nothing_to_move(
        self, name: str, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert run("blend", name, "-w", "up=1", "-o", "face.obj") == 1
        said = capsys.readouterr().err
        assert "there are none" in said or "no mesh has blend shapes" in said


def test_a_rig_is_no_neutral() -> None:
    with pytest.raises(em.FormatError, match="targets: 1"):
        em.read("rig.glb")


def test_a_rig_is_asked_for_its_shapes() -> None:
    """Who reads a rig without any is told what to switch on."""
    with pytest.raises(em.FormatError, match="no mesh has blend shapes"):
        em.read_rig("neutral.usda")
