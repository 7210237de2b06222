"""The report with the real viewer in it: one file, no requests, usable by everybody."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from test_looks import AXE, SIZES, violations, written
from visiting import Visit, wait

from elastomorph.evaluation import Evaluation
from elastomorph.report import About, report_page

if TYPE_CHECKING:
    from playwright.sync_api import Page

LARGEST = 8_000_000


@pytest.fixture
def report(evaluation: Evaluation, tmp_path: Path) -> str:
    """Address of a report about the smallest evaluation there is."""
    file = tmp_path / "report.html"
    file.write_text(report_page(evaluation, About("a tip", unit="cm")), encoding="utf-8")
    return file.as_uri()


@pytest.mark.slow
def test_a_report_with_its_viewer(
    visit: Visit, report: str, keep: Callable[[Page, str], None]
) -> None:
    """On a desk, a phone and in a window of 800 by 500, light and dark."""
    assert Path(report.removeprefix("file://")).stat().st_size < LARGEST
    for size, shape in SIZES.items():
        page = visit.blank(report, size=shape)
        assert page.evaluate("document.documentElement.scrollWidth") <= shape[0]
        page.locator("iframe").scroll_into_view_if_needed()
        frame = page.frames[1]
        wait(frame, "window.elastomorph")
        frame.evaluate("elastomorph.ready")
        assert frame.evaluate("elastomorph.models().length") >= 2
        for theme in ("light", "dark"):
            page.emulate_media(color_scheme=theme)
            written(frame)
            keep(page, f"report-viewer-{size}-{theme}")
            if AXE.is_file():
                assert violations(page) == []
                assert violations(frame) == []
        page.evaluate("scrollTo(0, 0)")
        keep(page, f"report-{size}-{theme}")
