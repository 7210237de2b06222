"""Material libraries of OBJ files: colours, images, and what cannot be had."""

from __future__ import annotations

from pathlib import Path

import pytest

from elastomorph.io.obj.materials import read_materials


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    own = tmp_path / "scans"
    own.mkdir()
    (own / "skin.png").write_bytes(b"image")
    (own / "my skin.png").write_bytes(b"spaced")
    (tmp_path / "outside.png").write_bytes(b"secret")
    return own


def written(folder: Path, text: str) -> Path:
    (folder / "head.mtl").write_text(text)
    return folder / "head.obj"


def test_colours_and_images(folder: Path) -> None:
    obj = written(folder, "newmtl skin\nKd 0.5 1 2\nmap_Kd skin.png\nnewmtl plain\n# end\n")
    found = read_materials(obj, "head.mtl")
    assert list(found) == ["skin", "plain"]
    assert found["skin"].colour == (0.5, 1.0, 1.0, 1.0)
    assert found["skin"].texture is not None
    assert found["skin"].texture.image == b"image"
    assert found["plain"].texture is None


@pytest.mark.parametrize(
    ("line", "image"),
    [
        ("map_Kd -s 1 1 1 -o 0 0 skin.png", b"image"),
        ("map_Kd -clamp on skin.png", b"image"),
        ("map_Kd my skin.png", b"spaced"),
        ('map_Kd "my skin.png"', b"spaced"),
        (r"map_Kd C:\scans\today\skin.png", b"image"),
    ],
)
def test_names_of_images(folder: Path, line: str, image: bytes) -> None:
    texture = read_materials(written(folder, f"newmtl a\n{line}\n"), "head.mtl")["a"].texture
    assert texture is not None
    assert (texture.image, texture.problem) == (image, "")


@pytest.mark.parametrize(
    ("name", "problem"),
    [("none.png", "there is no such file"), ("../outside.png", "only files in the folder")],
)
def test_images_that_cannot_be_had_say_why(folder: Path, name: str, problem: str) -> None:
    """And nothing outside the folder of the scan is read."""
    texture = read_materials(written(folder, f"newmtl a\nmap_Kd {name}\n"), "head.mtl")["a"].texture
    assert texture is not None
    assert texture.image == b""
    assert problem in texture.problem


def test_a_library_that_is_missing_holds_nothing(folder: Path) -> None:
    assert read_materials(folder / "head.obj", "gone.mtl") == {}
    assert read_materials(folder / "head.obj", "../head.mtl") == {}
