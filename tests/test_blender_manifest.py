"""What the extension for Blender says of itself; its own tests need Blender."""

from __future__ import annotations

import importlib.util
import re
import tomllib
import zipfile
from pathlib import Path

import pytest

import elastomorph as em

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "integrations" / "blender"
MANIFEST = tomllib.loads((FOLDER / "elastomorph_blender" / "blender_manifest.toml").read_text())
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_its_version_is_that_of_the_package() -> None:
    assert MANIFEST["version"] == PROJECT["version"]


def test_its_licence_is_that_of_the_package() -> None:
    assert MANIFEST["license"] == [f"SPDX:{PROJECT['license']}"]


def test_its_wheels_are_pinned_and_are_requirements_of_the_package() -> None:
    pins = [line.partition("==") for line in (FOLDER / "wheels.txt").read_text().splitlines()]
    required = {re.split(r"[^\w-]", text)[0] for text in PROJECT["dependencies"]}
    assert all(version for _, _, version in pins)
    assert {name for name, _, _ in pins} <= required


def test_what_it_offers_are_methods() -> None:
    source = (FOLDER / "elastomorph_blender" / "operators.py").read_text(encoding="utf-8")
    offered = re.findall(r'^    \("([a-z:0-9]+)", "', source, re.MULTILINE)
    assert len(offered) > 5
    for text in offered:
        assert em.Method.of(text).label


# What SciPy calls its wheels for these systems.
WHEEL_OF = {
    "linux-x64": "manylinux2014_x86_64",
    "macos-arm64": "macosx_12_0_arm64",
    "macos-x64": "macosx_10_14_x86_64",
    "windows-x64": "win_amd64",
}


@pytest.mark.parametrize("asked", [[], ["windows-x64"], ["macos-arm64", "linux-x64"]], ids=repr)
def test_the_zip_has_wheels_for_each_system_that_is_asked_for(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    asked: list[str],
) -> None:
    """All that the documentation names are, by default; pip is asked for each by its tags."""
    spec = importlib.util.spec_from_file_location("build_extension", FOLDER / "build.py")
    assert spec is not None
    assert spec.loader is not None
    build = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(build)

    def run(*arguments: str) -> None:
        """As hatchling and pip, which fetches the wheel of a tag that it is given."""
        module, words = arguments[1], [*arguments]
        if module == "hatchling":
            Path(words[-1], "elastomorph-0-py3-none-any.whl").touch()
            return
        assert "--only-binary=:all:" in words
        given = [word.partition("=")[2] for word in words if word.startswith("--platform=")]
        (tag,) = set(given) & set(WHEEL_OF.values())
        Path(words[words.index("--dest") + 1], f"scipy-1-cp311-cp311-{tag}.whl").touch()

    monkeypatch.setattr(build, "_run", run)
    options = [word for name in asked for word in ("--platform", name)]
    monkeypatch.setattr("sys.argv", ["build.py", "-o", str(tmp_path), *options])
    build.main()
    wanted = asked or list(WHEEL_OF)
    with zipfile.ZipFile(capsys.readouterr().out.strip()) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        held = {f"./{name}" for name in archive.namelist() if name.endswith(".whl")}
    tags = {name.removesuffix(".whl").split("-", 4)[-1] for name in held}
    assert manifest["platforms"] == wanted
    assert set(manifest["wheels"]) == held
    assert tags == {WHEEL_OF[name] for name in wanted} | {"any"}


def test_the_documentation_names_the_systems_that_it_is_built_for() -> None:
    page = (ROOT / "docs" / "blender.md").read_text(encoding="utf-8")
    named = re.search(r"one system\s+only[^(]*\(([^)]+)\)", page)
    assert named is not None
    assert set(re.findall("`([^`]+)`", named[1])) == set(WHEEL_OF)
    for words in ("Linux (x64)", "macOS (Apple and Intel)", "Windows (x64)"):
        assert words in page
