from __future__ import annotations

import pytest
from sheets import plate_of

import elastomorph as em
from needs import installed


@pytest.fixture(scope="session")
def sheet() -> em.Mesh:
    return plate_of(6)


@pytest.fixture
def skfem() -> None:
    installed("skfem", "rivals")
