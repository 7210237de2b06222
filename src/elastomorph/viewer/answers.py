"""What a server hands out, and what pages send it and hear of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from io import BufferedIOBase
from typing import Any

from elastomorph.errors import ParameterError

HTML = "text/html; charset=utf-8"
_WITH_NOTHING = "default-src 'none'"
_BLOCK = 1 << 20


@dataclass(frozen=True)
class Resource:
    """One thing the server hands out: media type, bytes, and the content security policy.

    What is large and seldom wanted is a function that gives the bytes when they are.
    """

    kind: str
    content: bytes | Callable[[], bytes]
    policy: str = _WITH_NOTHING


class Sent:
    """What a page sends: bytes, to be read once, and the words behind the question mark."""

    def __init__(self, stream: BufferedIOBase, length: int, words: str) -> None:
        self._stream, self.left, self.words = stream, length, words

    def block(self, most: int) -> bytes:
        """The next bytes; none at the end, or where the page went away before it."""
        content = self._stream.read(min(most, self.left))
        self.left -= len(content)
        return content

    def line(self, most: int) -> bytes:
        """The next line, with its end where that is not too far."""
        content = self._stream.readline(min(most, self.left))
        self.left -= len(content)
        return content

    def read(self) -> bytes:
        """All of it.

        Raises:
            ParameterError: The page, or its browser, went away before the end.
        """
        content = self.block(self.left)
        if self.left:
            raise ParameterError(f"{self.left:,} bytes of what was sent are missing; send it anew")
        return content

    def drop(self) -> None:
        """Let the rest come and go: a browser that is still sending hears no answer."""
        while self.block(_BLOCK):
            pass


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


@dataclass(frozen=True)
class Work:
    """Does what takes a while for a page, and tells it meanwhile what is being done.

    What it gives back goes to the page as JSON. When the page asks no more, saying something
    raises an `OSError` that ends the work.
    """

    does: Callable[[Sent, Callable[[str], None]], Mapping[str, Any]]
    most: int = 1 << 20


Offer = Resource | Receiver | Work
"""What there is at an address: something to get, or somebody to send something to."""


def model_file(glb: bytes) -> Resource:
    """A GLB file."""
    return Resource("model/gltf-binary", glb)
