"""Images on the polygons of PLY files, as programs of photogrammetry write them."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.io.scan_colours import dressed

CORNERS = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
FACES = [(0, 1, 2), (0, 2, 3)]


def square(folder: Path, of: str, images: tuple[str, ...] = ("skin one.png",)) -> Path:
    """Two triangles with texture coordinates, those of corners in ASCII, of vertices binary."""
    for number, name in enumerate(images):
        (folder / name).write_bytes(bytes([number]))
    binary = of != "corners"
    names = of.split() if binary else []
    head = [
        "ply",
        f"format {'binary_little_endian' if binary else 'ascii'} 1.0",
        "comment made by nobody",
        *(f"comment TextureFile {name}" for name in images),
        "element vertex 4",
        *(f"property float {name}" for name in ("x", "y", "z", *names)),
        "element face 2",
        "property list uchar int vertex_indices",
        *([] if binary else ["property list uchar float texcoord", "property int texnumber"]),
        "end_header",
    ]
    content = "\n".join([*head, ""]).encode()
    if binary:
        for x, y in CORNERS:
            content += struct.pack("<5f", x, y, 0, x, y)
        for face in FACES:
            content += struct.pack("<B3i", 3, *face)
    else:
        lines = [f"{x} {y} 0" for x, y in CORNERS]
        for number, face in enumerate(FACES):
            at = " ".join(f"{u} {v}" for u, v in (CORNERS[corner] for corner in face))
            lines.append(f"3 {' '.join(map(str, face))} 6 {at} {number}")
        content += "\n".join([*lines, ""]).encode()
    (folder / "scan.ply").write_bytes(content)
    return folder / "scan.ply"


@pytest.mark.parametrize("of", ["corners", "s t", "u v", "texture_u texture_v"])
def test_texture_coordinates_of_corners_and_of_vertices(tmp_path: Path, of: str) -> None:
    mesh = em.read(square(tmp_path, of))
    assert mesh.uv is None
    found = dressed(mesh)
    assert found.uv is not None
    np.testing.assert_array_equal(
        found.uv.coordinates[found.uv.corners], mesh.vertices[:, :2][mesh.faces.indices]
    )
    texture = found.appearance["skin one.png"].texture
    assert texture is not None
    assert texture.image == b"\0"
    np.testing.assert_array_equal(found.vertices, mesh.vertices)


def test_each_polygon_shows_its_own_image(tmp_path: Path) -> None:
    found = dressed(em.read(square(tmp_path, "corners", ("a.png", "b.png"))))
    assert found.materials is not None
    assert [found.materials.names[n] for n in found.materials.of_face] == ["a.png", "b.png"]
    # Only the first of them is named: what the second polygon shows nobody knows.
    found = dressed(em.read(square(tmp_path, "corners", ("a.png",))))
    assert found.materials is not None
    assert found.materials.of_face.tolist() == [0, -1]


def test_an_image_that_is_not_there_says_so(tmp_path: Path) -> None:
    file = square(tmp_path, "s t")
    (tmp_path / "skin one.png").unlink()
    texture = dressed(em.read(file)).appearance["skin one.png"].texture
    assert texture is not None
    assert texture.problem == "there is no such image in the folder of the mesh"


def test_a_file_that_names_no_image_is_as_it_was(tmp_path: Path) -> None:
    file = square(tmp_path, "s t", ())
    mesh = em.read(file)
    assert dressed(mesh) is mesh
    file.unlink()
    assert dressed(mesh) is mesh


def test_coordinates_that_fit_no_corners_are_told(tmp_path: Path) -> None:
    file = square(tmp_path, "corners")
    file.write_text(file.read_text().replace("6 0.0 0.0", "4", 1))
    with pytest.raises(em.FormatError, match="two numbers for each corner"):
        dressed(em.read(file))
