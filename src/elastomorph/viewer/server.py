"""Shows a page on this machine only: loopback, a free port, a secret in the address.

Other programs on the machine can reach a port of 127.0.0.1, and so can any web page the user has
open. The first keeps out a token that is the first part of every path; the second also the check
of the Host header, for a name that an attacker's server resolves to 127.0.0.1 would otherwise make
this server part of the attacker's own site.
"""

from __future__ import annotations

import secrets
import socket
import socketserver
import threading
from collections.abc import Mapping
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from elastomorph.errors import ElastomorphError, ParameterError
from elastomorph.viewer.answers import HTML, Receiver, Resource, Sent, text
from elastomorph.viewer.page import page_beside
from elastomorph.viewer.scene import Scene
from elastomorph.viewer.shipped import report_policy, served_policy

_LOOPBACK = "127.0.0.1"


def serve(
    scene: Scene, port: int = 0, services: Mapping[str, Receiver | str] | None = None
) -> ViewerServer:
    """A server that shows a scene, listening but not yet answering: enter it with ``with``.

    Args:
        scene: What to show.
        port: Port of 127.0.0.1; a free one for 0.
        services: What the page may ask of the command that shows it, by name: receivers, which
            get addresses of this server, or the address of a WebSocket of this machine.

    Raises:
        ParameterError: The port is taken or not allowed.
        FileError: The viewer's page was not built.
    """
    names = [f"model-{number}.glb" for number in range(len(scene.models))]
    given = services or {}
    receivers = {name: each for name, each in given.items() if isinstance(each, Receiver)}
    sockets = {name: each for name, each in given.items() if isinstance(each, str)}
    page = page_beside(scene, names, {**{name: name for name in receivers}, **sockets})
    policy = served_policy(page, sockets.values())
    resources = {"": Resource(HTML, page.encode(), policy)}
    for name, model in zip(names, scene.models, strict=True):
        resources[name] = Resource("model/gltf-binary", model.glb)
    return ViewerServer(resources, port, receivers)


def serve_page(content: bytes, port: int = 0) -> ViewerServer:
    """A server that shows a finished page, such as a report, which brings everything along."""
    return ViewerServer({"": Resource(HTML, content, report_policy())}, port)


class ViewerServer:
    """Hands out a few things in memory, under one address of this machine.

    Answers while it is entered with ``with``. There are no files behind it: a path is a key of
    the resources, the empty one that of the page, or it is nothing. The secret part of the address
    is the token; port 0 is a free one. Pages may send something where there is a receiver.
    """

    def __init__(
        self,
        resources: Mapping[str, Resource],
        port: int = 0,
        receivers: Mapping[str, Receiver] | None = None,
    ) -> None:
        self.token = secrets.token_urlsafe(24)
        try:
            self._server = _Listener((_LOOPBACK, port), _Handler)
        except (OSError, OverflowError) as error:
            reason = error.strerror if isinstance(error, OSError) else "no such port"
            raise ParameterError(
                f"port {port} of {_LOOPBACK} cannot be used ({reason}); leave the port out for a "
                "free one"
            ) from None
        self._server.token = self.token
        self._server.resources = dict(resources)
        self._server.receivers = dict(receivers or {})
        self._server.finished = threading.Event()
        self._thread = threading.Thread(
            target=self._server.serve_forever, kwargs={"poll_interval": 0.1}, daemon=True
        )

    @property
    def port(self) -> int:
        """The port it listens on."""
        return int(self._server.server_address[1])

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{_LOOPBACK}:{self.port}/{self.token}/"

    def wait(self) -> None:
        """Answer until the user interrupts with Ctrl-C, or a page has sent all there was."""
        try:
            # In short pieces: on some systems a wait without end hears no Ctrl-C.
            while self._thread.is_alive() and not self._server.finished.wait(0.5):
                pass
        except KeyboardInterrupt:
            return

    def __enter__(self) -> ViewerServer:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class _Listener(ThreadingHTTPServer):
    token: str
    resources: dict[str, Resource]
    receivers: dict[str, Receiver]
    finished: threading.Event

    def __init__(self, *words: Any) -> None:
        self._open: set[Any] = set()
        super().__init__(*words)

    def process_request(self, request: Any, client_address: Any) -> None:
        self._open.add(request)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        self._open.discard(request)
        super().shutdown_request(request)

    def server_close(self) -> None:
        """End, also towards those who keep a connection for what they may ask later."""
        super().server_close()
        for request in list(self._open):
            with suppress(OSError):
                request.shutdown(socket.SHUT_RDWR)

    def server_bind(self) -> None:
        # That of HTTPServer looks up the name of the machine, which may take seconds.
        socketserver.TCPServer.server_bind(self)
        self.server_name, self.server_port = _LOOPBACK, int(self.server_address[1])


class _Handler(BaseHTTPRequestHandler):
    server: _Listener
    server_version, sys_version = "elastomorph", ""
    protocol_version = "HTTP/1.1"
    timeout = 30

    def do_GET(self) -> None:
        name = self._name()
        found = None if name is None else self.server.resources.get(name)
        if found is None:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        try:
            self._send(HTTPStatus.OK, found)
        except ElastomorphError as error:
            self._send(HTTPStatus.GONE, text(str(error)))

    def do_HEAD(self) -> None:
        self.do_GET()

    def do_POST(self) -> None:
        receiver = self.server.receivers.get(self._name() or "")
        own = self.headers.get("Origin") == f"http://{self.headers.get('Host')}"
        if receiver is None or not own:
            self.send_error(HTTPStatus.METHOD_NOT_ALLOWED)
            return
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit()):
            self.send_error(HTTPStatus.LENGTH_REQUIRED)
        elif int(length) > receiver.most:
            self.send_error(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
        else:
            words = self.path.partition("?")[2]
            self._receive(receiver, Sent(self.rfile, int(length), words))

    def _receive(self, receiver: Receiver, sent: Sent) -> None:
        try:
            answer = receiver.takes(sent)
        except ElastomorphError as error:
            # It may have been refused before its end, and what is left of it is no request.
            self.close_connection = True
            self._send(HTTPStatus.BAD_REQUEST, text(str(error)))
            return
        self._send(HTTPStatus.OK, answer.content)
        if answer.finished:
            self.server.finished.set()

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """The same few words for everything that is not there, whatever the reason."""
        status = HTTPStatus(code)
        if status is HTTPStatus.NOT_IMPLEMENTED:  # a method without a do_…
            status = HTTPStatus.METHOD_NOT_ALLOWED
        # The body of a request that was refused is not read, so nothing can follow it.
        self.close_connection = True
        self._send(status, text(status.phrase))

    def _name(self) -> str | None:
        """What is asked for, by who knows the address; None where somebody does not."""
        port = self.server.server_port
        names = (_LOOPBACK, "localhost")
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
        self.send_response(status)
        if status is HTTPStatus.METHOD_NOT_ALLOWED:
            self.send_header("Allow", "GET, HEAD")
        if self.close_connection:
            self.send_header("Connection", "close")
        for name, value in (
            ("Content-Type", what.kind),
            ("Content-Length", str(len(content))),
            ("Content-Security-Policy", what.policy),
            ("Cache-Control", "no-store"),
            ("Cross-Origin-Opener-Policy", "same-origin"),
            ("Cross-Origin-Resource-Policy", "same-origin"),
            ("Referrer-Policy", "no-referrer"),
            ("X-Content-Type-Options", "nosniff"),
        ):
            self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def log_message(self, format: str, *args: object) -> None:
        """Nothing: the terminal is for the address."""
