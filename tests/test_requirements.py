"""The pinned environments: one set of versions, of which the demo takes a part."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PIN = re.compile(r"([a-z0-9-]+)==[\w.]+(?: ; .+)?")


def pins(name: str) -> list[str]:
    return (ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8").splitlines()


def names(name: str) -> set[str]:
    found = [PIN.fullmatch(line) for line in pins(name)]
    return {match[1] for match in found if match}


def required(texts: list[str]) -> set[str]:
    return {re.split(r"[^\w-]", text)[0] for text in texts} - {"elastomorph"}


@pytest.mark.parametrize("name", ["demo", "dev"])
def test_every_line_is_one_version_from_wherever_one_gets_packages(name: str) -> None:
    assert all(PIN.fullmatch(line) for line in pins(name))
    assert len(names(name)) > 30


def test_the_demo_has_a_part_of_the_versions_of_the_tests() -> None:
    assert set(pins("demo")) < set(pins("dev"))


def test_what_the_package_names_is_pinned() -> None:
    extras = PROJECT["optional-dependencies"]
    core = required(PROJECT["dependencies"])
    assert core | {"hatchling"} <= names("demo")
    assert required(extras["demo"]) - {"imageio-ffmpeg"} <= names("demo")
    every = [
        text
        for name in ("demo", "usd", "fbx", "gltf", "capture", "rivals", "mocap", "live", "dev")
        for text in extras[name]
    ]
    assert core | required(every) <= names("dev")


def test_the_demo_brings_nothing_for_tests_checks_and_documentation() -> None:
    large = {"playwright", "usd-core", "mypy", "sphinx", "pytest", "imageio-ffmpeg", "ruff"}
    large |= required(PROJECT["optional-dependencies"]["capture"])
    assert large <= names("dev")
    assert not large & names("demo")
