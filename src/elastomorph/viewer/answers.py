"""What a server hands out, and what pages send it and hear of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from io import BufferedIOBase

from elastomorph.errors import ParameterError

HTML = "text/html; charset=utf-8"
_WITH_NOTHING = "default-src 'none'"


@dataclass(frozen=True)
class Resource:
    """One thing the server hands out: media type, bytes, and the content security policy.

    What is large and seldom wanted is a function that gives the bytes when they are.
    """

    kind: str
    content: bytes | Callable[[], bytes]
    policy: str = _WITH_NOTHING


@dataclass(frozen=True)
class Sent:
    """What a page sends: bytes, to be read once, and the words behind the question mark."""

    stream: BufferedIOBase
    length: int
    words: str

    def read(self) -> bytes:
        """All of it.

        Raises:
            ParameterError: The page, or its browser, went away before the end.
        """
        content = self.stream.read(self.length)
        if len(content) < self.length:
            raise ParameterError(
                f"what was sent ended after {len(content):,} of {self.length:,} bytes; send it anew"
            )
        return content


def text(words: str) -> Resource:
    """A sentence as the whole of an answer."""
    return Resource("text/plain; charset=utf-8", f"{words}\n".encode())


@dataclass(frozen=True)
class Answer:
    """What a page that sent something hears, and whether this was all there was to do."""

    content: Resource
    finished: bool = False


@dataclass(frozen=True)
class Receiver:
    """Takes what a page sends to an address, up to a number of bytes."""

    takes: Callable[[Sent], Answer]
    most: int = 8 << 20
