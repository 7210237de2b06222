"""Who is heard, and how they are answered.

Other programs on the machine can reach a port of 127.0.0.1, and so can any web page the user has
open. The first keeps out a token that is the first part of every path; the second also the check
of the Host header, for a name that an attacker's server resolves to 127.0.0.1 would otherwise make
this server part of the attacker's own site. What is sent must come from a page of this server.
"""

from __future__ import annotations

import json
import os
import secrets
import select
import socket
import socketserver
import sys
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from io import BufferedIOBase
from typing import Any

from elastomorph.errors import ElastomorphError, ParameterError

# What a server hands out, and what pages send it and hear of it.

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


LOOPBACK = "127.0.0.1"
_DIGITS = 20
"""Of the length of what is sent: Python reads no number of thousands of them."""


_ANEW = (
    "this address is of a command that has ended, or of nothing. Where the command was started "
    "anew, open the address that it prints now"
)


class Listener(ThreadingHTTPServer):
    """Takes connections; what it hands out, and to whom, is set by whoever made it."""

    # A port that was just left is free. On Windows this option gives away one that is in use, and
    # so does the other one everywhere, where both belong to one user.
    allow_reuse_address = os.name == "posix"
    allow_reuse_port = False

    token: str
    shelf: dict[str, Offer]
    finished: threading.Event

    def __init__(self, *words: Any) -> None:
        self._open: set[Any] = set()
        super().__init__(*words)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Remember who is connected."""
        self._open.add(request)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Forget who has been answered."""
        self._open.discard(request)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a page that was closed while it was answered."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)

    def server_close(self) -> None:
        """End, also towards those who keep a connection for what they may ask later."""
        super().server_close()
        for request in list(self._open):
            with suppress(OSError):
                request.shutdown(socket.SHUT_RDWR)

    def server_bind(self) -> None:
        """Bind without asking for the name of the machine."""
        # As HTTPServer does, which may take seconds.
        socketserver.TCPServer.server_bind(self)
        self.server_name, self.server_port = LOOPBACK, int(self.server_address[1])


class Handler(BaseHTTPRequestHandler):
    """One connection."""

    server: Listener
    server_version, sys_version = "elastomorph", ""
    protocol_version = "HTTP/1.1"
    timeout = 30

    def do_GET(self) -> None:
        """Hand out what is there."""
        name = self._name()
        found = None if name is None else self.server.shelf.get(name)
        if not isinstance(found, Resource):
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        try:
            self._send(HTTPStatus.OK, found)
        except ElastomorphError as error:
            self._send(HTTPStatus.GONE, text(str(error)))

    def do_HEAD(self) -> None:
        """The same without its body."""
        self.do_GET()

    def do_POST(self) -> None:
        """Take what a page of this server sends, where somebody waits for it."""
        receiver = self.server.shelf.get(self._name() or "")
        own = self.headers.get("Origin") == f"http://{self.headers.get('Host')}"
        if not isinstance(receiver, Receiver | Work) or not own:
            self.send_error(HTTPStatus.METHOD_NOT_ALLOWED)
            return
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit() and len(length) < _DIGITS):
            self.send_error(HTTPStatus.LENGTH_REQUIRED)
        elif int(length) > receiver.most:
            self.send_error(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        else:
            words = self.path.partition("?")[2]
            sent = Sent(self.rfile, int(length), words)
            if isinstance(receiver, Work):
                self._work(receiver, sent)
            else:
                self._receive(receiver, sent)

    def _receive(self, receiver: Receiver, sent: Sent) -> None:
        try:
            answer = receiver.takes(sent)
        except ElastomorphError as error:
            sent.drop()
            self._send(HTTPStatus.BAD_REQUEST, text(str(error)))
            return
        self._send(HTTPStatus.OK, answer.content)
        if answer.finished:
            self.server.finished.set()

    def _work(self, work: Work, sent: Sent) -> None:
        """What is being done, a line of JSON each, and at last what was found or what is wrong."""
        self.close_connection = True  # which is how the page knows the end
        self._begin(HTTPStatus.OK, Resource("application/x-ndjson", b""))
        try:
            try:
                self._line("done", work.does(sent, lambda words: self._line("says", words)))
            except ElastomorphError as error:
                sent.drop()
                self._line("problem", str(error))
        except OSError:
            return  # whoever asked for it has gone

    def _line(self, name: str, value: object) -> None:
        # A connection that the page has closed can be read, and nothing comes.
        readable = select.select([self.connection], [], [], 0)[0]
        if readable and not self.connection.recv(1, socket.MSG_PEEK):
            raise ConnectionAbortedError
        self.wfile.write(json.dumps({name: value}, allow_nan=False).encode() + b"\n")

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """The same few words for everything that is not there, whatever the reason."""
        status = HTTPStatus(code)
        if status is HTTPStatus.NOT_IMPLEMENTED:  # a method without a do_…
            status = HTTPStatus.METHOD_NOT_ALLOWED
        # The body of a request that was refused is not read, so nothing can follow it.
        self.close_connection = True
        lost = f": {_ANEW}" if status is HTTPStatus.NOT_FOUND else ""
        self._send(status, text(f"{status.phrase}{lost}"))

    def _name(self) -> str | None:
        """What is asked for, by who knows the address; None where somebody does not."""
        port = self.server.server_port
        names = (LOOPBACK, "localhost")
        # A browser leaves the port out of an address where it is the usual one.
        hosts = [*(f"{name}:{port}" for name in names), *(names if port == 80 else ())]
        token, slash, name = self.path.partition("?")[0].removeprefix("/").partition("/")
        known = secrets.compare_digest(token.encode(), self.server.token.encode())
        # Without the slash, the page would look for its models beside the token, not below it.
        if not known or not slash or self.headers.get_all("Host") not in [[host] for host in hosts]:
            return None
        return name

    def _send(self, status: HTTPStatus, what: Resource) -> None:
        content = what.content if isinstance(what.content, bytes) else what.content()
        self._begin(status, what, len(content))
        if self.command != "HEAD":
            self.wfile.write(content)

    def _begin(self, status: HTTPStatus, what: Resource, length: int | None = None) -> None:
        self.send_response(status)
        if status is HTTPStatus.METHOD_NOT_ALLOWED:
            self.send_header("Allow", "GET, HEAD")
        if self.close_connection:
            self.send_header("Connection", "close")
        for name, value in (
            ("Content-Type", what.kind),
            *(() if length is None else (("Content-Length", str(length)),)),
            ("Content-Security-Policy", what.policy),
            ("Cache-Control", "no-store"),
            ("Cross-Origin-Opener-Policy", "same-origin"),
            ("Cross-Origin-Resource-Policy", "same-origin"),
            ("Referrer-Policy", "no-referrer"),
            ("X-Content-Type-Options", "nosniff"),
        ):
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """Nothing: the terminal is for the address."""
