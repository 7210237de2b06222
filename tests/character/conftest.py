from __future__ import annotations

from pathlib import Path

import pytest

from characters import write_character


@pytest.fixture(scope="session")
def character(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small character and no settings; tests write theirs under own names."""
    folder = tmp_path_factory.mktemp("Ada")
    write_character(folder)
    return folder
