"""PLY files of every encoding hold the same mesh, whatever else is in them."""

from __future__ import annotations

import struct
import tracemalloc
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_samples import assert_same_surface, house, meshes

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.ply import Encoding, read_ply, write_ply
from elastomorph.model.mesh import Mesh
from needs import extra

ENCODINGS: tuple[Encoding, ...] = get_args(Encoding)

ASCII = """ply
format ascii 1.0
comment a house
obj_info of two polygons
element vertex 5
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
1 1 0
0 1 0
0.5 1.5 0
4 0 1 2 3
3 3 2 4
"""
POSITIONS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 1.5, 0]]
POLYGONS = [[0, 1, 2, 3], [3, 2, 4]]


def read_content(folder: Path, content: str | bytes) -> Mesh:
    path = folder / "mesh.ply"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_ply(path)


def assert_house(mesh: Mesh) -> None:
    assert mesh.vertices.tolist() == POSITIONS
    assert [face.tolist() for face in mesh.faces] == POLYGONS


def packed(order: str, *parts: tuple[str, Any]) -> bytes:
    """Numbers as they stand in a binary file, one format character and one value or list each."""
    return b"".join(
        struct.pack(order + kind * np.size(values), *np.ravel(values).tolist())
        for kind, values in parts
    )


@given(mesh=meshes(), encoding=st.sampled_from(ENCODINGS))
@settings(max_examples=100, deadline=None)
def test_every_encoding_gives_the_mesh_back(
    tmp_path_factory: pytest.TempPathFactory, mesh: Mesh, encoding: Encoding
) -> None:
    path = tmp_path_factory.getbasetemp() / "round-trip.ply"
    write_ply(path, mesh, encoding)
    assert_same_surface(read_ply(path), mesh)


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("size", [255, 256, 300])
def test_polygons_of_more_than_255_corners(tmp_path: Path, encoding: Encoding, size: int) -> None:
    angles = np.linspace(0, 2 * np.pi, size, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    mesh = Mesh(ring, [list(range(size)), [0, 1, 2]])
    write_ply(tmp_path / "ring.ply", mesh, encoding)
    assert_same_surface(read_ply(tmp_path / "ring.ply"), mesh)


def test_the_ascii_text_is_what_one_would_write_by_hand(tmp_path: Path) -> None:
    write_ply(tmp_path / "a.ply", Mesh(POSITIONS, POLYGONS), "ascii")
    assert (tmp_path / "a.ply").read_text() == (
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty double x\nproperty double y\n"
        "property double z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
        "0.0 0.0 0.0\n1.0 0.0 0.0\n1.0 1.0 0.0\n0.0 1.0 0.0\n0.5 1.5 0.0\n4 0 1 2 3\n3 3 2 4\n"
    )


@pytest.mark.parametrize(("encoding", "order"), [(ENCODINGS[1], "<"), (ENCODINGS[2], ">")])
def test_the_binary_bytes_are_those_of_the_specification(
    tmp_path: Path, encoding: Encoding, order: str
) -> None:
    write_ply(tmp_path / "a.ply", Mesh(POSITIONS, POLYGONS), encoding)
    body = (tmp_path / "a.ply").read_bytes().partition(b"end_header\n")[2]
    faces: list[tuple[str, Any]] = [("B", 4), ("i", POLYGONS[0]), ("B", 3), ("i", POLYGONS[1])]
    assert body == packed(order, ("d", POSITIONS), *faces)


def test_another_encoding_is_refused(tmp_path: Path) -> None:
    wrong: Any = "binary"
    with pytest.raises(ParameterError, match="binary_little_endian"):
        write_ply(tmp_path / "a.ply", house(), wrong)


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_ascii_lines_may_end_in_any_way(tmp_path: Path, newline: str) -> None:
    assert_house(read_content(tmp_path, ASCII.replace("\n", newline)))
    assert_house(read_content(tmp_path, ASCII.rstrip().replace("\n", newline)))


def test_blank_lines_do_not_matter(tmp_path: Path) -> None:
    head, mark, body = ASCII.partition("end_header\n")
    assert_house(read_content(tmp_path, head + mark + body.replace("\n", "\n\n \n")))


@pytest.mark.parametrize("newline", [b"\n", b"\r\n", b"\r"])
@pytest.mark.parametrize(("encoding", "order"), [(ENCODINGS[1], "<"), (ENCODINGS[2], ">")])
def test_binary_files_of_all_types_and_with_all_kinds_of_other_elements(
    tmp_path: Path, newline: bytes, encoding: str, order: str
) -> None:
    """Other elements before, between and after; other properties, lists among them, anywhere."""
    header = f"""ply
format {encoding} 1.0
comment the first body byte is a line feed: 0x0A
element flag 2
property uchar kind
element strip 2
property list ushort double weights
property short after
element vertex 5
property uchar red
property short x
property list uchar ushort neighbours
property double z
property float y
element nothing 7
element face 2
property char sign
property list uint ushort vertex_index
property list uchar float texcoord
element edge 1
property int vertex1
property int vertex2
end_header
"""
    positions = np.array(POSITIONS) * 2
    body = packed(order, ("B", [10, 13]))
    body += packed(order, ("H", 2), ("d", [1, 2]), ("h", -1), ("H", 0), ("h", 7))
    for i, (x, y, z) in enumerate(positions.tolist()):
        body += packed(
            order, ("B", 10), ("h", int(x)), ("B", i), ("H", [9] * i), ("d", z), ("f", y)
        )
    for polygon in POLYGONS:
        body += packed(order, ("b", -1), ("I", len(polygon)), ("H", polygon), ("B", 1), ("f", 0.5))
    body += packed(order, ("i", [0, 1]))
    mesh = read_content(tmp_path, header.encode().replace(b"\n", newline) + body)
    assert (mesh.vertices / 2).tolist() == POSITIONS
    assert [face.tolist() for face in mesh.faces] == POLYGONS


def test_ascii_files_with_other_elements_and_properties(tmp_path: Path) -> None:
    mesh = read_content(
        tmp_path,
        """ply
format ascii 1.0
element material 1
property int shine
property list uchar int parts
element vertex 3
property list uchar float weights
property double z
property uchar red
property double x
property double y
element nothing 5
element face 1
property list uchar float texcoord
property list uchar int vertex_index
property int group
end_header
7 2 1 2
0 0.5 255 1 2
2 .1 .2 1.5 255 3 4
1 1 2.5 255 5 6
2 0.5 0.5 3 2 1 0 99
""",
    )
    assert mesh.vertices.tolist() == [[1, 2, 0.5], [3, 4, 1.5], [5, 6, 2.5]]
    assert [face.tolist() for face in mesh.faces] == [[2, 1, 0]]


@pytest.mark.parametrize(
    ("kind", "code"),
    [
        *(("char", "b"), ("int8", "b"), ("uchar", "B"), ("uint8", "B"), ("short", "h")),
        *(("int16", "h"), ("ushort", "H"), ("uint16", "H"), ("int", "i"), ("int32", "i")),
        *(("uint", "I"), ("uint32", "I"), ("float", "f"), ("float32", "f")),
        *(("double", "d"), ("float64", "d")),
    ],
)
def test_coordinates_may_be_of_any_type(tmp_path: Path, kind: str, code: str) -> None:
    numbers = packed("<", (code, [[1, 2, 3], [4, 5, 6]]))
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 2\n"
    header += "".join(f"property {kind} {axis}\n" for axis in "xyz") + "end_header\n"
    mesh = read_content(tmp_path, header.encode() + numbers)
    assert mesh.vertices.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert len(mesh.faces) == 0


def edited(old: str, new: str) -> str:
    assert old in ASCII
    return ASCII.replace(old, new)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "not a PLY file"),
        ("plyformat ascii 1.0\n", "not a PLY file"),
        ("v 0 0 0\n", "not a PLY file"),
        ("ply\nformat ascii 1.0\n", "no line 'end_header'"),
        ("ply\nend_header\n", "no line 'format'"),
        ("ply\nformat ascii 1.0\nend_header\n", "no vertices: the header has no 'element vertex'"),
        (edited("format ascii", "format text"), "line 2: expected 'format'"),
        (edited("1.0\n", "2.0\n"), "line 2: expected 'format'"),
        (edited("vertex 5", "vertex five"), "line 5: expected 'element'"),
        (edited("vertex 5", "vertex -5"), "line 5: expected 'element'"),
        (edited("vertex 5", "vertex 0"), "no vertices: the header says 'element vertex 0'"),
        (edited("float y", "half y"), "line 7: expected 'property TYPE NAME'"),
        (edited("float y", "list x"), "line 7: expected 'property TYPE NAME'"),
        (edited("uchar int", "float int"), "list INTEGER-TYPE"),
        (edited("comment a", "remark a"), "line 3: expected format, then element"),
        (edited("element vertex 5\n", ""), "line 5: expected format, then element"),
        (edited("float z", "float w"), "no property 'z'"),
        (edited("float z", "list uchar float z"), "no property 'z' that is a number"),
        (edited("uchar int", "uchar float"), "no list of whole numbers"),
        (edited("vertex_indices", "corners"), "called 'vertex_indices'"),
        (edited("element face 2", "element tristrips 2"), "triangle strips"),
        (edited("vertex 5", "vertex 4"), "line 16: expected the numbers of one 'face'"),
        (edited("face 2", "face 1"), "line 18: there are more lines"),
        (edited("face 2", "face 3"), "announces 3 rows of 'face', but only 2 lines"),
        (edited("0.5 1.5 0\n", "0.5 1.5\n"), r"line 16: .* \(x y z\), found '0.5 1.5'"),
        (edited("0.5 1.5 0\n", "0.5 1.5 0 0\n"), "line 16: expected the numbers"),
        (edited("0.5 1.5 0\n", "0.5 1_5 0\n"), "line 16: expected the numbers"),
        (edited("0.5 1.5 0\n", "0.5 nan 0\n"), "vertex 4 has the coordinates"),
        (edited("3 3 2 4\n", "3 3 2\n"), "line 18: expected the numbers of one 'face'"),
        (edited("3 3 2 4\n", "3 3 2 4 4\n"), "line 18: expected"),
        (edited("3 3 2 4\n", "-1\n"), "line 18: expected"),
        (edited("3 3 2 4\n", "2 3 2\n"), "polygon 1 has 2 vertices"),
        (edited("3 3 2 4\n", "3 3 2 5\n"), "names vertex 5, but the mesh has 5"),
        (edited("3 3 2 4\n", "3 3 2 -1\n"), "below 0"),
        (edited("3 3 2 4\n", f"3 3 2 {2**40}\n"), "far beyond"),
        (edited("3 3 2 4\n", f"3 3 2 {10**30}\n"), "too large"),
    ],
)
def test_wrong_files_are_refused(tmp_path: Path, content: str, words: str) -> None:
    with pytest.raises(FormatError, match=words) as caught:
        read_content(tmp_path, content)
    assert "mesh.ply" in str(caught.value)


def test_binary_files_cut_off_or_with_more_than_announced_are_refused(tmp_path: Path) -> None:
    write_ply(tmp_path / "a.ply", house())
    whole = (tmp_path / "a.ply").read_bytes()
    for content, words in (
        (whole[:-1], "cut off"),
        (whole.replace(b"face 2", b"face 3"), "cut off"),
        (whole.replace(b"face 2", b"face 1"), "13 bytes follow the last row"),
        (whole.replace(b"vertex 5", b"vertex 6"), "4 bytes follow the last row"),
        (
            whole.replace(b"list uchar", b"list char").replace(b"\x04\0\0\0\0", b"\xff\0\0\0\0"),
            "-1",
        ),
    ):
        with pytest.raises(FormatError, match=words):
            read_content(tmp_path, content)
    assert_same_surface(read_content(tmp_path, whole + b"\n"), house())


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("element", ["vertex", "face", "other"])
def test_absurd_counts_are_refused_before_anything_is_allocated(
    tmp_path: Path, encoding: str, element: str
) -> None:
    numbers = {"vertex": "3", "face": "1", "other": "1", element: "9" * 18}
    header = f"ply\nformat {encoding} 1.0\n"
    header += f"element other {numbers['other']}\nproperty list uchar int a\n"
    header += f"element vertex {numbers['vertex']}\n"
    header += "property char x\nproperty char y\nproperty char z\n"
    header += f"element face {numbers['face']}\nproperty list int int vertex_indices\nend_header\n"
    body = b"0\n1 2 3\n" * 200
    (tmp_path / "a.ply").write_bytes(header.encode() + body)
    tracemalloc.start()
    try:
        with pytest.raises(FormatError):
            read_ply(tmp_path / "a.ply")
        assert tracemalloc.get_traced_memory()[1] < 4 << 20
    finally:
        tracemalloc.stop()


def test_a_list_longer_than_the_file_is_refused_before_anything_is_allocated(
    tmp_path: Path,
) -> None:
    header = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty char x\nproperty char y\n"
        "property char z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n"
    )
    tracemalloc.start()
    try:
        with pytest.raises(FormatError, match="4,294,967,295 values"):
            read_content(tmp_path, header.encode() + b"\1\1\1" + b"\xff" * 4 + b"\0" * 40)
        assert tracemalloc.get_traced_memory()[1] < 4 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_another_program_reads_the_same_mesh(tmp_path: Path, encoding: Encoding) -> None:
    """VTK's reader, an independent one, finds our polygons and (in float32) our positions."""
    extra("vtkmodules", "demo")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOPLY import vtkPLYReader

    mesh = Mesh(POSITIONS, POLYGONS)
    write_ply(tmp_path / "a.ply", mesh, encoding)
    reader = vtkPLYReader()
    reader.SetFileName(str(tmp_path / "a.ply"))
    reader.Update()
    found = reader.GetOutput()
    assert vtk_to_numpy(found.GetPoints().GetData()).tolist() == POSITIONS
    cells = found.GetPolys()
    assert vtk_to_numpy(cells.GetConnectivityArray()).tolist() == mesh.faces.indices.tolist()
    assert vtk_to_numpy(cells.GetOffsetsArray()).tolist() == mesh.faces.offsets.tolist()
