"""Scenes hold what they were given, and only what can be shown together."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.io.gltf import write_glb
from elastomorph.io.gltf.clips import read_weight_clips
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn
from elastomorph.viewer import Scene, SceneModel, comparison_scene, rig_scene
from elastomorph.viewer.file_scenes import read_scene
from elastomorph.viewer.scene import ROLES, START

TYPES = Path(__file__).parents[2] / "web" / "viewer" / "types"


@pytest.fixture(scope="module")
def model(rig: Rig) -> SceneModel:
    return rig_scene(rig).models[0]


def test_a_rig_comes_with_its_size_and_curves(rig: Rig) -> None:
    scene = rig_scene(rig, name="tip", unit="cm")
    stored = json.loads(scene.to_json(["tip.glb"]))
    assert stored["title"] == "tip"
    assert stored["models"] == [{"name": "tip", "role": "rig", "glb": "tip.glb"}]
    assert stored["unit"] == "cm"
    assert stored["diameter"] == pytest.approx(np.sqrt(2))
    expected = [c for c in em.extract_curves(rig.neutral) if len(c) > 1]
    assert [loop["vertices"] for loop in stored["loops"]] == [c.vertices.tolist() for c in expected]
    assert [loop["closed"] for loop in stored["loops"]] == [c.closed for c in expected]
    assert "start" not in stored


@pytest.mark.parametrize(("compress", "methods"), [(False, ["linear"]), (True, [])])
def test_files_that_are_made_anew_turn_the_head(
    rig: Rig, tmp_path: Path, compress: bool, methods: list[str]
) -> None:
    """In those clips that turn it, about the neck of the file: with other paths, or unpacked."""
    angles = np.array([[0.1, 0.2, -0.3], [0.5, 0.0, 0.2]])
    weights, neck = np.ones((2, len(rig.names))), np.array([0.1, -0.2, 0.3])
    both = [([0, 1], weights, "still"), ([0, 1], weights, "turned")]
    turn = HeadTurn(neck, np.concatenate([0 * angles, angles]))
    write_glb(tmp_path / "a.glb", rig, animation=both, turn=turn, compress=compress)
    (model,) = read_scene([str(tmp_path / "a.glb")], methods).models
    (tmp_path / "b.glb").write_bytes(model.glb)
    still, turned = read_weight_clips(tmp_path / "b.glb", rig.sliders)
    assert still.turn is None
    assert turned.turn is not None
    np.testing.assert_allclose(turned.turn.angles, angles, atol=1e-6)
    np.testing.assert_allclose(turned.turn.pivot, neck, atol=1e-6)


def test_curves_of_the_caller_are_drawn(rig: Rig) -> None:
    curves = em.CurveNetwork([em.Curve([0, 1, 2], closed=True), em.Curve([3])], 4)
    stored = json.loads(rig_scene(rig, curves=curves).to_json(["x"]))
    assert stored["loops"] == [{"closed": True, "vertices": [0, 1, 2]}]


def test_vertices_in_the_file_are_counted_with_copies_at_seams() -> None:
    """Two triangles whose texture is cut along their common edge: four vertices become six."""
    from elastomorph.model.mesh import UVMap

    uv = UVMap(np.random.default_rng(1).random((6, 2)), np.arange(6, dtype=np.int32))
    mesh = em.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], uv=uv)
    assert rig_scene(Rig(mesh, {})).models[0].vertices == 6


def test_methods_share_one_slider(curved: em.Morph, straight: em.Morph) -> None:
    scene = comparison_scene({"line": straight, "arc": curved})
    assert [(m.name, m.role) for m in scene.models] == [("line", "method"), ("arc", "method")]
    assert scene.start["weights"] == {"motion": 1.0}
    assert scene.start["arrangement"] == "side"
    assert scene.start["shown"] == [0, 1]


def test_no_more_than_three_stand_side_by_side(rig: Rig) -> None:
    scene = comparison_scene({f"copy {i}": rig for i in range(5)})
    assert len(scene.models) == 5
    assert scene.start["shown"] == [0, 1, 2]


def test_what_cannot_be_compared(rig: Rig, curved: em.Morph) -> None:
    other = rig.neutral.with_vertices(rig.neutral.vertices)
    other = em.Mesh(other.vertices, [[0, 1, 2]])
    with pytest.raises(em.TopologyError):
        comparison_scene({"a": rig, "b": Rig(other, {})})
    with pytest.raises(em.ParameterError, match="rigs with rigs"):
        comparison_scene({"a": rig, "b": curved})
    with pytest.raises(em.ParameterError, match="at least one"):
        comparison_scene({})


def test_files_of_different_faces_are_not_compared(model: SceneModel) -> None:
    triangle = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    other = rig_scene(Rig(triangle, {})).models[0]
    with pytest.raises(em.ParameterError, match=r"3 vertices.*4"):
        Scene((model, other), "two faces")


def test_points_without_polygons_are_refused() -> None:
    """A marker take has nothing to shade; the message says what shows it instead."""
    with pytest.raises(em.ParameterError, match=r"no polygons.*elastomorph evaluate"):
        rig_scene(Rig(em.Mesh(np.eye(3)), {}))


@given(st.binary(max_size=200))
def test_anything_but_a_glb_is_refused(content: bytes) -> None:
    for start in (b"", b"glTF\x02\x00\x00\x00"):
        with pytest.raises(em.ParameterError, match="no GLB"):
            SceneModel("x", "rig", start + content)


def test_a_cut_glb_is_refused_wherever_its_document_ends_early(model: SceneModel) -> None:
    length = int.from_bytes(model.glb[12:16], "little")
    for end in range(0, 20 + length - 4, 7):
        with pytest.raises(em.ParameterError, match="no GLB"):
            SceneModel("x", "rig", model.glb[:end])


@pytest.mark.parametrize(
    ("start", "message"),
    [({"wieghts": {}}, "wieghts"), ({"t": float("nan")}, "JSON"), ({"t": {1}}, "JSON")],
)
def test_a_start_that_no_page_understands(
    model: SceneModel, start: dict[str, object], message: str
) -> None:
    with pytest.raises(em.ParameterError, match=message):
        Scene((model,), "x", start=start).to_json(["x"])


def test_a_scene_needs_models_with_known_roles(model: SceneModel) -> None:
    with pytest.raises(em.ParameterError, match="at least one"):
        Scene((), "nothing")
    with pytest.raises(em.ParameterError, match="role"):
        SceneModel("x", "hero", model.glb)  # type: ignore[arg-type]


def test_the_page_knows_the_same_roles_and_state() -> None:
    """The page's source and the package name the same things."""
    if not TYPES.is_dir():
        pytest.skip("the page's source is not here, only the installed package")
    state = (TYPES / "state.ts").read_text().partition("interface ViewState {")[2]
    names = re.findall(r"^  readonly (\w+):", state, re.MULTILINE)
    assert sorted(START) == sorted(names)
    roles = re.search(r"readonly role: ([^;]+);", (TYPES / "model.ts").read_text())
    assert roles is not None
    assert sorted(ROLES) == sorted(re.findall(r"'(\w+)'", roles[1]))
