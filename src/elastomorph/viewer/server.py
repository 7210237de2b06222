"""Shows a page on this machine only: loopback, a free port, a secret in the address."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Mapping

from elastomorph.errors import ParameterError
from elastomorph.viewer.listening import (
    HTML,
    LOOPBACK,
    Handler,
    Listener,
    Offer,
    Receiver,
    Resource,
    Work,
    model_file,
)
from elastomorph.viewer.page import page_beside, report_policy, served_policy
from elastomorph.viewer.scene import Scene

# Browsers keep what people make by the port of a page, so it is the same one whenever it can be:
# one that nobody has registered, below those that systems hand out.
USUAL_PORT = 21738


def serve(
    scene: Scene,
    port: int | None = 0,
    services: Mapping[str, Receiver | Work | str] | None = None,
    shelf: dict[str, Offer] | None = None,
) -> ViewerServer:
    """A server that shows a scene, listening but not yet answering: enter it with ``with``.

    Args:
        scene: What to show.
        port: Port of 127.0.0.1; a free one for 0. For None it is `USUAL_PORT`, by which browsers
            find again what they kept, or a free one where that is taken.
        services: What the page may ask of the command that shows it, by name: receivers, which
            get addresses of this server, or the address of a WebSocket of this machine.
        shelf: What there is by address, filled here; services may put more on it later.

    Raises:
        ParameterError: The port is taken or not allowed.
        FileError: The viewer's page was not built.
    """
    names = [f"model-{number}.glb" for number in range(len(scene.models))]
    offers = {} if shelf is None else shelf
    addresses: dict[str, str] = {}
    for name, service in (services or {}).items():
        addresses[name] = service if isinstance(service, str) else name
        offers |= {} if isinstance(service, str) else {name: service}
    page = page_beside(scene, names, addresses)
    sockets = [service for service in addresses.values() if service not in offers]
    offers[""] = Resource(HTML, page.encode(), served_policy(page, sockets))
    for name, model in zip(names, scene.models, strict=True):
        offers[name] = model_file(model.glb)
    return ViewerServer(offers, port)


def serve_page(content: bytes, port: int = 0) -> ViewerServer:
    """A server that shows a finished page, such as a report, which brings everything along."""
    return ViewerServer({"": Resource(HTML, content, report_policy())}, port)


class ViewerServer:
    """Hands out a few things in memory, under one address of this machine.

    Answers while it is entered with ``with``. There are no files behind it: a path is a key of
    the shelf, the empty one that of the page, or it is nothing. The secret part of the address is
    the token; port 0 is a free one, None as for `serve`.
    """

    def __init__(self, shelf: dict[str, Offer], port: int | None = 0) -> None:
        self.token = secrets.token_urlsafe(24)
        self._server = _usual_listener() if port is None else _listener(port)
        self._lacks_usual = port is None and self.port != USUAL_PORT
        self._server.token = self.token
        self._server.shelf = shelf
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
        return f"http://{LOOPBACK}:{self.port}/{self.token}/"

    @property
    def words(self) -> str:
        """Where the page is and what that means, for people."""
        found = f"{self.address}\nshown to this machine only; Ctrl-C ends it"
        if not self._lacks_usual:
            return found
        return (
            f"{found}\nport {USUAL_PORT} is in use, so the page begins without the poses that the "
            "browser keeps there"
        )

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


def _listener(port: int) -> Listener:
    try:
        return Listener((LOOPBACK, port), Handler)
    except (OSError, OverflowError) as error:
        reason = error.strerror if isinstance(error, OSError) else "no such port"
        raise ParameterError(
            f"port {port} of {LOOPBACK} cannot be used ({reason}); leave the port out for a "
            "free one"
        ) from None


def _usual_listener() -> Listener:
    try:
        return _listener(USUAL_PORT)
    except ParameterError:  # another page has it, or the system does not give it away
        return _listener(0)
