"""Node.js and the packages of ``web``, for checks by other programs."""

from __future__ import annotations

import pytest

import needs


@pytest.fixture(scope="session")
def node() -> str:
    """The Node.js program, where it and the packages are installed."""
    return needs.node("gltf-validator", "three")
