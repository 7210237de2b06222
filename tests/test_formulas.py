"""Formulas of the documentation: every one can be set, and equations have the paper's numbers."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from needs import extra

DOCS = Path(__file__).parents[1] / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
FORMULA = re.compile(r"\$\$(.+?)\$\$|(?<![$`\w])\$([^$`\s][^$`\n]*?)\$(?![$\w])", re.DOTALL)
TAG = re.compile(r"\\tag\{(\d+)\}")


@pytest.fixture
def mathml(monkeypatch: pytest.MonkeyPatch):  # type: ignore[no-untyped-def]
    extra("latex2mathml", "dev")
    extra("sphinx", "dev")
    monkeypatch.syspath_prepend(DOCS / "extensions")
    monkeypatch.delitem(sys.modules, "mathml", raising=False)
    import mathml

    return mathml


def formulas(page: Path) -> list[str]:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    return [block or inline for block, inline in FORMULA.findall(text)]


def test_every_formula_becomes_mathml(mathml) -> None:  # type: ignore[no-untyped-def]
    found = [formula for page in PAGES for formula in formulas(page)]
    assert len(found) > 25
    for formula in found:
        root = ElementTree.fromstring(mathml.as_mathml(formula, block=True))
        assert root.tag.endswith("math")
        words = "".join(root.itertext())
        assert not [left for left in ("\\", "&", "tag") if left in words], formula


def test_the_font_that_comes_along_has_every_sign(mathml) -> None:  # type: ignore[no-untyped-def]
    """Also the slanted ones that browsers set single letters in."""
    from fontTools.ttLib import TTFont

    font = TTFont(DOCS / "static" / "stix-two-math.woff")
    signs = set()
    for page in PAGES:
        for formula in formulas(page):
            text = mathml.as_mathml(formula, block=True)
            signs |= set("".join(ElementTree.fromstring(text).itertext()))
    slanted = {chr(0x1D434 + k) for k in range(52)} - {"\U0001d455"} | {"\u210e"}
    assert {"\u02c6", "φ"} < signs
    assert not {sign for sign in signs | slanted if ord(sign) not in font.getBestCmap()}
    assert "MATH" in font


def test_what_is_not_understood_is_refused(mathml) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match=r"'a .*nosuchcommand b' cannot be set"):
        mathml.as_mathml(r"a \nosuchcommand b", block=True)


def test_the_derivation_has_the_equations_of_the_paper_in_their_order() -> None:
    """Eqs. 26 to 30 repeat 18 to 25 for the sine, and are said to."""
    text = (DOCS / "derivation.md").read_text(encoding="utf-8")
    assert [int(tag) for tag in TAG.findall(text)] == list(range(1, 26))


def test_no_equation_is_numbered_on_two_pages() -> None:
    tags = [tag for page in PAGES for formula in formulas(page) for tag in TAG.findall(formula)]
    assert len(tags) == len(set(tags))
