"""The documentation has every key of a recipe, as the code has it."""

from __future__ import annotations

from pathlib import Path

import pytest
from recipe_tables import tables

PAGE = Path(__file__).parents[2] / "docs" / "farm-recipes.md"
TABLES = tables()


@pytest.mark.parametrize("name", TABLES)
def test_the_page_has_the_table(name: str) -> None:
    assert TABLES[name] in PAGE.read_text(encoding="utf-8")
