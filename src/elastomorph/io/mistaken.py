"""Files that only stand for what was meant, whatever their names say: it has yet to be fetched."""

from __future__ import annotations

import re
from pathlib import Path

from elastomorph.errors import FormatError
from elastomorph.io.atomic import opened

_LONGEST = 200
_KINDS = (
    (
        re.compile(rb"version https://git-lfs"),
        "this is the pointer of Git LFS to a file, not the file itself; fetch it with 'git lfs "
        "pull'",
    ),
    (
        re.compile(rb"(\xef\xbb\xbf)?\s*<(!doctype\s+)?html", re.IGNORECASE),
        "this is a web page, perhaps one that asks to sign in; download the file itself",
    ),
)


def require_meant(path: str | Path) -> None:
    """Refuse a file that stands for another one.

    Raises:
        FileError: It cannot be read.
        FormatError: It is a pointer of Git LFS or a web page.
    """
    with opened(Path(path)) as file:
        refuse_mistaken(path, file.read(_LONGEST))


def refuse_mistaken(path: str | Path, start: bytes) -> None:
    """As `require_meant`, of a file that begins with these bytes."""
    for kind, words in _KINDS:
        if kind.match(start):
            raise FormatError(path, words)
