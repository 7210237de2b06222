"""USD files made to harm: wrong types, endless composition, numbers beyond all bounds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from usd_rigs import author_shapes, grid, read_in_this_process, sample_rig

from elastomorph.errors import ElastomorphWarning, FormatError
from elastomorph.io.isolated import RefusedError
from elastomorph.io.usd import read_usd, worker, write_usd
from elastomorph.io.usd.exact import path_from_json
from elastomorph.rig import Rig
from needs import extra

pytestmark = pytest.mark.hostile

extra("pxr", "usd")

WHOLE: dict[str, Any] = {
    "version": 1,
    "method": "beam",
    "bakeError": 0.0,
    "bendCurves": [{"breaks": [0, 1], "coefficients": [[0, -1, 1]]}],
    "limitLaw": {"breaks": [0, 1], "coefficients": [[0]]},
    "checksum": 5,
}


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("bakeError", 10**400),
        ("bakeError", float("inf")),
        ("bakeError", float("nan")),
        ("bakeError", -1.0),
        ("bakeError", []),
        ("checksum", float("inf")),
        ("checksum", "five"),
        ("limitLaw", {"breaks": [0, 10**400], "coefficients": [[0]]}),
        ("limitLaw", {"breaks": [0, 1], "coefficients": [[10**400]]}),
        ("limitLaw", {"breaks": [0, 1], "coefficients": [[0.0] * 1000]}),
        ("limitLaw", {"breaks": [0, 1], "coefficients": []}),
        ("limitLaw", {"breaks": [0, 1], "coefficients": 5}),
        ("bendCurves", 5),
        ("version", [[]]),
    ],
)
def test_a_path_beyond_all_bounds_is_none(key: str, value: Any) -> None:
    assert path_from_json(json.dumps(WHOLE)) is not None
    assert path_from_json(json.dumps({**WHOLE, key: value})) is None


def text_of(folder: Path) -> str:
    write_usd(folder / "whole.usda", Rig(grid(), {}))
    return (folder / "whole.usda").read_text()


def replaced(text: str, name: str, line: str) -> str:
    """The text with the line that gives an attribute its value replaced."""
    lines = text.split("\n")
    (place,) = (i for i, own in enumerate(lines) if f" {name} = " in own)
    return "\n".join([*lines[:place], line, *lines[place + 1 :]])


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("points", "int[] points = [1, 2]"),
        ("faceVertexCounts", "float[] faceVertexCounts = [3.5]"),
        ("faceVertexIndices", "double[] faceVertexIndices = [1]"),
    ],
)
def test_attributes_of_another_type_are_an_error_of_the_file(
    tmp_path: Path, name: str, line: str
) -> None:
    """Not of the archive in a temporary folder in which they came."""
    path = tmp_path / "face.usda"
    path.write_text(replaced(text_of(tmp_path), name, line))
    with pytest.raises(FormatError, match=r"face\.usda: its content makes no sense: ") as caught:
        read_usd(path)
    assert "elastomorph-" not in str(caught.value)


def nested_references(levels: int) -> str:
    """Each level holds the one below ten times: ten lines a level, ten times the prims."""
    parts = ['#usda 1.0\ndef "l0" {\ndef Mesh "m" {}\n}\n']
    for level in range(1, levels):
        below = f"references = </l{level - 1}>"
        children = "".join(f'def "c{i}" ({below}) {{}}\n' for i in range(10))
        parts.append(f'def "l{level}" {{\n{children}}}\n')
    return "".join(parts)


def test_references_that_multiply_without_end_are_stopped(tmp_path: Path) -> None:
    path = tmp_path / "a.usda"
    path.write_text(nested_references(9))
    with pytest.raises(FormatError, match=r"a\.usda: (USD broke while reading it|it needs more)"):
        read_usd(path)
    path.write_text(nested_references(3))
    with pytest.raises(FormatError, match=r"no mesh has blend shapes; there are .* and \d+ more"):
        read_usd(path)


def test_what_is_shown_is_not_asked_of_meshes_that_are_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A walk up to the root for each of very many meshes took a third of the time."""
    asked: list[str] = []
    monkeypatch.setattr(worker, "_is_shown", lambda prim: asked.append(str(prim)) or True)
    path = tmp_path / "many.usda"
    path.write_text("#usda 1.0\n" + "".join(f'def Mesh "a{i}" {{}}\n' for i in range(50)))
    with pytest.raises(RefusedError, match="no mesh has blend shapes; there are '/a0'"):
        worker.content_of(str(path))
    assert not asked
    write_usd(tmp_path / "face.usda", sample_rig())
    worker.content_of(str(tmp_path / "face.usda"))
    assert len(asked) == 1


def test_shapes_of_one_name_are_told_apart_soon(tmp_path: Path) -> None:
    from pxr import Usd, UsdSkel

    count = 400
    stage = Usd.Stage.CreateNew(str(tmp_path / "a.usdc"))
    vertices = grid().vertices[:4]
    shapes = {f"s{i}": (vertices, None, {}) for i in range(count)}
    mesh = author_shapes(stage, "/Face", vertices, shapes)
    UsdSkel.BindingAPI(mesh.GetPrim()).CreateBlendShapesAttr(["same"] * count)
    stage.Save()
    names = read_in_this_process(tmp_path / "a.usdc", tmp_path).names
    assert len(set(names)) == count
    assert names[:3] == ("same", "same_1", "same_2")


def test_other_files_of_the_folder_add_to_what_may_be_used(tmp_path: Path) -> None:
    """A small file that shows a large one is no small file."""
    write_usd(tmp_path / "part.usdc", sample_rig())
    path = tmp_path / "a.usda"
    path.write_text('#usda 1.0\ndef "A" (references = @./part.usdc@) {}\n')
    assert read_usd(path).names == sample_rig().names


def test_a_suffix_in_capitals_is_read(tmp_path: Path) -> None:
    write_usd(tmp_path / "a.usda", sample_rig())
    (tmp_path / "a.usda").rename(tmp_path / "B.USDA")
    assert read_usd(tmp_path / "B.USDA").names == sample_rig().names


def test_an_endless_name_of_another_file_is_cut(tmp_path: Path) -> None:
    path = tmp_path / "a.usda"
    path.write_text(f'#usda 1.0\ndef "A" (references = @{"a" * 5000}.usda@) {{}}\n')
    with pytest.raises(FormatError, match="it is composed of") as caught:
        read_in_this_process(path, tmp_path)
    assert len(str(caught.value)) < 600
    assert np.char.count(str(caught.value), "a") > 100


MESH = """#usda 1.0
def Mesh "m" {
point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
int[] faceVertexCounts = [3]
int[] faceVertexIndices = [0, 1, 2]
rel skel:blendShapeTargets = </m/s>
def BlendShape "s" {
uniform vector3f[] offsets = [(0, 0, 1), (0, 0, 1), (0, 0, 1)]
}
%s
}
"""


def with_more(folder: Path, *lines: str) -> Path:
    """A triangle with one shape, and more in its mesh."""
    path = folder / "more.usda"
    path.write_text(MESH % "\n".join(lines))
    return path


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (
            ['texCoord2f[] primvars:st = [(0, 0)] (interpolation = "faceVarying")'],
            "there are only 1 texture coordinates",
        ),
        (
            [
                'texCoord2f[] primvars:st = [(0, 0)] (interpolation = "vertex")',
                "int[] primvars:st:indices = [0, 0]",
            ],
            "there are 2 texture coordinates for 3 points",
        ),
        (
            [
                'texCoord2f[] primvars:st = [(0, 0)] (interpolation = "faceVarying")',
                "int[] primvars:st:indices = [0, 0, 1]",
            ],
            "values of 'uv indices' go from 0 to 1",
        ),
        (
            ['texCoord2f[] primvars:st = [] (interpolation = "faceVarying")'],
            "there are only 0 texture coordinates",
        ),
        (
            [
                "texCoord2f[] primvars:st = [(nan, 0), (0, 0), (0, 0)] "
                '(interpolation = "faceVarying")'
            ],
            None,
        ),
        (['texCoord2f[] primvars:st = [(0, 0)] (interpolation = "constant")'], None),
    ],
)
def test_texture_coordinates_that_do_not_fit(
    tmp_path: Path, lines: list[str], words: str | None
) -> None:
    """Indices and lengths that contradict the polygons are damage; the rest is passed over."""
    path = with_more(tmp_path, *lines)
    if words is None:
        assert read_in_this_process(path, tmp_path).neutral.uv is None
        return
    with pytest.raises(FormatError, match=words):
        read_in_this_process(path, tmp_path)


def test_a_corner_without_texture_coordinates(tmp_path: Path) -> None:
    """The value that stands for none may be the last of the table, or not."""
    for unauthored, left in ((1, 1), (0, 2)):
        path = with_more(
            tmp_path,
            "texCoord2f[] primvars:st = [(0.25, 0.5), (0.75, 0.5)] (",
            f'interpolation = "faceVarying"\nunauthoredValuesIndex = {unauthored})',
            "int[] primvars:st:indices = [0, 1, 1]",
        )
        uv = read_in_this_process(path, tmp_path).neutral.uv
        assert uv is not None
        assert len(uv.coordinates) == left
        assert (uv.corners == -1).tolist() == [i == unauthored for i in (0, 1, 1)]


def test_subsets_of_other_families_and_elements_are_passed_over(tmp_path: Path) -> None:
    subset = (
        'def GeomSubset "{}" {{\nuniform token elementType = "{}"\n'
        'uniform token familyName = "{}"\n{}\n}}'
    )
    path = with_more(
        tmp_path,
        subset.format("skin", "face", "materialBind", "int[] indices = [0]"),
        subset.format("other", "face", "otherFamily", "int[] indices = [0]"),
        subset.format("points", "point", "materialBind", "int[] indices = [0]"),
        subset.format("nothing", "face", "materialBind", ""),
    )
    labels = read_in_this_process(path, tmp_path).neutral.materials
    assert labels is not None
    assert labels.names == ("skin", "nothing")
    assert labels.of_face.tolist() == [0]


def test_a_material_that_is_bound_but_not_there(tmp_path: Path) -> None:
    path = with_more(tmp_path)
    bound = (
        'def Mesh "m" (prepend apiSchemas = ["MaterialBindingAPI"]) {\n'
        "rel material:binding = </none>"
    )
    path.write_text(path.read_text().replace('def Mesh "m" {', bound))
    assert read_in_this_process(path, tmp_path).neutral.materials is None


def test_another_file_that_is_damaged_is_named(tmp_path: Path) -> None:
    (tmp_path / "part.usda").write_text("#usda 1.0\n((")
    path = tmp_path / "a.usda"
    path.write_text('#usda 1.0\ndef "A" (references = @./part.usda@) {}\n')
    with pytest.raises(FormatError, match=r"part\.usda"):
        read_in_this_process(path, tmp_path)


def test_another_file_of_no_format_of_usd_is_named(tmp_path: Path) -> None:
    (tmp_path / "part.txt").write_text("#usda 1.0\n")
    path = tmp_path / "a.usda"
    path.write_text('#usda 1.0\ndef "A" (references = @./part.txt@) {}\n')
    with pytest.raises(FormatError, match=r"part\.txt"):
        read_in_this_process(path, tmp_path)


def test_a_file_shown_twice_counts_once(tmp_path: Path) -> None:
    write_usd(tmp_path / "part.usda", sample_rig())
    path = tmp_path / "a.usda"
    path.write_text(
        "#usda 1.0\n(subLayers = [@./part.usda@])\n"
        'def "A" (references = [@./part.usda@, @part.usda@]) {}\n'
    )
    rig = read_in_this_process(path, tmp_path)
    assert len(rig.neutral.vertices) == 2 * len(sample_rig().neutral.vertices)
    content = worker.content_of(str(path))
    scene = json.loads(content["scene"].tobytes())
    assert scene["size_of_others"] == (tmp_path / "part.usda").stat().st_size


def test_bends_of_another_number_are_passed_over(tmp_path: Path) -> None:
    """Where another program has cut the curved paths off, the in-betweens are read."""
    path = tmp_path / "a.usda"
    write_usd(path, sample_rig())
    lines = path.read_text().split("\n")
    place = next(i for i, line in enumerate(lines) if "elastomorph:bends = [" in line)
    start = lines[place].index(" = [") + 4
    lines[place] = lines[place][:start] + "(1, 2, 3), " + lines[place][start:]
    path.write_text("\n".join(lines))
    with pytest.warns(ElastomorphWarning, match="was changed since elastomorph wrote it"):
        assert read_in_this_process(path, tmp_path).names == sample_rig().names
