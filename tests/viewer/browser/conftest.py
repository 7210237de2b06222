"""A browser to look at the shipped page with, and faces to look at."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from faces import Faces, make_faces
from visiting import Visit

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM = os.environ.get("ELASTOMORPH_CHROMIUM") or shutil.which("chromium")
# Draws in software, the same everywhere, and asks nobody for anything by itself.
ARGUMENTS = [
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--force-color-profile=srgb",
]


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Debian's Chromium, or the one that ELASTOMORPH_CHROMIUM names."""
    driver = pytest.importorskip(
        "playwright.sync_api", reason="no browser tests: Playwright is not installed"
    )
    if CHROMIUM is None:
        pytest.skip(
            "no browser tests: there is no chromium; install Debian's package, or name a "
            "Chromium in ELASTOMORPH_CHROMIUM"
        )
    with driver.sync_playwright() as playwright:
        opened = playwright.chromium.launch(
            executable_path=CHROMIUM, args=ARGUMENTS, chromium_sandbox=False
        )
        yield opened
        opened.close()


@pytest.fixture(scope="session", autouse=True)
def _the_page_under_test() -> Iterator[None]:
    """The shipped page, or another build of it that ELASTOMORPH_VIEWER_PAGE names."""
    other = os.environ.get("ELASTOMORPH_VIEWER_PAGE")
    with pytest.MonkeyPatch.context() as patch:
        if other:
            text = Path(other).read_text(encoding="utf-8")
            patch.setattr("elastomorph.viewer.page.shipped_page", lambda: text)
        yield


@pytest.fixture
def visit(browser: Browser, tmp_path: Path) -> Iterator[Visit]:
    """Opens pages. None of them may complain, or ask for anything from elsewhere."""
    visits = Visit(browser, tmp_path)
    yield visits
    assert visits.close() == []


@pytest.fixture(scope="session")
def faces() -> Faces:
    return make_faces()


@pytest.fixture(scope="session")
def keep(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Page, str], None]:
    """Keeps a picture of a page: in ELASTOMORPH_SCREENSHOTS, or beside other files of the run."""
    named = os.environ.get("ELASTOMORPH_SCREENSHOTS")
    folder = Path(named) if named else tmp_path_factory.mktemp("screenshots")
    folder.mkdir(parents=True, exist_ok=True)

    def kept(page: Page, name: str) -> None:
        page.screenshot(path=folder / f"{name}.png")

    return kept
