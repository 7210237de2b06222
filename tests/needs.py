"""What some tests need and a machine may lack: for each thing one reason, which is told once."""

from __future__ import annotations

import importlib.util
import os
import shutil
from pathlib import Path
from typing import Any

import pytest

WEB = Path(__file__).parents[1] / "web"
MODULES = WEB / "node_modules"
NO_NODE = "needs Node.js and what web pins: install npm and run 'make test'"

not_root = pytest.mark.skipif(
    hasattr(os, "geteuid") and os.geteuid() == 0,
    reason="root may write everywhere: run the tests as another user",
)


def extra(module: str, name: str) -> Any:
    """A module that an extra of the package brings; the tests are skipped without it."""
    return pytest.importorskip(module, reason=_lacking(name))


def installed(module: str, name: str) -> None:
    """As `extra`, for a module that only a process of its own may load."""
    if importlib.util.find_spec(module) is None:
        pytest.skip(_lacking(name), allow_module_level=True)


def _lacking(name: str) -> str:
    return f"needs the extra '{name}': pip install 'elastomorph[{name}]'"


def node(*packages: str) -> str:
    """The Node.js program, where it and some packages of ``web`` are installed."""
    found = shutil.which("node")
    if found is None or not all((MODULES / name).is_dir() for name in packages):
        pytest.skip(NO_NODE)
    return found


def program(name: str, package: str) -> str:
    """A program of a Debian package; the tests are skipped without it."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"needs {name}: install Debian's package {package}")
    return found
