"""Takes the text of an OBJ file apart into statements, with comments and continuations resolved."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from elastomorph.errors import FormatError

NAMING = frozenset({b"usemtl", b"mtllib", b"g", b"o"})

IGNORED = frozenset(
    # normals go stale as soon as a vertex moves; smoothing, points and lines are not polygons
    b"vn s l p mg lod bevel c_interp d_interp usemap maplib shadow_obj trace_obj ctech stech "
    # curves and surfaces
    b"vp deg bmat step cstype curv curv2 surf parm trim hole scrv sp end con "
    # statements that version 2 of the format already called superseded
    b"bsp bzp cdc cdp res".split()
)

_UTF8_MARK = b"\xef\xbb\xbf"
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")

_STRAY = (b"t", b"vw")
_COMMENT_AFTER_NAME = re.compile(rb"(?:^|(?<=[ \t]))#(?=[ \t]|$)")


class StatementError(ValueError):
    """What is wrong with the statement on a line."""

    def __init__(self, line: int, problem: str) -> None:
        super().__init__(problem)
        self.line = line


class Rows:
    """The statements of one keyword: the line of each, from 1, and what follows the keyword."""

    def __init__(self) -> None:
        self.lines: list[int] = []
        self.bodies: list[bytes] = []

    def without_comments(self) -> list[bytes]:
        """What follows the keyword, up to the comment."""
        if not any(b"#" in body for body in self.bodies):
            return self.bodies
        return [body.partition(b"#")[0] for body in self.bodies]


class Statements:
    """The statements of an OBJ file that matter.

    Attributes:
        vertices: The ``v`` statements.
        texture: The ``vt`` statements.
        faces: The ``f`` statements.
        names: ``(line, name)`` of each ``usemtl``, ``g``, ``o`` and ``mtllib`` by keyword; the
            name holds from its line on, and is empty for none.
        stray: Lines of statements that are no part of the format but common in files.
        problems: What is wrong with the first statement whose keyword is unknown, if any is.
    """

    def __init__(self, text: bytes) -> None:
        """Take apart a text whose lines end in LF."""
        self.vertices, self.texture, self.faces = Rows(), Rows(), Rows()
        self.names: dict[bytes, list[tuple[int, bytes]]] = {keyword: [] for keyword in NAMING}
        self.stray: dict[bytes, list[int]] = {keyword: [] for keyword in _STRAY}
        self.problems: list[StatementError] = []
        rows = {b"v": self.vertices, b"vt": self.texture, b"f": self.faces, b"fo": self.faces}
        takers = {key: (own.lines.append, own.bodies.append) for key, own in rows.items()}
        lines = text.split(b"\n")
        if b"\\\n" in text or text.endswith(b"\\"):
            _join_continued(lines)
        for number, line in enumerate(lines, start=1):
            keyword, _, body = line.partition(b" ")
            take = takers.get(keyword)
            if take is None:
                if keyword in IGNORED:
                    continue
                words = line.split(None, 1)
                if not words or words[0].startswith(b"#"):
                    continue
                keyword = words[0].removesuffix(b"\\")
                body = words[1] if len(words) > 1 else b""
                take = takers.get(keyword)
            if take is not None:
                take[0](number)
                take[1](body)
            else:
                self._take_other(number, keyword, line)

    def _take_other(self, number: int, keyword: bytes, line: bytes) -> None:
        if keyword in NAMING:
            self.names[keyword].append((number, name_in(without_comment(line, keyword))))
        elif keyword in _STRAY:
            self.stray[keyword].append(number)
        elif keyword not in IGNORED and not self.problems:
            problem = (
                "unknown keyword '{}'; expected v, vt, vn, f, g, o, s, usemtl, mtllib, another "
            )
            problem += "keyword of the OBJ format, or # before a comment"
            if keyword in (b"call", b"csh"):
                problem = "'{}' draws in other files, which is not supported; merge them first"
            problem = problem.format(shown(keyword))
            self.problems.append(StatementError(number, problem))


def plain_text(path: str | Path, content: bytes) -> bytes:
    """The content with lines that end in LF."""
    if content.startswith(_UTF16_MARKS):
        raise FormatError(path, "this is UTF-16 text; save the file as UTF-8")
    text = content.removeprefix(_UTF8_MARK)
    if text.endswith(b"\0"):
        text = text.rstrip(b"\0")  # padding, as ZBrush writes it
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    nul = text.find(b"\0")
    if nul >= 0:
        raise FormatError(
            path,
            "a NUL byte: this is not text, or the file is damaged; export it again as OBJ in UTF-8",
            line=text.count(b"\n", 0, nul) + 1,
        )
    return text


def _join_continued(lines: list[bytes]) -> None:
    """Put statements that a backslash continues on their first line; the others become empty."""
    rest = enumerate(lines)
    for number, line in rest:
        words = line.split(None, 1)
        if not words or words[0].startswith(b"#") or not line.endswith(b"\\"):
            continue
        keyword = words[0].removesuffix(b"\\")
        parts = [without_comment(line, keyword)]
        while is_continued(line, keyword) and parts[-1] == line:  # a comment is not continued
            parts[-1] = line[:-1]
            place, line = next(rest, (0, b""))
            parts.append(without_comment(line, keyword))
            if place:
                lines[place] = b""
        lines[number] = b" ".join(parts) if keyword else words[0] + b" " + b" ".join(parts)


def without_comment(line: bytes, keyword: bytes) -> bytes:
    """The line up to its comment.

    After a name only a # that stands alone begins a comment: ``usemtl Material #25`` is a name.
    """
    if keyword in NAMING:
        comment = _COMMENT_AFTER_NAME.search(line)
        return line[: comment.start()] if comment else line
    return line.partition(b"#")[0]


def is_continued(line: bytes, keyword: bytes) -> bool:
    """Whether a backslash at the end of a line joins it with the next.

    In Shift-JIS, a backslash is also the second byte of letters: ``usemtl ソ`` ends in one.
    """
    in_letter = keyword in NAMING and line[-2:-1] >= b"\x81" and encoding_of([line]) != "utf-8"
    return line.endswith(b"\\") and not in_letter


def name_in(statement: bytes) -> bytes:
    """All that follows the keyword, blanks inside included; empty where nothing does."""
    return b"".join(statement.split(None, 1)[1:]).strip()


def encoding_of(names: Sequence[bytes]) -> Literal["utf-8", "latin-1"]:
    """UTF-8, or Latin-1 where that cannot be: every byte is a letter of it, and comes back."""
    try:
        for name in names:
            name.decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def shown(word: bytes) -> str:
    """A word of a file for a message: printable, and not long."""
    text = word[:80].decode("ascii", "backslashreplace")
    printable = "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in text)
    return printable if len(printable) <= 40 else printable[:37] + "..."
