"""Files are whole or not there."""

from __future__ import annotations

import os
import subprocess
import sys
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from elastomorph.draw.graphs import new_figure
from elastomorph.draw.pictures import as_png, write_picture
from elastomorph.errors import FileError, ParameterError

PATCH = np.random.default_rng(0).integers(0, 256, (30, 20, 3), dtype=np.uint8)


def test_a_png_keeps_every_pixel(tmp_path: Path) -> None:
    write_picture(PATCH, tmp_path / "patch.png")
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "patch.png")), PATCH)
    np.testing.assert_array_equal(np.asarray(Image.open(BytesIO(as_png(PATCH)))), PATCH)


@pytest.mark.parametrize(("suffix", "kind"), [(".jpg", "JPEG"), (".webp", "WEBP"), (".PNG", "PNG")])
def test_the_suffix_chooses_the_format(tmp_path: Path, suffix: str, kind: str) -> None:
    write_picture(PATCH, tmp_path / f"patch{suffix}")
    with Image.open(tmp_path / f"patch{suffix}") as image:
        assert image.format == kind
        assert image.size == (20, 30)


def test_another_suffix_is_refused_and_leaves_nothing(tmp_path: Path) -> None:
    for name in ("patch.gif", "patch"):
        with pytest.raises(ParameterError, match=r"\.png"):
            write_picture(PATCH, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="nowhere"):
        write_picture(PATCH, tmp_path / "nowhere" / "patch.png")


def test_a_failure_while_writing_keeps_the_old_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "patch.png"
    write_picture(PATCH, path)
    before = path.read_bytes()

    def half(self: Image.Image, file: BytesIO, **_: object) -> None:
        file.write(b"half a picture")
        raise RuntimeError("the disk is gone")

    monkeypatch.setattr(Image.Image, "save", half)
    with pytest.raises(RuntimeError):
        write_picture(PATCH[::2], path)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["patch.png"]


def test_a_failure_while_drawing_leaves_no_graph(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), new_figure(tmp_path / "graph.svg", 3, 2) as figure:
        figure.subplots().plot([0, 1 / 0])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("suffix", "start"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")]
)
def test_graphs_come_in_three_formats_and_twice_the_same(
    tmp_path: Path, suffix: str, start: bytes
) -> None:
    for name in ("one", "two"):
        with new_figure(tmp_path / f"{name}{suffix}", 3, 2) as figure:
            figure.subplots().plot([0, 1], label="line")
    one, two = ((tmp_path / f"{name}{suffix}").read_bytes() for name in ("one", "two"))
    assert one.startswith(start)
    assert one == two


def test_a_graph_has_no_other_suffix(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"\.svg"), new_figure(tmp_path / "graph.txt", 3, 2):
        pass
    assert not list(tmp_path.iterdir())


def test_drawing_leaves_the_settings_of_matplotlib_alone(tmp_path: Path) -> None:
    import matplotlib

    before = dict(matplotlib.rcParams)
    with new_figure(tmp_path / "graph.png", 3, 2):
        assert dict(matplotlib.rcParams) != before
    assert dict(matplotlib.rcParams) == before


SPHERE = """
import numpy as np
from elastomorph.model.mesh import Mesh
square = Mesh([[-1., -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]])
"""


def _python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    kept = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        env={**kept, **environment},
        timeout=120,
    )


def test_importing_the_report_imports_no_drawing_package() -> None:
    done = _python(
        "import sys, elastomorph.report; "
        "print([m for m in ('vtk', 'vtkmodules', 'matplotlib', 'PIL') if m in sys.modules])"
    )
    assert done.stdout.strip() == "[]", done.stderr


@pytest.mark.parametrize(
    ("missing", "package", "call"),
    [
        ("vtkmodules", "vtk", "draw.render(square)"),
        ("matplotlib", "matplotlib", "draw.render(square, scalars=[0, 1, 2, 3])"),
        ("matplotlib", "matplotlib", "draw.time_law_graph('graph.png')"),
        ("PIL", "pillow", "draw.write_picture(np.zeros((2, 2, 3), np.uint8), 'picture.png')"),
    ],
)
def test_a_missing_package_is_named_with_the_extra_that_brings_it(
    missing: str, package: str, call: str
) -> None:
    done = _python(
        f"import sys; sys.modules[{missing!r}] = None\n{SPHERE}\n"
        "from elastomorph import draw\n"
        "from elastomorph.errors import MissingExtraError\n"
        f"try:\n    {call}\nexcept MissingExtraError as error:\n    print(error)"
    )
    assert f"'{package}'" in done.stdout, done.stderr
    assert "elastomorph[demo]" in done.stdout


def test_the_first_picture_of_a_process_is_drawn_without_a_display_or_a_complaint() -> None:
    done = _python(
        f"{SPHERE}\nfrom elastomorph.draw import render\n"
        "image = render(square, size=(40, 40))\n"
        "print(np.abs(image[20, 20].astype(int) - image[0, 0]).max() > 20)"
    )
    assert done.stdout.strip() == "True"
    assert done.stderr == ""
