"""What the extension for Blender says of itself; its own tests need Blender."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

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
