"""What other programs find in a USD file: UsdSkel plays it as the report says."""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from usd_rigs import grid, piecewise_linear, played_by_usd, posed_by_usd, sample_rig

from elastomorph.errors import FileError, FormatError, MissingExtraError, ParameterError
from elastomorph.io.usd import UsdReport, write_usd
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig
from needs import extra

needs_usd = pytest.mark.usefixtures("usd")
SINGLE = 4e-6  # a few roundings to float32 of coordinates up to 10


@pytest.fixture(scope="module")
def usd() -> None:
    extra("pxr", "usd")


@pytest.fixture(scope="module")
def written(usd: None, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Rig, UsdReport]:
    path = tmp_path_factory.mktemp("usd") / "face.usdc"
    rig = sample_rig()
    return path, rig, write_usd(path, rig, tolerance=1e-3, most_inbetweens=3)


@pytest.mark.parametrize("weight", [0.0, 0.1, 0.25, 0.37, 0.5, 0.62, 0.75, 0.99, 1.0])
def test_usd_plays_straight_pieces_within_the_stated_error(
    written: tuple[Path, Rig, UsdReport], weight: float
) -> None:
    path, rig, report = written
    for shape in report.shapes:
        morph = rig.morphs[shape.name]
        found = posed_by_usd(path, {shape.prim_name: weight})
        straight = piecewise_linear(morph, shape.inbetweens, weight)
        np.testing.assert_allclose(found, straight, rtol=0, atol=SINGLE)
        apart = np.linalg.norm(found - morph.at(weight), axis=1).max()
        assert apart <= shape.error * rig.neutral.diameter * (1 + 1e-3) + SINGLE


def test_shapes_add_up_as_in_a_pose(written: tuple[Path, Rig, UsdReport]) -> None:
    """At the weights of in-betweens and at 0 and 1 nothing is approximated."""
    path, rig, report = written
    weights = {"jaw open.v2": 1.0, "Lächeln": 1.0, "smile": report.shapes[1].inbetweens[0]}
    plain = {shape.name: shape.prim_name for shape in report.shapes}
    found = posed_by_usd(path, {plain[name]: w for name, w in weights.items()})
    np.testing.assert_allclose(found, rig.pose(weights), rtol=0, atol=SINGLE)


def test_beyond_the_target_usd_goes_on_along_its_last_piece(
    written: tuple[Path, Rig, UsdReport],
) -> None:
    path, rig, report = written
    shape = report.shapes[0]
    morph = rig.morphs[shape.name]
    for weight in (-0.4, 1.3):
        found = posed_by_usd(path, {shape.prim_name: weight})
        straight = piecewise_linear(morph, shape.inbetweens, weight)
        np.testing.assert_allclose(found, straight, rtol=0, atol=3 * SINGLE)


def test_only_moved_points_are_stored(written: tuple[Path, Rig, UsdReport]) -> None:
    from pxr import Usd, UsdSkel

    path, rig, report = written
    stage = Usd.Stage.Open(str(path))
    for shape in report.shapes:
        prim = UsdSkel.BlendShape(stage.GetPrimAtPath(f"/Face/Mesh/{shape.prim_name}"))
        morph = rig.morphs[shape.name]
        moves = morph.delta.any(axis=1) | morph.bends.any(axis=(0, 2))
        points = list(prim.GetPointIndicesAttr().Get())
        # one point stands for none: no point at all would mean all of them
        assert points == (np.flatnonzero(moves).tolist() or [0])
        assert shape.points == len(points)
        for own in (prim.GetOffsetsAttr(), *(i.GetAttr() for i in prim.GetInbetweens())):
            assert len(own.Get()) == len(points)
        weights = sorted(i.GetWeight() for i in prim.GetInbetweens())
        assert tuple(weights) == shape.inbetweens


def test_movement_too_small_for_float32_is_not_stored(usd: None, tmp_path: Path) -> None:
    mesh = grid()
    moved = mesh.vertices.copy()
    moved += 1e-9 * np.random.default_rng(0).normal(size=moved.shape)
    moved[7] += 0.5
    bends = np.zeros((0, *mesh.vertices.shape))
    rig = Rig(mesh, {"a": Morph(mesh, mesh.with_vertices(moved), bends, ())})
    assert write_usd(tmp_path / "a.usda", rig).shapes[0].points == 1


def test_the_report_tells_what_is_in_the_file(written: tuple[Path, Rig, UsdReport]) -> None:
    path, rig, report = written
    assert [shape.name for shape in report.shapes] == list(rig.morphs)
    assert report.size == path.stat().st_size
    assert report.error == max(shape.error for shape in report.shapes)
    by_name = {shape.name: shape for shape in report.shapes}
    assert by_name["straight"].inbetweens == by_name["nothing"].inbetweens == ()
    assert by_name["pieces"].inbetweens == (0.25, 0.6875)
    assert by_name["pieces"].error < 1e-12
    assert [shape.prim_name for shape in report.shapes] == [
        "jaw_open_v2",
        "smile",
        "straight",
        "nothing",
        "pieces",
        "L_cheln",
        "jaw_open_v2_1",
    ]
    assert set(report.above_tolerance) == {s for s in report.shapes if s.error > 1e-3}
    assert all(len(shape.inbetweens) == 3 for shape in report.above_tolerance)


def test_names_that_usd_does_not_allow_are_kept(written: tuple[Path, Rig, UsdReport]) -> None:
    from pxr import Usd

    path, _, report = written
    stage = Usd.Stage.Open(str(path))
    for shape in report.shapes:
        prim = stage.GetPrimAtPath(f"/Face/Mesh/{shape.prim_name}")
        assert prim.GetDisplayName() == shape.name
        assert prim.GetAttribute("elastomorph:name").Get() == shape.name


def test_the_mesh_is_the_neutral(written: tuple[Path, Rig, UsdReport]) -> None:
    from pxr import Usd, UsdGeom, UsdShade

    path, rig, _ = written
    stage = Usd.Stage.Open(str(path))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/Face/Mesh"))
    neutral = rig.neutral
    np.testing.assert_allclose(mesh.GetPointsAttr().Get(), neutral.vertices, atol=1e-6)
    assert list(mesh.GetFaceVertexCountsAttr().Get()) == neutral.faces.sizes.tolist()
    assert list(mesh.GetFaceVertexIndicesAttr().Get()) == neutral.faces.indices.tolist()
    assert mesh.GetSubdivisionSchemeAttr().Get() == "none"
    assert UsdGeom.Mesh.ValidateTopology(
        mesh.GetFaceVertexIndicesAttr().Get(), mesh.GetFaceVertexCountsAttr().Get(), 20
    )[0]
    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    assert st.GetInterpolation() == "faceVarying"
    assert st.GetTypeName() == "texCoord2f[]"
    flat = np.array(st.ComputeFlattened())
    expected = neutral.uv.coordinates[neutral.uv.corners]
    expected[neutral.uv.corners < 0] = 0
    np.testing.assert_allclose(flat, expected, atol=1e-6)
    subsets = UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
    assert [s.GetPrim().GetName() for s in subsets] == ["skin_001", "lip_stick"]
    for i, subset in enumerate(subsets):
        faces = np.flatnonzero(neutral.materials.of_face == i).tolist()
        assert list(subset.GetIndicesAttr().Get()) == faces
        bound = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0]
        assert bound.GetPrim().GetDisplayName() == neutral.materials.names[i]
    # the group 'smile' may not have the name of the blend shape beside it
    assert stage.GetPrimAtPath("/Face/Mesh/smile").GetTypeName() == "BlendShape"
    assert stage.GetPrimAtPath("/Face/Mesh/smile_1").GetTypeName() == "GeomSubset"


def test_the_stage_says_what_readers_need(written: tuple[Path, Rig, UsdReport]) -> None:
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(written[0]))
    assert stage.GetDefaultPrim().GetTypeName() == "SkelRoot"
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert not stage.HasAuthoredTimeCodeRange()
    np.testing.assert_allclose(played_by_usd(written[0], 0), sample_rig().neutral.vertices, 1e-6)


def test_the_validators_of_usd_find_nothing(written: tuple[Path, Rig, UsdReport]) -> None:
    validation = extra("pxr.UsdValidation", "usd")
    from pxr import Usd

    every = validation.ValidationRegistry().GetOrLoadAllValidators()
    found = validation.ValidationContext(every).Validate(Usd.Stage.Open(str(written[0])))
    assert len(every) > 5
    assert [error.GetErrorAsString() for error in found] == []


def test_poses_stay_inside_the_extent(written: tuple[Path, Rig, UsdReport]) -> None:
    from pxr import Usd, UsdSkel

    path, _, report = written
    stage = Usd.Stage.Open(str(path))
    low, high = np.array(UsdSkel.Root(stage.GetDefaultPrim()).GetExtentAttr().Get())
    random = np.random.default_rng(0)
    for _ in range(20):
        weights = {shape.prim_name: random.uniform() for shape in report.shapes}
        posed = posed_by_usd(path, weights)
        assert (posed >= low - 1e-5).all()
        assert (posed <= high + 1e-5).all()


@needs_usd
def test_an_animation_plays_slider_weights(tmp_path: Path) -> None:
    """Time samples at the frame rate; a corrective gets the product of its drivers."""
    from pxr import Usd

    rig, path = sample_rig(), tmp_path / "moving.usda"
    times = np.arange(10, 17) / 24
    weights = np.random.default_rng(1).uniform(size=(7, len(rig.names)))
    report = write_usd(path, rig, animation=(times, weights, "take 1"), fps=24)
    stage = Usd.Stage.Open(str(path))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (10, 16)
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == 24
    animation = stage.GetPrimAtPath("/Face/Animation")
    assert animation.GetDisplayName() == "take 1"
    samples = animation.GetAttribute("blendShapeWeights")
    assert samples.GetTimeSamples() == list(range(10, 17))
    driven = rig.sliders.drive(weights)
    for i in range(7):
        np.testing.assert_allclose(samples.Get(10 + i), driven[i], rtol=1e-6)
        expected = rig.neutral.vertices.copy()
        for shape, weight in zip(report.shapes, driven[i], strict=True):
            morph = rig.morphs[shape.name]
            expected += piecewise_linear(morph, shape.inbetweens, weight) - rig.neutral.vertices
        np.testing.assert_allclose(played_by_usd(path, 10 + i), expected, atol=4 * SINGLE)
    assert samples.Get() == [0.0] * len(driven[0])  # at rest where no time is asked for


@needs_usd
@pytest.mark.parametrize(
    ("animation", "words"),
    [
        (([0, 1], [[0.0] * 6], "a"), "one time for each of its 1 rows"),
        (([0], [[0.0] * 4], "a"), r"weights must have shape \(S, 6\)"),
        (([0, 0], [[0.0] * 6] * 2, "a"), "rise from row to row"),
        (([np.nan], [[0.0] * 6], "a"), "finite seconds"),
        (([0], [[np.nan] * 6], "a"), "must be finite"),
        ((["x"], [[0.0] * 6], "a"), "must be numbers"),
        (([], np.zeros((0, 6)), "a"), "one time for each"),
    ],
)
def test_animations_that_do_not_fit_are_refused(
    tmp_path: Path, animation: tuple[Any, Any, str], words: str
) -> None:
    assert len(sample_rig().names) == 6
    with pytest.raises(ParameterError, match=words):
        write_usd(tmp_path / "a.usda", sample_rig(), animation=animation)
    assert not list(tmp_path.iterdir())


@needs_usd
@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"tolerance": -1}, "tolerance"),
        ({"tolerance": np.nan}, "tolerance"),
        ({"most_inbetweens": -1}, "most_inbetweens"),
        ({"most_inbetweens": 1.5}, "most_inbetweens"),
        ({"fps": 0}, "fps"),
        ({"meters_per_unit": np.inf}, "meters_per_unit"),
    ],
)
def test_arguments_out_of_range(tmp_path: Path, wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        write_usd(tmp_path / "a.usda", sample_rig(), **wrong)


@needs_usd
def test_files_that_cannot_be_written_leave_the_old_one(tmp_path: Path) -> None:
    mesh = Mesh([[0, 0, 0], [1e39, 0, 0]])
    (tmp_path / "a.usdc").write_bytes(b"old")
    with pytest.raises(FormatError, match="too large for USD"):
        write_usd(tmp_path / "a.usdc", Rig(mesh, {}))
    assert (tmp_path / "a.usdc").read_bytes() == b"old"
    with pytest.raises(FormatError, match=r"expected a name that ends in \.usd, \.usda, \.usdc"):
        write_usd(tmp_path / "a.usdx", sample_rig())
    with pytest.raises(FileError, match="does not exist"):
        write_usd(tmp_path / "no" / "a.usdc", sample_rig())
    with pytest.raises(ParameterError, match="expected a Rig"):
        write_usd(tmp_path / "b.usdc", mesh)  # type: ignore[arg-type]
    assert [p.name for p in tmp_path.iterdir()] == ["a.usdc"]


@needs_usd
@pytest.mark.parametrize("name", ["a\0b", "\ud800"])
def test_a_name_that_is_no_text_is_refused(tmp_path: Path, name: str) -> None:
    rig = Rig(grid(), {name: sample_rig().morphs["nothing"]})
    with pytest.raises(FormatError, match="cannot be stored as text"):
        write_usd(tmp_path / "a.usda", rig)


@needs_usd
def test_the_suffix_decides_between_text_and_binary(tmp_path: Path) -> None:
    begins = {}
    for suffix in ("usd", "usda", "usdc", "USDA"):
        path = tmp_path / f"a.{suffix}"
        write_usd(path, sample_rig())
        begins[suffix] = path.read_bytes()[:8]
    assert begins["usda"] == begins["USDA"] == b"#usda 1."
    assert begins["usd"] == begins["usdc"] == b"PXR-USDC"


@needs_usd
@pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")
def test_a_new_file_has_the_mode_of_any_other_and_an_old_one_keeps_its_own(tmp_path: Path) -> None:
    (tmp_path / "plain").touch()
    path = tmp_path / "a.usdc"
    write_usd(path, sample_rig())
    assert path.stat().st_mode == (tmp_path / "plain").stat().st_mode
    path.chmod(0o640)
    write_usd(path, sample_rig())
    assert path.stat().st_mode & 0o777 == 0o640


def test_without_usd_the_error_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(name: str) -> Any:
        if name.startswith("pxr"):
            raise ModuleNotFoundError("No module named 'pxr'", name="pxr")
        return import_module(name)

    monkeypatch.setattr("elastomorph.io.usd.library.import_module", missing)
    with pytest.raises(MissingExtraError, match=r"elastomorph\[usd\]"):
        write_usd(tmp_path / "a.usdc", sample_rig())
    assert not list(tmp_path.iterdir())
