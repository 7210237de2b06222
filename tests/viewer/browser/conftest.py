"""The page under test, a way to open it, and faces to look at."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from faces import Faces, make_faces
from tabs import Tabs
from visiting import Visit

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


@pytest.fixture(autouse=True)
def _the_page_under_test(monkeypatch: pytest.MonkeyPatch) -> None:
    """The shipped page, or another build of it that ELASTOMORPH_VIEWER_PAGE names."""
    other = os.environ.get("ELASTOMORPH_VIEWER_PAGE")
    if other:
        text = Path(other).read_text(encoding="utf-8")
        monkeypatch.setattr("elastomorph.viewer.page.shipped_page", lambda: text)


@pytest.fixture(scope="session")
def tabs(browser: Browser) -> Iterator[Tabs]:
    kept = Tabs(browser)
    yield kept
    kept.close()


@pytest.fixture
def visit(tabs: Tabs, tmp_path: Path) -> Iterator[Visit]:
    """Opens pages. None of them may complain, or ask for anything from elsewhere."""
    visits = Visit(tabs, tmp_path)
    yield visits
    assert visits.close() == []


@pytest.fixture(scope="session")
def faces() -> Faces:
    return make_faces()


@pytest.fixture(scope="session")
def keep() -> Callable[[Page, str], None]:
    """Keeps a picture of a page in ELASTOMORPH_SCREENSHOTS, for somebody who looks at them."""
    folder = os.environ.get("ELASTOMORPH_SCREENSHOTS")

    def kept(page: Page, name: str) -> None:
        if folder:
            Path(folder).mkdir(parents=True, exist_ok=True)
            page.screenshot(path=Path(folder) / f"{name}.png")

    return kept
