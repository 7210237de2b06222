"""What users can rely on."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

import elastomorph as em
import elastomorph.errors as errors


def test_every_exported_name_exists_and_is_documented() -> None:
    for name in em.__all__:
        assert inspect.getdoc(getattr(em, name)), name


def test_type_checkers_and_python_find_the_same_names() -> None:
    """What the package imports for type checkers is what it hands out when it is asked."""
    tree = ast.parse(inspect.getsource(em))
    guarded = next(node for node in tree.body if isinstance(node, ast.If))
    homes: dict[str, set[str]] = {}
    for node in guarded.body:
        assert isinstance(node, ast.ImportFrom)
        homes.setdefault(node.module or "", set()).update(alias.name for alias in node.names)
    homes["elastomorph.rig"].remove("timing")  # a module, public as it is
    assert homes.pop("elastomorph.rig") == set()
    assert homes == {f"elastomorph.{home}": set(names) for home, names in em._HOMES.items()}


def test_dir_shows_what_is_public_and_nothing_else() -> None:
    """Whatever has been imported by then."""
    em.Rig, em.errors  # type: ignore[attr-defined]  # noqa: B018
    shown = {name for name in dir(em) if not name.startswith("__")}
    assert shown == {*em.__all__, "timing"}


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'interpolat'"):
        em.interpolat  # type: ignore[attr-defined]  # noqa: B018


def test_the_command_line_starts_without_anything_heavy() -> None:
    """Help and mistyped options must not wait for numpy, scipy, vtk and the like, nor for verbs."""
    heavy = (
        "{'numpy', 'scipy', 'vtkmodules', 'matplotlib', 'PIL', 'rich', 'torch', 'pxr', 'cv2', "
        "'elastomorph.cli.options', 'elastomorph.cli.render'}"
    )
    program = (
        "import sys\nfrom elastomorph.cli import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        f"sys.exit(' '.join({heavy} & set(sys.modules)) or 0)"
    )
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (found.returncode, found.stderr) == (0, "")
    assert "evaluate" in found.stdout


def test_no_public_name_asks_for_what_an_extra_brings() -> None:
    extras = "{'pycolmap', 'cv2', 'embreex', 'PIL', 'vtkmodules', 'torch', 'pxr', 'meshopt'}"
    program = (
        "import sys\nimport elastomorph as em\nfor name in em.__all__:\n    getattr(em, name)\n"
        f"sys.exit(' '.join({extras} & set(sys.modules)) or 0)"
    )
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (found.returncode, found.stderr) == (0, "")


def test_every_error_derives_from_one() -> None:
    for name in errors.__all__:
        kind = getattr(errors, name)
        assert issubclass(kind, errors.ElastomorphError | errors.ElastomorphWarning)
        assert name in errors.__doc__
        assert name in em.__all__


def test_the_package_knows_its_version() -> None:
    assert version("elastomorph")


def test_methods_that_hand_upward_import_when_they_are_called() -> None:
    root = Path(__file__).parents[1]
    contracts = tomllib.loads((root / "pyproject.toml").read_text())["tool"]["importlinter"]
    for forward in {
        each for own in contracts["contracts"] for each in own.get("ignore_imports", [])
    }:
        importer, _, imported = forward.partition(" -> ")
        text = (root / "src" / (importer.replace(".", "/") + ".py")).read_text()
        for node in ast.parse(text).body:
            if isinstance(node, ast.ImportFrom):
                assert not f"{node.module}.".startswith(f"{imported}."), forward
