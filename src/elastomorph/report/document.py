"""The frame of a report: head, style, contents, sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files

from elastomorph.report.markup import Markup, element, joined

__all__ = ["PAPER", "Section", "document"]

PAPER = "https://doi.org/10.3390/axioms13030185"
_STYLES = ("page.css", "content.css", "print.css")
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'"
# A frame with its page inside inherits the policy around it, so the viewer's needs are named here.
_VIEWER_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline' blob:; "
    "img-src data: blob:; media-src data: blob:; font-src data:; connect-src data: blob:; "
    "worker-src blob:; base-uri 'none'; form-action 'none'"
)


@dataclass(frozen=True)
class Section:
    """A part of a report.

    Attributes:
        name: Its id.
        title: Its heading.
        content: What it holds; headings within begin at h3.
    """

    name: str
    title: str
    content: Markup


def document(
    title: str, subtitle: object, sections: Sequence[Section], *, viewer: bool = False
) -> str:
    """A whole page in one file that asks the network for nothing.

    Args:
        title: Its heading.
        subtitle: Below it.
        sections: In order; empty ones are left out.
        viewer: Whether a frame in it runs scripts.
    """
    sections = [section for section in sections if section.content]
    folder = files("elastomorph.report")
    style = "\n".join((folder / name).read_text(encoding="utf-8") for name in _STYLES)
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element(
            "meta",
            attributes={"http-equiv": "Content-Security-Policy"},
            # Markup, for a policy is easier to read with its quotation marks; it has no other.
            content=Markup(_VIEWER_POLICY if viewer else _POLICY),
        ),
        element("meta", name="color-scheme", content="light dark"),
        element("meta", name="generator", content="elastomorph"),
        element("title", f"{title} · elastomorph report"),
        element("style", Markup(style)),
    )
    contents = element(
        "nav",
        element(
            "ol",
            *(
                element("li", element("a", section.title, href=f"#{section.name}"))
                for section in sections
            ),
        ),
        aria_label="Contents",
    )
    body = element(
        "body",
        element("a", "To the report", href="#report", class_="skip"),
        element(
            "header",
            element("p", "elastomorph report", class_="mark"),
            element("h1", title),
            element("p", subtitle, class_="subtitle"),
        ),
        contents,
        element("main", *(_section(section) for section in sections), id="report"),
        element(
            "footer",
            element(
                "p",
                "Method: Day et al., Improving Realism of Facial Interpolation and Blendshapes "
                "with Analytical Partial Differential Equation-Represented Physics, Axioms 2024, "
                "13(3), 185, ",
                element("a", "doi:10.3390/axioms13030185", href=PAPER, rel="noreferrer"),
                ". elastomorph is an independent implementation.",
            ),
        ),
    )
    page = element("html", "\n", head, "\n", body, "\n", lang="en")
    return joined([Markup("<!doctype html>\n"), page, "\n"])


def _section(section: Section) -> Markup:
    heading = element("h2", section.title, id=section.name)
    return element("section", heading, "\n", section.content, aria_labelledby=section.name)
