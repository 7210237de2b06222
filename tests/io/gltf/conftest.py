"""Node.js and the packages of ``web``, for checks by other programs."""

from __future__ import annotations

import shutil

import pytest
from viewer_checks import WEB


@pytest.fixture(scope="session")
def node() -> str:
    """The Node.js program, where it and the packages are installed."""
    found = shutil.which("node")
    if found is None:
        pytest.skip("Node.js is not installed")
    missing = [
        name for name in ("gltf-validator", "three") if not (WEB / "node_modules" / name).is_dir()
    ]
    if missing:
        pytest.skip(f"{' and '.join(missing)} not installed: run 'npm ci' in {WEB}")
    return found
