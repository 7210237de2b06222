"""A rig comes back from USD as it was: paths, polygons, labels, sliders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from usd_rigs import (
    assert_same_paths,
    curved,
    grid,
    posed_by_usd,
    read_in_this_process,
    rigs,
    sample_rig,
)

from elastomorph.errors import ElastomorphWarning
from elastomorph.io.usd import read_usd, write_usd
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.bake import bake
from elastomorph.rig import Rig
from needs import extra

extra("pxr", "usd")


def assert_same_rig(one: Rig, other: Rig) -> None:
    assert list(one.morphs) == list(other.morphs)
    assert one.names == other.names
    assert dict(one.sliders.correctives) == dict(other.sliders.correctives)
    assert dict(one.sliders.groups) == dict(other.sliders.groups)
    assert one.neutral.faces == other.neutral.faces
    size = one.neutral.diameter or 1.0
    assert np.abs(one.neutral.vertices - other.neutral.vertices).max() <= 1e-7 * size
    for name, morph in one.morphs.items():
        found = other.morphs[name]
        assert_same_paths(morph, found)
        assert (found.method, found.bake_error) == (morph.method, morph.bake_error)
        for own, theirs in zip(morph.bend_curves, found.bend_curves, strict=True):
            assert own.coefficients.tobytes() == theirs.coefficients.tobytes()


@pytest.mark.parametrize("suffix", ["usd", "usda", "usdc"])
def test_a_rig_comes_back_as_it_was(tmp_path: Path, suffix: str) -> None:
    rig, path = sample_rig(), tmp_path / f"face.{suffix}"
    write_usd(path, rig)
    found = read_usd(path)
    assert_same_rig(rig, found)
    one, other = rig.neutral, found.neutral
    assert other.source is not None
    assert other.source.path == str(path)
    assert one.material_library == other.material_library
    for mine, theirs in ((one.materials, other.materials), (one.groups, other.groups)):
        assert mine.names == theirs.names
        np.testing.assert_array_equal(mine.of_face, theirs.of_face)
    np.testing.assert_array_equal(one.uv.corners, other.uv.corners)
    np.testing.assert_allclose(one.uv.coordinates, other.uv.coordinates, rtol=1e-7)


@given(rig=rigs())
@settings(max_examples=60, deadline=None)
def test_any_rig_comes_back(tmp_path_factory: pytest.TempPathFactory, rig: Rig) -> None:
    folder = tmp_path_factory.getbasetemp()
    write_usd(folder / "any.usdc", rig)
    assert_same_rig(rig, read_in_this_process(folder / "any.usdc", folder))


def test_a_face_far_from_the_origin_keeps_its_shape(tmp_path: Path) -> None:
    """Float32 has steps of 0.06 at a million; the exact points are stored beside."""
    mesh = grid().with_vertices(grid().vertices + [1e6, 0, -2e6])
    rig = Rig(mesh, {"a": curved(mesh, 0, slice(0, 5))})
    write_usd(tmp_path / "far.usdc", rig)
    found = read_in_this_process(tmp_path / "far.usdc", tmp_path)
    np.testing.assert_array_equal(found.neutral.vertices, mesh.vertices)
    assert_same_rig(rig, found)


def test_bends_that_cancel_each_other_are_stored_in_double(tmp_path: Path) -> None:
    """A whole turn takes nine powers whose bends are far larger than the path."""
    from pxr import Usd

    mesh = grid()

    def turning(t: float) -> np.ndarray:
        angle = 2 * np.pi * t
        rotation = np.array(
            [[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
        )
        return mesh.vertices @ rotation

    morph = bake(turning, mesh, mesh.with_vertices(turning(1.0)), tolerance=1e-6)
    assert np.abs(morph.bends).max() > 20 * mesh.diameter
    write_usd(tmp_path / "turn.usdc", Rig(mesh, {"turn": morph}))
    stage = Usd.Stage.Open(str(tmp_path / "turn.usdc"))
    bends = stage.GetAttributeAtPath("/Face/Mesh/turn.elastomorph:bends")
    assert bends.GetTypeName() == "vector3d[]"
    found = read_in_this_process(tmp_path / "turn.usdc", tmp_path)
    assert_same_paths(morph, found.morphs["turn"])


def test_a_rig_without_morphs_and_points_without_polygons(tmp_path: Path) -> None:
    for vertices in ([[0.0, 0, 0]], [[0.0, 0, 0], [1, 2, 3]]):
        write_usd(tmp_path / "a.usda", Rig(Mesh(vertices), {}))
        found = read_in_this_process(tmp_path / "a.usda", tmp_path)
        assert len(found) == 0
        assert found.neutral.vertices.tolist() == vertices


def test_writing_what_was_read_changes_nothing(tmp_path: Path) -> None:
    write_usd(tmp_path / "one.usda", sample_rig())
    write_usd(tmp_path / "two.usda", read_in_this_process(tmp_path / "one.usda", tmp_path))
    third = read_in_this_process(tmp_path / "two.usda", tmp_path)
    write_usd(tmp_path / "three.usda", third)
    assert_same_rig(sample_rig(), third)
    assert (tmp_path / "two.usda").read_bytes() == (tmp_path / "three.usda").read_bytes()


def test_a_shape_that_another_program_changed_is_read_as_it_is_now(tmp_path: Path) -> None:
    from pxr import Usd, UsdSkel

    path, rig = tmp_path / "changed.usda", sample_rig()
    write_usd(path, rig)
    stage = Usd.Stage.Open(str(path))
    shape = UsdSkel.BlendShape(stage.GetPrimAtPath("/Face/Mesh/smile"))
    offsets = np.array(shape.GetOffsetsAttr().Get())
    offsets[4] += (0, 0.5, 0)
    shape.GetOffsetsAttr().Set(offsets)
    stage.Save()
    with pytest.warns(ElastomorphWarning, match="'smile' was changed since"):
        found = read_in_this_process(path, tmp_path)
    for weight in (0.3, 0.8, 1.0):
        expected = posed_by_usd(path, {"smile": weight})
        np.testing.assert_allclose(found.pose({"smile": weight}), expected, atol=1e-5)
    assert_same_paths(rig.morphs["jaw open.v2"], found.morphs["jaw open.v2"])


def test_points_that_another_program_moved_are_read_as_they_are_now(tmp_path: Path) -> None:
    from pxr import Usd, UsdGeom

    mesh = grid().with_vertices(grid().vertices + 1e6)
    write_usd(tmp_path / "a.usdc", Rig(mesh, {"a": curved(mesh, 0, slice(0, 5))}))
    stage = Usd.Stage.Open(str(tmp_path / "a.usdc"))
    moved = grid().vertices.astype(np.float32)
    UsdGeom.Mesh(stage.GetPrimAtPath("/Face/Mesh")).GetPointsAttr().Set(moved)
    stage.Save()
    found = read_in_this_process(tmp_path / "a.usdc", tmp_path)
    np.testing.assert_array_equal(found.neutral.vertices, moved)


def test_a_blend_shape_that_is_gone_takes_its_correctives_along(tmp_path: Path) -> None:
    from pxr import Usd, UsdSkel

    path = tmp_path / "a.usda"
    write_usd(path, sample_rig())
    stage = Usd.Stage.Open(str(path))
    binding = UsdSkel.BindingAPI(stage.GetPrimAtPath("/Face/Mesh"))
    for own in (binding.GetBlendShapesAttr(), binding.GetBlendShapeTargetsRel()):
        if isinstance(own, Usd.Relationship):
            own.SetTargets([t for t in own.GetTargets() if t.name != "smile"])
        else:
            own.Set([token for token in own.Get() if token != "smile"])
    stage.Save()
    with pytest.warns(ElastomorphWarning, match="correctives or groups name are gone"):
        found = read_in_this_process(path, tmp_path)
    assert list(found.morphs) == [name for name in sample_rig().morphs if name != "smile"]
    assert not found.sliders.correctives


def test_a_renamed_shape_has_its_new_name(tmp_path: Path) -> None:
    path = tmp_path / "a.usda"
    mesh = grid()
    write_usd(path, Rig(mesh, {"jaw open": curved(mesh, 0, slice(0, 5))}))
    path.write_text(path.read_text().replace("jaw_open", "chin_drop"))
    assert read_in_this_process(path, tmp_path).names == ("chin_drop",)


def test_the_sliders_of_a_morph_that_is_its_own_driver(tmp_path: Path) -> None:
    mesh = grid()
    morphs: dict[str, Morph] = {n: curved(mesh, i, slice(0, 5)) for i, n in enumerate("ab")}
    rig = Rig(mesh, morphs, correctives={"b": ("a", "b")})
    write_usd(tmp_path / "a.usdc", rig)
    assert_same_rig(rig, read_in_this_process(tmp_path / "a.usdc", tmp_path))
