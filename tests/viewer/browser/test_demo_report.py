"""The report that `make demo` left in ``out`` opens from disk, and its viewers live."""

from __future__ import annotations

from pathlib import Path

import pytest
from visiting import Visit, wait

import elastomorph

REPORT = Path(__file__).parents[3] / "out" / "report.html"


@pytest.fixture
def report() -> str:
    """Address of the report of this version of the package."""
    made = REPORT.stat().st_mtime if REPORT.is_file() else 0.0
    if made < Path(elastomorph.__file__).stat().st_mtime:
        pytest.skip("needs the report of the demo: run 'make demo' before")
    return REPORT.as_uri()


@pytest.mark.slow
def test_the_report_of_the_demo_lives(visit: Visit, report: str) -> None:
    """Nothing is missing, asked for elsewhere or complained of, which `visit` looks after."""
    page = visit.blank(report)
    page.evaluate("Promise.all([...document.images].map(image => image.decode()))")
    assert page.locator("img").count() > 3
    viewers = page.locator("iframe").count()
    assert viewers > 0
    for number in range(viewers):
        page.locator("iframe").nth(number).scroll_into_view_if_needed()
        frame = page.frames[1 + number]
        wait(frame, "window.elastomorph")
        frame.evaluate("elastomorph.ready")
        assert frame.evaluate("elastomorph.models().length") >= 2
