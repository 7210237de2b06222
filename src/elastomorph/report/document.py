"""A whole page from its sections, in one file that asks the network for nothing."""

from __future__ import annotations

import hashlib
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from pathlib import Path

from markupsafe import Markup

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import replacing
from elastomorph.templates import rendered


@dataclass(frozen=True)
class Section:
    """A part of a report.

    Attributes:
        name: Its id; its template is called like it.
        title: Its heading.
        content: What the template shows, called ``it`` there.
        appendix: Whether it stands behind what a reader came for.
    """

    name: str
    title: str
    content: Mapping[str, object] = field(default_factory=dict)
    appendix: bool = False

    @property
    def template(self) -> str:
        """The file of its template; headings in it begin at h3."""
        return f"{self.name}.html"


def document(
    title: str, subtitle: str, sections: Sequence[Section], *, viewer: bool = False
) -> str:
    """A whole page; ``viewer`` says whether a frame in it runs scripts."""
    script = _script()
    digest = b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    return rendered(
        "elastomorph.report",
        "page.html",
        title=title,
        subtitle=subtitle,
        sections=[each for each in sections if not each.appendix],
        appendix=[each for each in sections if each.appendix],
        viewer=viewer,
        script=Markup(script),
        digest=digest,
    )


@cache
def _script() -> str:
    """What copies tables, as the web source builds it."""
    return (files("elastomorph.report") / "templates" / "copy.js").read_text(encoding="utf-8")


def require_page_path(path: str | Path) -> None:
    """Refuse early what could not be written after a long computation."""
    if Path(path).suffix.lower() not in (".html", ".htm"):
        raise FormatError(path, "this is a web page; name it with the suffix .html")
    if not Path(path).resolve().parent.is_dir():
        raise FileError(
            path, f"the folder {Path(path).parent} does not exist; create it first or name another"
        )


def write_page(path: str | Path, page: str) -> None:
    """Write a finished page, the whole of it or nothing."""
    with replacing(path) as file:
        file.write(page.encode())
