"""OBJ files are read as they are: vertex order, polygons and labels as the author gave them."""

from __future__ import annotations

import re
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_samples import assert_same_mesh, label_names

from effort import worked
from elastomorph.errors import ElastomorphError, ElastomorphWarning, FormatError
from elastomorph.io.npz import read_npz, write_npz
from elastomorph.io.obj import read_obj, write_obj
from elastomorph.model.mesh import FaceLabels, Mesh

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def read_text(folder: Path, text: str | bytes) -> Mesh:
    path = folder / "mesh.obj"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_obj(path)


def test_vertices_keep_their_order_and_polygons_their_size(tmp_path: Path) -> None:
    """Unused and doubled vertices stay; a triangle, a quad and a pentagon stay what they are."""
    mesh = read_text(
        tmp_path,
        "v 9 9 9\nv 0 0 0\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
        "f 2 4 5\nf 3 4 5 6\nf 2 3 4 5 6\nf 5 4 2\n",
    )
    assert mesh.vertices.tolist() == [
        [9, 9, 9], [0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0],
    ]  # fmt: skip
    assert [face.tolist() for face in mesh.faces] == [
        [1, 3, 4], [2, 3, 4, 5], [1, 2, 3, 4, 5], [4, 3, 1],
    ]  # fmt: skip


@pytest.mark.parametrize(
    "corners",
    [
        "1 2 3",
        "1/1 2/2 3/3",
        "1//1 2//1 3//1",
        "1/1/1 2/2/1 3/3/1",
        "1/1/1 2//1 3/3",
        "1/ 2// 3",
        "+1 +2 +3",
        "-4 -3 -2",
        "-4/-3/-1 2/-2/1 -2/3/9",
        "1\t2   3 ",
        "1 2 \\\n3",
        "\\\n1 2\\\n3\\\n",
        "1 2 3 # a corner",
        "1 2 3#comment \\",
    ],
)
def test_every_way_to_write_the_corners_gives_the_same_polygon(
    tmp_path: Path, corners: str
) -> None:
    mesh = read_text(
        tmp_path, SQUARE + "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n" + f"f {corners}\nf 2 3 4"
    )
    assert [face.tolist() for face in mesh.faces] == [[0, 1, 2], [1, 2, 3]]


def test_relative_indices_count_back_from_their_own_line(tmp_path: Path) -> None:
    mesh = read_text(
        tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -4 -3 -1\nvt 0 0\nf -1 -2 -3\n"
    )
    assert [face.tolist() for face in mesh.faces] == [[0, 1, 2], [0, 1, 3], [3, 2, 1]]


def test_polygons_may_come_before_their_vertices(tmp_path: Path) -> None:
    mesh = read_text(tmp_path, "f 1 2 3\n" + SQUARE)
    assert mesh.faces[0].tolist() == [0, 1, 2]


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("last", [True, False])
def test_lines_may_end_in_any_way(tmp_path: Path, newline: str, last: bool) -> None:
    text = "# head\n\n" + SQUARE + "usemtl skin\nf 1 2 \\\n3\nf 1 3 4" + "\n" * last
    mesh = read_text(tmp_path, text.replace("\n", newline).encode())
    assert [face.tolist() for face in mesh.faces] == [[0, 1, 2], [0, 2, 3]]
    assert mesh.source is not None
    assert mesh.source.face_lines is not None
    assert mesh.source.face_lines.tolist() == [8, 10]
    assert label_names(mesh.materials) == ["skin", "skin"]


@pytest.mark.parametrize("columns", ["", " 1", " 0.5 0.5 0.5", " 1 .1 .2 .3"])
def test_weight_and_colour_are_passed_over(tmp_path: Path, columns: str) -> None:
    text = "\n".join(line + columns for line in SQUARE.splitlines())
    assert_same_mesh(read_text(tmp_path, text), read_text(tmp_path, SQUARE))


def test_only_some_vertices_may_have_colours(tmp_path: Path) -> None:
    mesh = read_text(tmp_path, "v 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0 1\n")
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]


@pytest.mark.parametrize(
    "number",
    [
        *("1", "-1", "+1", "1.", ".5", "-.5", "1e3", "1E-3", "1.5e+3", "0.1", "00012", "-0"),
        *("123456789.123456789", "9007199254740993", "0.30000000000000004", "1e-400", "5e-324"),
        *("2.2250738585072011e-308", "1.7976931348623157e74"),
    ],
)
def test_numbers_are_read_as_python_reads_them(tmp_path: Path, number: str) -> None:
    mesh = read_text(tmp_path, f"v {number} 0 0\nv 0 {number} 1e0\n")
    expected = np.array([[float(number), 0, 0], [0, float(number), 1]])
    assert mesh.vertices.tobytes() == expected.tobytes()


def test_materials_and_groups_label_the_polygons_below_them(tmp_path: Path) -> None:
    mesh = read_text(
        tmp_path,
        "mtllib a.mtl\n" + SQUARE + "f 1 2 3\nusemtl skin\ng left cheek\nf 1 2 3\nusemtl unused\n"
        "usemtl Material #25\nf 1 2 3\no Teeth # upper\nf 1 2 3\ng\nusemtl skin\nf 1 2 3\n"
        "mtllib b.mtl\nmtllib a.mtl\n",
    )
    assert mesh.materials is not None
    assert mesh.materials.names == ("skin", "Material #25")
    assert label_names(mesh.materials) == [None, "skin", "Material #25", "Material #25", "skin"]
    assert label_names(mesh.groups) == [None, "left cheek", "left cheek", "Teeth", None]
    assert mesh.material_library == "a.mtl b.mtl"


def test_a_mesh_without_labels_has_none(tmp_path: Path) -> None:
    mesh = read_text(tmp_path, SQUARE + "f 1 2 3 4\nusemtl later\n")
    assert mesh.materials is mesh.groups is mesh.uv is mesh.material_library is None


def test_names_may_have_letters_of_any_script(tmp_path: Path) -> None:
    mesh = read_text(tmp_path, SQUARE + "usemtl Haut_weiß\ng 頬\nf 1 2 3\n")
    assert label_names(mesh.materials) == ["Haut_weiß"]
    assert label_names(mesh.groups) == ["頬"]


def test_a_comment_may_have_any_bytes_and_end_in_a_backslash(tmp_path: Path) -> None:
    """A comment is not continued: what follows a folder's name is a statement of its own."""
    mesh = read_text(tmp_path, b"\xef\xbb\xbf# from C:\\faces\\\nv 1 2 3 # M\xfcller \\\nv 4 5 6\n")
    assert mesh.vertices.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_texture_coordinates_have_two_columns_or_three(tmp_path: Path) -> None:
    face = "f 1/1 2/2 3\n"
    for rows, expected in (
        ("vt 0.5\nvt 1\n", [[0.5, 0], [1, 0]]),
        ("vt 0.5 1\nvt 1 2\n", [[0.5, 1], [1, 2]]),
        ("vt 0.5 1 2\nvt 1 2 3\n", [[0.5, 1, 2], [1, 2, 3]]),
        ("vt 0.5\nvt 1 2 3\n", [[0.5, 0, 0], [1, 2, 3]]),
    ):
        uv = read_text(tmp_path, SQUARE + rows + face).uv
        assert uv is not None
        assert uv.coordinates.tolist() == expected
        assert uv.corners.tolist() == [0, 1, -1]


def test_statements_that_are_not_polygons_are_passed_over(tmp_path: Path) -> None:
    mesh = read_text(
        tmp_path,
        SQUARE + "vn nan nan nan\nvp 1 2\ns off\ns 1\nl 1 2 3\np 1\nlod 2\nmg 1 0.5\n"
        "cstype bspline\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 1\nend\n  f 1 2 3\n",
    )
    assert len(mesh.vertices) == 4
    assert [face.tolist() for face in mesh.faces] == [[0, 1, 2]]


def test_points_without_polygons_are_a_mesh(tmp_path: Path) -> None:
    assert len(read_text(tmp_path, SQUARE).faces) == 0


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_other_encodings_are_refused_with_advice(tmp_path: Path, encoding: str) -> None:
    with pytest.raises(FormatError, match="UTF-8"):
        read_text(tmp_path, (SQUARE + "f 1 2 3\n").encode(encoding))


def test_a_nul_byte_is_refused_where_it_stands(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"mesh\.obj, line 5: a NUL byte"):
        read_text(tmp_path, SQUARE + "# \0\n")


@pytest.mark.parametrize("newline", ["\n", ""])
def test_nul_bytes_at_the_end_are_padding(tmp_path: Path, newline: str) -> None:
    """ZBrush ends its files in one."""
    text = SQUARE + "f 1 2 3" + newline
    padded = read_text(tmp_path, text.encode() + b"\0\0\0")
    assert_same_mesh(padded, read_text(tmp_path, text))


@pytest.mark.parametrize(
    ("name", "encoding"),
    [("Haut_weiß", "latin-1"), ("頬ソ", "shift-jis"), ("漢 字", "shift-jis"), ("頬ソ", "utf-8")],
)
def test_names_of_any_encoding_come_back_byte_for_byte(
    tmp_path: Path, name: str, encoding: str
) -> None:
    """The last byte of ソ in Shift-JIS is a backslash, which continues no line there."""
    raw = name.encode(encoding)
    lines = [b"mtllib %b.mtl", b"v 0.0 0.0 0.0", b"v 1.0 0.0 0.0", b"v 1.0 1.0 0.0"]
    lines += [b"g %b", b"usemtl %b", b"f 1 2 3", b"usemtl plain", b"f 3 2 1", b""]
    text = b"\n".join(lines).replace(b"%b", raw)
    mesh = read_text(tmp_path, text)
    assert mesh.materials is not None
    assert mesh.groups is not None
    shown = name if encoding != "shift-jis" else raw.decode("latin-1")
    assert mesh.materials.names == (shown, "plain")
    assert mesh.groups.names == (shown,)
    shown.encode("utf-8")  # what a terminal and JSON do
    write_obj(tmp_path / "again.obj", mesh.with_vertices(mesh.vertices))
    assert (tmp_path / "again.obj").read_bytes() == text
    write_npz(tmp_path / "kept.npz", mesh)
    write_obj(tmp_path / "again.obj", read_npz(tmp_path / "kept.npz"))
    assert (tmp_path / "again.obj").read_bytes() == text


def test_a_name_that_the_encoding_lacks_makes_the_file_utf_8(tmp_path: Path) -> None:
    mesh = read_text(tmp_path, SQUARE.encode() + b"usemtl wei\xdf\nf 1 2 3\n")
    assert mesh.materials is not None
    labels = FaceLabels(("頬", *mesh.materials.names), mesh.materials.of_face + 1)
    named = Mesh(mesh.vertices, mesh.faces, materials=labels, source=mesh.source)
    write_obj(tmp_path / "new.obj", named)
    again = read_obj(tmp_path / "new.obj")
    assert label_names(again.materials) == ["weiß"]


@pytest.mark.parametrize(
    "faces",
    [
        "f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\n",
        "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
        "f 1/0 2/0 3/0\nf 1/-1 3/-2 4/9 # strict\n",
    ],
)
def test_texture_indices_without_texture_coordinates_are_passed_over(
    tmp_path: Path, faces: str
) -> None:
    with pytest.warns(
        ElastomorphWarning, match=r"mesh\.obj, line 5: .* no vt lines.*\(2 in"
    ) as said:
        mesh = read_text(tmp_path, SQUARE + faces)
    assert len(said) == 1
    assert mesh.uv is None
    assert [face.tolist() for face in mesh.faces] == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("stray", "words"),
    [("f 1 2", "two corners"), ("vw 1 2 3", "'vw' is no keyword"), ("t 0 0", "'t' is no keyword")],
)
def test_lines_that_show_no_surface_are_passed_over(tmp_path: Path, stray: str, words: str) -> None:
    text = SQUARE + "f 1 2 3\n" + f"{stray}\n" * 3 + "f 1 3 4\n"
    with pytest.warns(ElastomorphWarning, match=rf"mesh\.obj, line 6: .*{words}.*\(3 in"):
        mesh = read_text(tmp_path, text)
    assert [face.tolist() for face in mesh.faces] == [[0, 1, 2], [0, 2, 3]]
    assert mesh.source is not None
    assert mesh.source.face_lines is not None
    assert mesh.source.face_lines.tolist() == [5, 9]


def strangely(text: str) -> str:
    """The same mesh in statements that no table holds: signs, and one vertex with a weight."""
    lines = []
    for number, line in enumerate(text.splitlines()):
        keyword, *words = line.split()
        if keyword == "f":
            words = [re.sub("([0-9]+)", r"+\1", word) for word in words]
        lines.append(" ".join([keyword, *words]) + " 1" * (number == 0))
    return "\n".join(lines)


@pytest.mark.parametrize("corner", ["{v}", "{v}/{t}", "{v}//{n}", "{v}/{t}/{n}"])
@given(random=st.randoms(use_true_random=False))
@settings(max_examples=60, deadline=None)
def test_statements_read_together_are_those_read_one_by_one(
    tmp_path_factory: pytest.TempPathFactory, corner: str, random: Random
) -> None:
    def numbers(count: int) -> str:
        return " ".join(
            repr(random.uniform(-9, 9) * 10 ** random.randint(-9, 9)) for _ in "x" * count
        )

    def face() -> str:
        counts = {"v": len(vertices), "t": len(texture), "n": 99}
        return " ".join(
            corner.format(**{key: random.randint(1, most) for key, most in counts.items()})
            for _ in range(random.randint(3, 6))
        )

    vertices = [f"v {numbers(3)}" for _ in range(random.randint(1, 9))]
    texture = [f"vt {numbers(2)}" for _ in range(random.randint(1, 9))]
    faces = [f"f {face()}" for _ in range(random.randint(0, 9))]
    text = "\n".join([*vertices, *texture, *faces])
    folder = tmp_path_factory.getbasetemp()
    assert_same_mesh(read_text(folder, strangely(text)), read_text(folder, text))


@pytest.mark.parametrize(
    ("faces", "texture"),
    [
        ("f 1/1 2/1/1 3\n", [0, 0, -1]),  # as many slashes as corners, and as many numbers twice
        ("f 1//1 2/1/1 3//1\n", [-1, 0, -1]),
        ("f 1//1 2/1/1 3/1/1\nf 1//1 2//1 3//1\n", [-1, 0, 0, -1, -1, -1]),
        ("f 1/1 2/ 3/1/1\n", [0, -1, 0]),
        ("f 1//1 2//1 3//99999999999999999999\n", [-1, -1, -1]),
        ("f 1/1 2/1 00000000000000000000000000003/1\n", [0, 0, 0]),
    ],
)
def test_corners_written_in_several_ways_are_not_taken_for_one(
    tmp_path: Path, faces: str, texture: list[int]
) -> None:
    mesh = read_text(tmp_path, SQUARE + "vt 0 0\n" + faces)
    assert mesh.uv is not None
    assert mesh.uv.corners.tolist() == texture
    assert {tuple(face.tolist()) for face in mesh.faces} == {(0, 1, 2)}


@pytest.mark.realdata
def test_a_production_mesh_has_the_polygons_a_plain_count_finds(data_dir: Path) -> None:
    path = data_dir / "ict-facekit" / "generic_neutral_mesh.obj"
    mesh = read_obj(path)
    lines = path.read_text().splitlines()
    positions = [list(map(float, line.split()[1:])) for line in lines if line.startswith("v ")]
    polygons = [
        [int(corner.split("/")[0]) - 1 for corner in line.split()[1:]]
        for line in lines
        if line.startswith("f ")
    ]
    assert mesh.vertices.tolist() == positions
    assert [face.tolist() for face in mesh.faces] == polygons
    assert sorted(set(mesh.faces.sizes.tolist())) == [3, 4]
    assert mesh.source is not None
    assert mesh.source.face_lines is not None
    assert all(lines[line - 1].startswith("f ") for line in mesh.source.face_lines)
    assert mesh.materials is not None
    assert mesh.materials.names[0] == "M_Face"


@pytest.mark.realdata
def test_damaged_files_load_or_are_refused_by_line_within_two_seconds(data_dir: Path) -> None:
    files = sorted((data_dir / "malformed" / "obj").iterdir())
    assert len(files) == 255
    complaints = {}
    for file in files:
        before = worked()
        try:
            read_obj(file)
        except ElastomorphError as error:
            complaints[file.name] = str(error)
        assert worked() - before < 2, file.name
    assert len(complaints) > 200
    assert all(name in complaint for name, complaint in complaints.items())
