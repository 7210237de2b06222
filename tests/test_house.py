"""The figures of the house: what breaks a limit is found."""

import ast
import importlib.util
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]
STEPS = "\n".join(f"    total = add(total, values[{n}] * {n % 3})" for n in range(11))


def tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def house(tmp_path):
    """A copy of this house, to break."""
    for part in ("src", "tools"):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("*.pyc"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def checked(house: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "tools/house.py", "--check"], cwd=house, capture_output=True, text=True
    )


def test_check_says_what_leads_upward_goes_in_circles_and_stands_twice(house):
    package = house / "src" / "elastomorph"
    with (package / "rig" / "timing.py").open("a") as file:
        file.write("\n\ndef up():\n    from elastomorph.io import atomic\n")
    with (package / "rig" / "rig.py").open("a") as file:
        file.write("\n\ndef around():\n    from elastomorph.rig import Rig\n")
    for name, value in (("one", "total"), ("two", "sum_of_them")):
        text = f"def f(values):\n{STEPS}\n    return total\n".replace("total", value)
        (package / "curves" / f"{name}.py").write_text(text)
    done = checked(house)
    assert done.returncode == 1
    assert "elastomorph.rig.timing -> elastomorph.io.atomic" in done.stdout
    assert "circles of imports: 1\n  elastomorph.rig elastomorph.rig.rig" in done.stdout
    assert "curves/one.py:2-13  curves/two.py:2-13" in done.stdout


def test_check_passes_the_house_as_it_is(house):
    done = checked(house)
    assert done.returncode == 0, done.stdout + done.stderr


def test_ten_lines_are_no_duplicate_and_eleven_are(tmp_path):
    find = tool("duplicates").duplicates
    one, two = tmp_path / "one.py", tmp_path / "two.py"
    one.write_text(f"def f(values):\n    # a comment\n    total = 0\n{STEPS}\n")
    two.write_text(f"def g(all):\n{STEPS}\n".replace("values", "all").replace("total", "sum"))
    (only,) = find([one, two])
    assert only.lines == 11
    ten = STEPS.rpartition("\n")[0]
    two.write_text(f"def g(all):\n{ten}\n".replace("values", "all").replace("total", "sum"))
    assert find([one, two]) == []


def test_what_is_called_counts(tmp_path):
    one, two = tmp_path / "one.py", tmp_path / "two.py"
    one.write_text(f"def f(values):\n{STEPS}\n")
    two.write_text(f"def f(values):\n{STEPS}\n".replace("add(", "subtract("))
    assert tool("duplicates").duplicates([one, two]) == []


def test_methods_that_hand_upward_import_when_they_are_called():
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    forwards = {each for own in contracts["contracts"] for each in own.get("ignore_imports", [])}
    for forward in forwards:
        importer, _, imported = forward.partition(" -> ")
        text = (ROOT / "src" / (importer.replace(".", "/") + ".py")).read_text()
        for node in ast.parse(text).body:
            if isinstance(node, ast.ImportFrom):
                assert not f"{node.module}.".startswith(f"{imported}."), forward


def test_lines_of_code_are_counted_without_comments_docstrings_and_blank_lines():
    head = '"""Module."""\n\nX = """two\nlines"""  # why\n\n\n'
    text = head + 'def f(a):\n    """Say."""\n    # so\n    return (\n        a,\n    )\n'
    assert tool("house").lines_of_code(text) == (6, 2)
