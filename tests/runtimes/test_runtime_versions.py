"""All runtimes have the version and the licence of the Python package."""

from __future__ import annotations

import json
import tomllib

import pytest
from kit import RUNTIMES

ROOT = RUNTIMES.parent
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]


def test_the_package_for_javascript() -> None:
    package = json.loads((RUNTIMES / "js" / "package.json").read_text(encoding="utf-8"))
    assert package["version"] == VERSION
    assert package["license"] == "MIT"
    licence = (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert (RUNTIMES / "js" / "LICENSE").read_text(encoding="utf-8") == licence


@pytest.mark.parametrize("name", ["cpp/elastomorph.hpp", "csharp/Elastomorph.cs"])
def test_files_to_copy_say_it_themselves(name: str) -> None:
    text = (RUNTIMES / name).read_text(encoding="utf-8")
    assert f"// Version {VERSION}. SPDX-License-Identifier: MIT" in text
