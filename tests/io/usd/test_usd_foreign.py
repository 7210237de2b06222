"""USD files of other programs: the path read is the one UsdSkel plays."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from usd_rigs import author_shapes, posed_by_usd, read_in_this_process

import elastomorph as em
from elastomorph.errors import ElastomorphWarning, FormatError
from elastomorph.io.usd import read_usd, write_usd
from needs import extra

extra("pxr", "usd")

STRIP = np.array([[x, y, 0.0] for x in range(4) for y in range(2)])

TURN = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]


def file_with(folder: Path, **shapes: Any) -> Path:
    from pxr import Usd

    stage = Usd.Stage.CreateInMemory()
    author_shapes(stage, "/body/head", STRIP, shapes)
    path = folder / "foreign.usda"
    stage.GetRootLayer().Export(str(path))
    return path


def offsets(seed: int, count: int = len(STRIP)) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(count, 3)).astype(np.float32)


@given(
    weights=st.lists(st.integers(1, 31), max_size=4, unique=True),
    points=st.none() | st.lists(st.integers(0, 7), min_size=1, max_size=8, unique=True),
    seed=st.integers(0, 99),
)
@settings(max_examples=40, deadline=None)
def test_the_path_read_is_the_one_usd_plays(
    tmp_path_factory: pytest.TempPathFactory,
    weights: list[int],
    points: list[int] | None,
    seed: int,
) -> None:
    """In-betweens in any order, on all points or on some, in any order."""
    folder = tmp_path_factory.getbasetemp()
    count = len(STRIP) if points is None else len(points)
    inner = {w / 32: offsets(seed + w, count) for w in weights}
    path = file_with(folder, shape=(offsets(seed, count), points, inner))
    rig = read_in_this_process(path, folder)
    assert len(rig.morphs["shape"].bends) == len(weights)
    for t in (-0.5, 0.0, 0.1, 0.4, 0.55, 0.9, 1.0, 1.5):
        played = posed_by_usd(path, {"shape": t}, "/body/head")
        np.testing.assert_allclose(rig.pose({"shape": t}), played, rtol=0, atol=1e-4)


def test_a_foreign_rig_is_written_without_loss(tmp_path: Path) -> None:
    inner = {0.125: offsets(1), 0.8: offsets(2)}
    path = file_with(tmp_path, shape=(offsets(0), None, inner))
    rig = read_in_this_process(path, tmp_path)
    report = write_usd(tmp_path / "own.usdc", rig, tolerance=0)
    assert report.shapes[0].inbetweens == pytest.approx((0.125, 0.8))
    assert report.error < 1e-6
    for t in (0.1, 0.5, 0.9):
        theirs = posed_by_usd(path, {"shape": t}, "/body/head")
        ours = posed_by_usd(tmp_path / "own.usdc", {"shape": t})
        np.testing.assert_allclose(ours, theirs, atol=1e-5)


def test_empty_point_indices_mean_all_points(tmp_path: Path) -> None:
    path = file_with(tmp_path, shape=(offsets(0), [], {}))
    rig = read_in_this_process(path, tmp_path)
    np.testing.assert_allclose(rig.pose({"shape": 1}), STRIP + offsets(0), atol=1e-6)


def test_inbetweens_that_usd_cannot_place_are_left_out(tmp_path: Path) -> None:
    for weight in (1.5, -0.5):
        path = file_with(tmp_path, shape=(offsets(0), None, {weight: offsets(1)}))
        with pytest.warns(ElastomorphWarning, match=f"at the weight {weight:g}, which is not"):
            rig = read_in_this_process(path, tmp_path)
        assert len(rig.morphs["shape"].bends) == 0
    path.write_text(path.read_text().replace("weight = -0.5", 'doc = "no weight"'))
    with pytest.warns(ElastomorphWarning, match="at the weight nan"):
        read_in_this_process(path, tmp_path)


def test_two_inbetweens_at_one_weight(tmp_path: Path) -> None:
    """The same twice is one; two different ones are no path."""
    inner = {0.25: offsets(1), 0.5: offsets(1)}
    path = file_with(tmp_path, shape=(offsets(0), None, inner))
    path.write_text(path.read_text().replace("weight = 0.5", "weight = 0.25"))
    assert len(read_in_this_process(path, tmp_path).morphs["shape"].bends) == 1
    path = file_with(tmp_path, shape=(offsets(0), None, {0.25: offsets(1), 0.5: offsets(2)}))
    path.write_text(path.read_text().replace("weight = 0.5", "weight = 0.25"))
    with pytest.raises(FormatError, match=r"two different in-betweens at the weight 0\.25"):
        read_in_this_process(path, tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("pointIndices = [1, 2]", "pointIndices = [1, 8]", "go from 1 to 8, expected 0 to 7"),
        ("pointIndices = [1, 2]", "pointIndices = [-1, 2]", "go from -1 to 2"),
        ("pointIndices = [1, 2]", "pointIndices = [1]", "moves 1 points, but has 2 offsets"),
        ("Indices = [0, 1, 3", "Indices = [0, 1, 9", "names vertex 9|go from 0 to 9"),
        ("Counts = [4, 4, 4]", "Counts = [4, 4, 5]", "13 corners"),
        ("Counts = [4, 4, 4]", "Counts = [4, 4, 2, 2]", "polygon 2 has 2 vertices"),
        ("Counts = [4, 4, 4]", "Counts = [4, 4, -4, 8]", "go from -4 to 8"),
        ("points = [(0, 0, 0)", "points = [(nan, 0, 0)", "not all finite"),
        ("points = [(0, 0, 0)", "points = [(0, 0, inf)", "not all finite"),
        ("</body/head/shape>", "</body/head/none>", "names the blend shape /body/head/none"),
    ],
)
def test_shapes_that_do_not_fit_are_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = file_with(tmp_path, shape=(offsets(0, 2), [1, 2], {}))
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(FormatError, match=words) as caught:
        read_in_this_process(path, tmp_path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("points", "offsets", "words"),
    [
        (
            'string[] points = ["a"]',
            "vector3f[] offsets = []",
            "points holds values that are not numbers",
        ),
        ("float points = 1", "vector3f[] offsets = []", r"array '0_points' has the shape \(\)"),
        (
            "asset[] points = [@a@]",
            "vector3f[] offsets = []",
            "points holds values that are not numbers",
        ),
        ("point3f[] points = [(0, 0, 0)]", "float[] offsets = [1]", "has the shape"),
        ("point3f[] points", "vector3f[] offsets", "V ≥ 1"),
        ("point3f[] points.timeSamples = {3: [(1, 2, 3)]}", "vector3f[] offsets", ""),
    ],
)
def test_values_of_any_type_are_met_with_an_error_or_a_rig(
    tmp_path: Path, points: str, offsets: str, words: str
) -> None:
    """Points that only move are taken at their first time; a shape without offsets is empty."""
    path = tmp_path / "odd.usda"
    path.write_text(
        '#usda 1.0\ndef Mesh "m" {\n'
        f"{points}\nrel skel:blendShapeTargets = </m/s>\n"
        f'def BlendShape "s" {{\nuniform {offsets}\n}}\n}}\n'
    )
    if words:
        with pytest.raises(FormatError, match=words):
            read_in_this_process(path, tmp_path)
    else:
        assert read_in_this_process(path, tmp_path).pose({"s": 1.0}).tolist() == [[1, 2, 3]]


def test_left_handed_polygons_are_turned_around_with_their_texture(tmp_path: Path) -> None:
    from pxr import Sdf, Usd, UsdGeom

    path = file_with(tmp_path, shape=(offsets(0), None, {}))
    stage = Usd.Stage.Open(str(path))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/body/head"))
    mesh.CreateOrientationAttr("leftHanded")
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "UVMap", Sdf.ValueTypeNames.Float2Array, UsdGeom.Tokens.faceVarying
    )
    st.Set([(i, 0) for i in range(12)])
    stage.Save()
    rig = read_in_this_process(path, tmp_path)
    assert rig.neutral.faces[0].tolist() == [0, 2, 3, 1]
    corner = rig.neutral.uv.coordinates[rig.neutral.uv.corners][:, 0]
    assert corner.tolist() == [0, 3, 2, 1, 4, 7, 6, 5, 8, 11, 10, 9]


def test_texture_coordinates_of_points_become_those_of_corners(tmp_path: Path) -> None:
    from pxr import Sdf, Usd, UsdGeom, UsdShade

    path = file_with(tmp_path, shape=(offsets(0), None, {}))
    stage = Usd.Stage.Open(str(path))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/body/head"))
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "map", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    st.Set(STRIP[:, :2].tolist())
    material = UsdShade.Material.Define(stage, "/looks/skin")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
    stage.Save()
    neutral = read_in_this_process(path, tmp_path).neutral
    mapped = neutral.uv.coordinates[neutral.uv.corners]
    np.testing.assert_array_equal(mapped, STRIP[neutral.faces.indices, :2])
    assert neutral.materials.names == ("skin",)
    assert neutral.materials.of_face.tolist() == [0, 0, 0]


def several_meshes(folder: Path) -> Path:
    """A face, teeth turned, scaled and moved beside it, hair without shapes, and what is unseen."""
    from pxr import Gf, Usd, UsdGeom

    stage = Usd.Stage.CreateInMemory()
    inner = {0.5: offsets(3)}
    author_shapes(
        stage, "/head/face", STRIP, {"jaw": (offsets(0), None, inner), "f": (offsets(1), None, {})}
    )
    teeth = author_shapes(stage, "/head/teeth", STRIP, {"jaw": (offsets(2), None, {})})
    UsdGeom.Xformable(teeth).AddTransformOp().Set(
        Gf.Matrix4d().SetRotate(Gf.Rotation((0, 0, 1), 90)) * Gf.Matrix4d().SetTranslate((5, 0, 0))
    )
    UsdGeom.Xformable(stage.GetPrimAtPath("/head")).AddScaleOp().Set((2, 2, 2))
    hair = author_shapes(stage, "/head/hair", STRIP + 7, {})
    hair.CreateOrientationAttr("leftHanded")
    UsdGeom.Mesh.Define(stage, "/head/empty")
    author_shapes(stage, "/head/old", STRIP, {"old": (offsets(0), None, {})}).MakeInvisible()
    author_shapes(stage, "/head/proxy", STRIP, {}).CreatePurposeAttr("proxy")
    path = folder / "several.usda"
    stage.GetRootLayer().Export(str(path))
    return path


def test_all_meshes_that_are_rendered_become_one(tmp_path: Path) -> None:
    """In the order of the stage and in the space of the one with most shapes."""
    path = several_meshes(tmp_path)
    rig = read_usd(path)
    assert rig.names == ("jaw", "f")
    turned = STRIP[:, [1, 0, 2]] * [-1, 1, 1] + [5, 0, 0]
    expected = np.concatenate([STRIP, turned, STRIP + 7])
    np.testing.assert_allclose(rig.neutral.vertices, expected, atol=1e-12)
    assert rig.neutral.vertices[:8].tobytes() == STRIP.tobytes()
    assert rig.neutral.groups is not None
    assert rig.neutral.groups.names == ("face", "teeth", "hair")
    assert [face.tolist() for face in rig.neutral.faces][3::3] == [[8, 9, 11, 10], [16, 18, 19, 17]]
    halfway = rig.pose({"jaw": 0.5}) - rig.neutral.vertices
    np.testing.assert_allclose(halfway[:8], offsets(3), atol=1e-6)
    np.testing.assert_allclose(
        halfway[8:16], offsets(2)[:, [1, 0, 2]] * [-0.5, 0.5, 0.5], atol=1e-6
    )
    assert not halfway[16:].any()
    assert not rig.morphs["f"].delta[8:].any()


def test_meshes_are_chosen_by_name_or_path(tmp_path: Path) -> None:
    path = several_meshes(tmp_path)
    teeth = read_usd(path, mesh="teeth")
    assert teeth.names == ("jaw",)
    # in its own numbers, but turned as the stage shows it
    np.testing.assert_array_equal(teeth.neutral.vertices, STRIP[:, [1, 0, 2]] * [-1, 1, 1])
    assert read_in_this_process(path, tmp_path, "/head/old").names == ("old",)
    both = read_in_this_process(path, tmp_path, "hair", "face")
    assert len(both.neutral.vertices) == 16
    assert both.names == ("jaw", "f")
    with pytest.raises(
        FormatError, match=r"no mesh is called 'nose'; there are '/head/face' \(2 sh"
    ):
        read_in_this_process(path, tmp_path, "nose")


@pytest.mark.parametrize(("up", "rows"), [("Y", [[1, 0, 0], [0, 1, 0], [0, 0, 1]]), ("Z", TURN)])
def test_faces_stand_upright(tmp_path: Path, up: str, rows: list[list[int]]) -> None:
    """Blender and many others say that z is up, and look along y."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.CreateInMemory()
    author_shapes(stage, "/head", STRIP, {"jaw": (offsets(0), None, {0.5: offsets(1)})})
    UsdGeom.SetStageUpAxis(stage, up)
    path = tmp_path / "upright.usda"
    stage.GetRootLayer().Export(str(path))
    rig = read_in_this_process(path, tmp_path)
    for weight in (0.0, 0.5, 1.0):
        played = posed_by_usd(path, {"jaw": weight}, "/head")
        found = rig.pose({"jaw": weight})
        np.testing.assert_allclose(found, played @ np.transpose(rows), rtol=0, atol=1e-6)
    np.testing.assert_array_equal(rig.neutral.vertices, STRIP @ np.transpose(rows))


def test_a_skinned_mesh_stands_where_it_was_bound(tmp_path: Path) -> None:
    """UsdSkel passes over the transform of such a prim."""
    from pxr import Gf, Usd, UsdGeom, UsdSkel

    path = several_meshes(tmp_path)
    stage = Usd.Stage.Open(str(path))
    skeleton = UsdSkel.Skeleton.Define(stage, "/head/bones")
    UsdGeom.Xformable(skeleton).AddTranslateOp().Set((0, 1, 0))
    binding = UsdSkel.BindingAPI.Apply(stage.GetPrimAtPath("/head/teeth"))
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointIndicesPrimvar(constant=True, elementSize=1).Set([0])
    binding.CreateGeomBindTransformAttr().Set(Gf.Matrix4d().SetTranslate((3, 0, 0)))
    stage.Save()
    rig = read_in_this_process(path, tmp_path)
    np.testing.assert_allclose(rig.neutral.vertices[8:16], STRIP + [3, 1, 0], atol=1e-12)


def test_files_without_shapes_say_what_there_is(tmp_path: Path) -> None:
    from pxr import Usd

    path = several_meshes(tmp_path)
    stage = Usd.Stage.Open(str(path))
    for name in ("face", "teeth", "old"):
        stage.RemovePrim(f"/head/{name}")
    stage.Save()
    with pytest.raises(FormatError, match=r"no mesh has blend shapes; there are '/head/hair' \(no"):
        read_in_this_process(path, tmp_path)


def test_packages_are_read_with_what_lies_in_them(tmp_path: Path) -> None:
    from pxr import UsdUtils

    several_meshes(tmp_path)
    (tmp_path / "root.usda").write_text(
        '#usda 1.0\ndef "A" (references = @several.usda@</head>) {}\n'
    )
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "root.usda"), str(tmp_path / "a.usdz"))
    rig, loose = em.read_rig(tmp_path / "a.usdz"), read_usd(tmp_path / "root.usda")
    assert rig.names == loose.names == ("jaw", "f")
    assert rig.neutral.vertices.tobytes() == loose.neutral.vertices.tobytes()
    assert rig.neutral.faces == loose.neutral.faces
    for name in rig.names:
        assert rig.morphs[name].delta.tobytes() == loose.morphs[name].delta.tobytes()


@pytest.mark.parametrize("asset", ["../several.usda", "{outside}", "gone.usda", "sub/../../x.usda"])
def test_packages_are_not_left(tmp_path: Path, asset: str) -> None:
    outside = several_meshes(tmp_path)
    text = f'#usda 1.0\ndef "A" (references = @{asset.format(outside=outside)}@</head>) {{}}\n'
    path = tmp_path / "folder" / "a.usdz"
    path.parent.mkdir()
    with zipfile.ZipFile(path, "w") as package:
        info = zipfile.ZipInfo("root.usda")
        info.extra = bytes([0x86, 0x19, 20, 0]) + bytes(20)  # content begins at a multiple of 64
        package.writestr(info, text)
    with pytest.raises(FormatError, match=r"a\.usdz: it is composed of .*, which"):
        read_usd(path)


def test_shapes_numbered_by_an_exporter_are_one_morph(tmp_path: Path) -> None:
    """UsdSkel wants one weight a name; Blender numbers the names of further meshes, not prims."""
    from pxr import Usd, Vt
    from pxr.UsdSkel import BindingAPI

    stage = Usd.Stage.CreateInMemory()
    for mesh, names in (("head", ["jawOpen3", "smile2"]), ("teeth", ["jawOpen12", "smileWide"])):
        shapes = {name: (offsets(i), None, {}) for i, name in enumerate(("jawOpen", "smile"))}
        author_shapes(stage, f"/body/{mesh}", STRIP, shapes)
        BindingAPI(stage.GetPrimAtPath(f"/body/{mesh}")).GetBlendShapesAttr().Set(
            Vt.TokenArray(names)
        )
    path = tmp_path / "numbered.usda"
    stage.GetRootLayer().Export(str(path))
    rig = read_in_this_process(path, tmp_path)
    assert list(rig.morphs) == ["jawOpen", "smile", "smileWide"]
    moved = rig.morphs["jawOpen"].delta.any(axis=1)
    assert len(moved) == 2 * len(STRIP)
    assert moved.all()
