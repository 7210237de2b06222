"""Every text is escaped unless it is markup, and reads the same on the page."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from parsed_page import parsed

from elastomorph.report.markup import Markup, element, escaped, joined

# What HTML can show: no control characters, no halves of surrogate pairs, and a parser of HTML
# reads every kind of line break as a new line.
texts = st.text(st.characters(exclude_categories=("Cs", "Cc")))


@given(texts, texts)
def test_texts_come_back_as_they_were(inside: str, value: str) -> None:
    root = parsed(element("p", inside, title=value))
    (p,) = root.children
    assert p.text == inside
    assert p.attributes == {"title": value}


@given(st.text(st.characters(exclude_categories=()), max_size=50))
def test_no_text_makes_elements_or_breaks_the_file(text: str) -> None:
    """Not even names with control characters or broken Unicode, as file names may have."""
    page = element("p", text, title=text)
    page.encode()
    root = parsed(page)
    assert [each.tag for each in root.all()] == ["p"]
    assert "<" not in escaped(text)


@given(texts)
def test_markup_inside_an_attribute_cannot_end_it(text: str) -> None:
    root = parsed(element("p", content=Markup(text.replace("&", ""))))
    assert root.one("p").attributes == {"content": text.replace("&", "")}


def test_markup_stays_as_it_is() -> None:
    bold = element("b", "1 < 2")
    assert bold == "<b>1 &lt; 2</b>"
    assert element("p", "a & ", bold, 3) == "<p>a &amp; <b>1 &lt; 2</b>3</p>"
    assert joined(["<", Markup("<br>")]) == "&lt;<br>"
    assert escaped(bold) is bold


def test_attributes_are_named_as_in_html() -> None:
    made = element("img", class_="wide", aria_label="A", hidden=True, title=None, lang=False)
    assert made == '<img class="wide" aria-label="A" hidden>'
