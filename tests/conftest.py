"""Where the tests find the real rig and captures."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder with the real rig and captures; skips the test where there is none."""
    named = os.environ.get("ELASTOMORPH_DATA")
    folder = Path(named) if named else Path(__file__).parents[2] / "shared" / "data"
    if not (folder / "ict-facekit").is_dir():
        pytest.skip(f"real data not found in {folder}: set ELASTOMORPH_DATA to its folder")
    return folder
