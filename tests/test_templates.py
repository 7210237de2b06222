"""Every value in a template is escaped unless it is markup, and reads the same on the page."""

from __future__ import annotations

import re
from html import unescape

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jinja2 import UndefinedError
from markupsafe import Markup

from elastomorph.report.document import document
from elastomorph.templates import rendered

# What HTML can show: no control characters, no halves of surrogate pairs, and a parser of HTML
# reads every kind of line break as a new line.
texts = st.text(st.characters(exclude_categories=("Cs", "Cc")))


def page(title: str, subtitle: str = "") -> str:
    return document(title, subtitle, [])


def tags(made: str) -> list[str]:
    return re.findall(r"</?\w+", made)


@given(texts)
def test_texts_come_back_as_they_were(text: str) -> None:
    shown = re.search(r"<h1>(.*)</h1>", page(text), re.DOTALL)
    assert shown
    assert unescape(shown[1]) == text


@given(st.text(st.characters(exclude_categories=()), max_size=50))
def test_no_text_makes_elements_or_breaks_the_file(text: str) -> None:
    """Not even names with control characters or broken Unicode, as file names may have."""
    made = page(text, text)
    made.encode()
    assert tags(made) == tags(page("plain"))
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f]", made)


@given(texts)
def test_a_text_inside_an_attribute_cannot_end_it(text: str) -> None:
    it = {"page": f'"{text}"', "left_out": [], "truth": text, "reason": ""}
    made = rendered("elastomorph.report", "viewer.html", it=it)
    shown = re.search(r'srcdoc="([^"]*)" class="viewer"></iframe>', made)
    assert shown
    assert unescape(shown[1]) == f'"{text}"'


def test_markup_stays_as_it_is() -> None:
    made = rendered(
        "elastomorph.report",
        "graphs.html",
        it={"graphs": [{"title": "<i>", "svg": Markup("<svg/>"), "caption": "a & b"}]},
    )
    assert "<svg/>" in made
    assert "&lt;i&gt;" in made
    assert "a &amp; b" in made


def test_a_value_that_is_missing_is_an_error() -> None:
    with pytest.raises(UndefinedError, match="graphs"):
        rendered("elastomorph.report", "graphs.html", it={})
