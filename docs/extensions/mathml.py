r"""Formulas as MathML, which browsers set by themselves; equations by the numbers of the paper.

``\tag{22}`` in a formula numbers it, and "Eq. 22" anywhere in the text leads there.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

_TAG = re.compile(r"\s*\\tag\{(\w+)\}")
# The converter's hat is a sign of text, which fonts draw lower than the one above a letter.
_CARET, _HAT = "<mo>&#x0005E;</mo>", "<mo>&#x002C6;</mo>"
_CITED = re.compile(r"Eqs?\. (\d+)")


def as_mathml(formula: str, *, block: bool) -> str:
    """A formula in LaTeX as a ``math`` element.

    Raises:
        ValueError: Something in it was not understood.
    """
    # The converter knows aligned equations by another name.
    text = _TAG.sub("", formula).replace("{aligned}", "{split}").strip()
    found = convert(text, display="block" if block else "inline")
    if left := re.search(r"\\[A-Za-z]+|<mi>&</mi>|<m\w+>\\", found):
        raise ValueError(f"the formula {text!r} cannot be set: what does {left[0]!r} mean?")
    return found.replace(_CARET, _HAT)


def _inline(writer: HTML5Translator, node: nodes.math) -> None:
    writer.body.append(as_mathml(node.astext(), block=False))
    raise nodes.SkipNode


def _block(writer: HTML5Translator, node: nodes.math_block) -> None:
    text = node.astext()
    tag = _TAG.search(text)
    number = f'<a class="number" href="#{_name(tag[1])}">({tag[1]})</a>' if tag else ""
    start = writer.starttag(node, "div", CLASS="math", **({"IDS": [_name(tag[1])]} if tag else {}))
    writer.body.append(f"{start}<div>{as_mathml(text, block=True)}</div>{number}</div>\n")
    raise nodes.SkipNode


def _name(tag: str) -> str:
    return f"equation-{tag}"


def _remember(site: Sphinx, page: nodes.document) -> None:
    """Where each numbered equation stands."""
    known = _equations(site)
    for tag in [tag for tag, where in known.items() if where == site.env.docname]:
        del known[tag]
    for formula in page.findall(nodes.math_block):
        for tag in _TAG.findall(formula.astext()):
            known.setdefault(tag, site.env.docname)


def _equations(site: Sphinx) -> dict[str, str]:
    if not hasattr(site.env, "equations_by_tag"):
        site.env.equations_by_tag = {}  # type: ignore[attr-defined]
    return site.env.equations_by_tag  # type: ignore[attr-defined, no-any-return]


def _link(site: Sphinx, page: nodes.document, name: str) -> None:
    """Make a link of each "Eq. 22" whose equation stands on some page."""
    for text in list(page.findall(nodes.Text)):
        fixed = (nodes.reference, nodes.literal, nodes.literal_block, nodes.title, nodes.raw)
        if not any(isinstance(around, fixed) for around in _around(text)):
            found = list(_pieces(site, name, text.astext()))
            if len(found) > 1:
                text.parent.replace(text, found)


def _pieces(site: Sphinx, page: str, text: str) -> Iterator[nodes.Node]:
    end = 0
    for cited in _CITED.finditer(text):
        where = _equations(site).get(cited[1])
        if where is None:
            continue
        yield nodes.Text(text[end : cited.start()])
        address = f"{site.builder.get_relative_uri(page, where)}#{_name(cited[1])}"
        yield nodes.reference("", cited[0], internal=True, refuri=address)
        end = cited.end()
    yield nodes.Text(text[end:])


def _around(node: nodes.Node) -> Iterator[nodes.Node]:
    while node.parent is not None:
        node = node.parent
        yield node


def setup(site: Sphinx) -> dict[str, bool]:
    """Set formulas, and tie the numbers in the text to them.

    Args:
        site: What is being built.
    """
    site.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    site.connect("doctree-read", _remember)
    site.connect("doctree-resolved", _link)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
