"""An OBJ with its library and images, as scanners and photogrammetry write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.io.mtl import library_of, with_looks

OBJ = """mtllib scan.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 1 1 0
vt 0 0
vt 1 0
vt 0 1
usemtl skin
f 1/1 2/2 3/3
usemtl shirt
f 2/1 4/2 3/3
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "scan.obj").write_text(OBJ)
    (tmp_path / "skin 01.jpg").write_bytes(b"an image")
    return tmp_path


def looked(folder: Path, library: str) -> em.Mesh:
    (folder / "scan.mtl").write_text(library)
    return with_looks(em.read(folder / "scan.obj"))


def test_an_image_and_a_colour(folder: Path) -> None:
    mesh = looked(
        folder,
        "# by a scanner\nnewmtl skin\nKa 1 1 1\nKd 0.8 0.8 0.8\nmap_Kd skin 01.jpg\n\n"
        "newmtl shirt\nKd 1 0.5 0\nd 0.25\nnewmtl unused\nKd 0 0 0\n",
    )
    assert mesh.appearance is not None
    assert set(mesh.appearance) == {"skin", "shirt"}
    skin, shirt = mesh.appearance["skin"], mesh.appearance["shirt"]
    assert skin.texture is not None
    assert (skin.texture.image, skin.texture.name) == (b"an image", "skin 01.jpg")
    assert skin.colour == (1.0, 1.0, 1.0, 1.0)
    assert shirt.texture is None
    assert shirt.colour == pytest.approx((1.0, 0.21404114, 0.0, 0.25))
    assert shirt.opacity == "blend"
    np.testing.assert_array_equal(mesh.vertices, em.read(folder / "scan.obj").vertices)


@pytest.mark.parametrize(
    "named",
    [
        r"C:\Users\me\scans\skin 01.jpg",
        "/home/me/skin 01.jpg",
        "./skin 01.jpg",
        '"skin 01.jpg"',
        "-clamp on skin 01.jpg",
        "-s 1 1 1 -o 0 0 0 skin 01.jpg",
        "-bm 0.5 -blendu off skin 01.jpg",
    ],
)
def test_the_image_is_found_beside_the_mesh(folder: Path, named: str) -> None:
    mesh = looked(folder, f"newmtl skin\nmap_Kd {named}\n")
    assert mesh.appearance is not None
    texture = mesh.appearance["skin"].texture
    assert texture is not None
    assert texture.image == b"an image"
    assert texture.wrap == (("clamp", "clamp") if "-clamp" in named else ("repeat", "repeat"))


def test_options_move_the_image(folder: Path) -> None:
    """(u, v) shows the image at s (u, v) + o, counted from its bottom."""
    mesh = looked(folder, "newmtl skin\nmap_Kd -s 2 3 -o 0.1 0.2 skin 01.jpg\n")
    assert mesh.appearance is not None
    texture = mesh.appearance["skin"].texture
    assert texture is not None
    u, v = 0.3, 0.4
    across = texture.offset[0] + texture.scale[0] * u
    from_top = texture.offset[1] + texture.scale[1] * (1 - v)
    assert (across, 1 - from_top) == pytest.approx((2 * u + 0.1, 3 * v + 0.2))


@pytest.mark.parametrize("named", ["missing.jpg", "../outside.jpg", "/etc/passwd", ".", "a\0b", ""])
def test_what_is_not_there_is_told(folder: Path, named: str) -> None:
    """Nor is anything read that lies elsewhere."""
    (folder.parent / "outside.jpg").write_bytes(b"secret")
    mesh = looked(folder, f"newmtl skin\nKd 1 0 0\nmap_Kd {named}\n")
    assert mesh.appearance is not None
    texture = mesh.appearance["skin"].texture
    if not named:
        assert texture is None
        return
    assert texture is not None
    assert texture.image == b""
    assert "no such image" in texture.problem


def test_of_several_libraries_the_first_that_is_there_counts(folder: Path) -> None:
    """Names with blanks are tried as a whole before they are taken for several."""
    (folder / "scan.obj").write_text(OBJ.replace("scan.mtl", "gone.mtl my head.mtl"))
    (folder / "head.mtl").write_text("newmtl skin\nKd 1 0 0\n")
    mesh = em.read(folder / "scan.obj")
    assert library_of(mesh) == folder / "head.mtl"
    assert set(with_looks(mesh).appearance or {}) == {"skin"}
    (folder / "gone.mtl my head.mtl").write_text("newmtl shirt\nKd 1 0 0\n")
    assert set(with_looks(mesh).appearance or {}) == {"shirt"}


@pytest.mark.parametrize("place", ["../head.mtl", "gone.mtl"])
def test_a_library_elsewhere_is_none(folder: Path, place: str) -> None:
    (folder.parent / "head.mtl").write_text("newmtl skin\nKd 1 0 0\n")
    (folder / "scan.obj").write_text(OBJ.replace("scan.mtl", place))
    mesh = em.read(folder / "scan.obj")
    assert library_of(mesh) is None
    assert with_looks(mesh) is mesh


def test_of_one_material_nobody_needs_to_say_where_it_is(folder: Path) -> None:
    (folder / "scan.obj").write_text(
        "".join(line for line in OBJ.splitlines(True) if not line.startswith("usemtl"))
    )
    mesh = looked(folder, "newmtl skin\nmap_Kd skin 01.jpg\n")
    assert mesh.materials is not None
    assert mesh.materials.names == ("skin",)
    assert set(mesh.appearance or {}) == {"skin"}
    two = looked(folder, "newmtl skin\nmap_Kd skin 01.jpg\nnewmtl shirt\nKd 1 0 0\n")
    assert two.appearance is None, "which of two nobody said"


def test_meshes_without_looks_stay_as_they_are(folder: Path) -> None:
    plain = em.read(folder / "scan.obj")
    assert with_looks(plain) is plain, "there is no library"
    assert looked(folder, "newmtl skin\nKd 0.5 0.5 0.5\n").appearance is None, "grey says nothing"
    assert looked(folder, "").appearance is None
    bare = em.Mesh(np.eye(3), [[0, 1, 2]])
    assert with_looks(bare) is bare


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=200)
@given(st.lists(st.text('newmtl skinapKd map_Kd-so.01 /\\\n\t"#é', max_size=30), max_size=12))
def test_no_library_breaks_the_reading(folder: Path, lines: list[str]) -> None:
    mesh = looked(folder, "newmtl skin\n" + "\n".join(lines))
    assert len(mesh.vertices) == 4
