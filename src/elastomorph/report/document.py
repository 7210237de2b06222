"""A whole page from its sections, in one file that asks the network for nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import replacing
from elastomorph.templates import rendered

__all__ = ["Section", "document", "require_page_path", "write_page"]


@dataclass(frozen=True)
class Section:
    """A part of a report.

    Attributes:
        name: Its id; its template is called like it.
        title: Its heading.
        content: What the template shows, called ``it`` there.
    """

    name: str
    title: str
    content: Mapping[str, object] = field(default_factory=dict)

    @property
    def template(self) -> str:
        """The file of its template; headings in it begin at h3."""
        return f"{self.name}.html"


def document(
    title: str, subtitle: str, sections: Sequence[Section], *, viewer: bool = False
) -> str:
    """A whole page; ``viewer`` says whether a frame in it runs scripts."""
    return rendered(
        "elastomorph.report",
        "page.html",
        title=title,
        subtitle=subtitle,
        sections=sections,
        viewer=viewer,
    )


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
