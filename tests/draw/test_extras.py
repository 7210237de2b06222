"""Drawing packages are optional, and imported late; each test starts a fresh Python."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

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
        ("vtkmodules", "vtk", "report.render(square)"),
        ("matplotlib", "matplotlib", "report.render(square, scalars=[0, 1, 2, 3])"),
        ("matplotlib", "matplotlib", "report.time_law_graph('graph.png')"),
        ("PIL", "pillow", "report.write_picture(np.zeros((2, 2, 3), np.uint8), 'picture.png')"),
    ],
)
def test_a_missing_package_is_named_with_the_extra_that_brings_it(
    missing: str, package: str, call: str
) -> None:
    done = _python(
        f"import sys; sys.modules[{missing!r}] = None\n{SPHERE}\n"
        "from elastomorph import report\n"
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
