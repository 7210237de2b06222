"""The page in a real browser: no requests, no errors, no obstacle, on a desk and on a phone."""

from __future__ import annotations

from typing import Any

import pytest

from elastomorph.evaluation import Evaluation
from elastomorph.report.document import Section, document
from needs import MODULES

AXE = MODULES / "axe-core" / "axe.min.js"


@pytest.fixture(scope="module")
def address(page: str, tmp_path_factory: pytest.TempPathFactory) -> str:
    file = tmp_path_factory.mktemp("report") / "report.html"
    file.write_text(page, encoding="utf-8")
    return file.as_uri()


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1280, 720), (390, 844)])
def test_it_opens_from_disk_and_asks_for_nothing(
    browser: Any, address: str, size: tuple[int, int], theme: str
) -> None:
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]}, color_scheme=theme
    )
    said: list[str] = []
    asked: list[str] = []
    tab = context.new_page()
    tab.on("console", lambda message: said.append(message.text))
    tab.on("pageerror", lambda error: said.append(str(error)))
    tab.on("request", lambda request: asked.append(request.url))
    tab.goto(address)
    assert tab.evaluate("document.documentElement.scrollWidth") == size[0]
    tab.locator("iframe").scroll_into_view_if_needed()
    alive = tab.frame_locator("iframe").locator("#said")
    alive.wait_for()
    # The frame's own script has run, under the policy of the page around it.
    assert alive.text_content() == 'alive & "well"'
    tab.evaluate("Promise.all([...document.images].map(image => image.decode()))")
    if AXE.is_file():
        found = tab.evaluate(
            AXE.read_text(encoding="utf-8") + "; axe.run(document, {iframes: false})"
        )
        assert [each["id"] for each in found["violations"]] == []
    assert said == []
    outside = [url for url in asked if not url.startswith(("data:", "about:"))]
    assert outside == [address]
    context.close()


def test_on_a_desk_no_heading_of_the_contents_is_cut_off(browser: Any) -> None:
    some = Section("faces", "A heading of some words", {"pictures": []})
    tab = browser.new_page(viewport={"width": 1280, "height": 720})
    tab.set_content(document("many", "", 9 * [some]))
    for link in tab.locator("nav a").all():
        box = link.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 1280
    tab.close()


def test_on_a_phone_the_caption_of_a_wide_table_is_read_whole(browser: Any) -> None:
    words = "The largest distance of anything from anything, in words that need several lines"
    content = {"caption": words, "heads": range(9), "rows": [("a", 8 * ["12345.678"])]}
    section = Section("movements", "S", {"graphs": [], **content})
    tab = browser.new_page(viewport={"width": 390, "height": 844})
    tab.set_content(document("wide", "", [section]))
    caption = tab.locator("caption").bounding_box()
    assert tab.locator("table").bounding_box()["width"] > 390
    assert caption["x"] + caption["width"] <= 390
    tab.close()


def test_it_is_read_without_javascript(browser: Any, address: str) -> None:
    context = browser.new_context(java_script_enabled=False)
    tab = context.new_page()
    tab.goto(address)
    words = tab.locator("noscript").text_content()
    assert "switched off" in words
    assert tab.locator("h1").is_visible()
    assert tab.locator("table.errors").is_visible()
    context.close()


def test_a_table_is_copied_for_sheets_and_documents(
    browser: Any, address: str, evaluation: Evaluation
) -> None:
    """A row a method, cells between tabs; by the keyboard, and what was done is said."""
    context = browser.new_context()
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    tab = context.new_page()
    tab.goto(address)
    button = tab.get_by_role("button", name="Copy as table").first
    button.focus()
    tab.keyboard.press("Enter")
    tab.get_by_role("status").filter(has_text="Copied").first.wait_for(state="attached")
    text = tab.evaluate("navigator.clipboard.readText()")
    rows = [line.split("\t") for line in text.splitlines()]
    table = tab.locator("table.errors")
    assert [row[0] for row in rows[2:]] == [each.label for each in evaluation.results]
    assert len({len(row) for row in rows}) == 1
    for row, result in zip(rows[2:], evaluation.results, strict=True):
        assert row[1] == f"{100 * result.lme:.3f}"
    assert "★" not in text
    assert "★" in table.text_content()
    kinds = tab.evaluate("navigator.clipboard.read().then(found => found[0].types)")
    assert set(kinds) == {"text/plain", "text/html"}
    context.close()


def test_where_nothing_can_be_copied_it_says_so(browser: Any, address: str) -> None:
    tab = browser.new_page()
    tab.add_init_script("Object.defineProperty(navigator, 'clipboard', {value: undefined})")
    tab.goto(address)
    tab.get_by_role("button", name="Copy as table").first.click()
    tab.get_by_role("button", name="The browser does not let pages copy").wait_for()
    tab.close()
