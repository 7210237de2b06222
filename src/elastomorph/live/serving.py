"""A rig served to this machine, moved by a phone: poses to its pages, and what people press back.

As for pages themselves (`viewer.server`): the loopback only, a secret in the address, and only the
page that was served with it may connect to the WebSocket, which browsers tell by its origin. Of
poses a page is sent the newest when it has drawn the one before the last, so a page that is slow or
hidden has nothing in wait for it.

The UDP socket that phones send to; nothing is ever sent back.
"""

from __future__ import annotations

import errno
import http
import ipaddress
import json
import logging
import secrets
import socket
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elastomorph.errors import MissingExtraError, ParameterError
from elastomorph.io.atomic import require_writable
from elastomorph.live.packets import MOST_BYTES
from elastomorph.live.session import Session, next_file
from elastomorph.rig import Rig
from elastomorph.viewer import rig_scene, serve
from elastomorph.viewer.listening import LOOPBACK
from elastomorph.viewer.scene import Scene

if TYPE_CHECKING:
    from websockets.http11 import Request, Response
    from websockets.sync.server import ServerConnection


PORT = 11111
"""The port that Live Link Face sends to unless told otherwise."""

_ADDRESSES = f"expected one of this machine such as {LOOPBACK}, or 0.0.0.0 for all its networks"
_NOT_HERE = (errno.EADDRNOTAVAIL, errno.ENODEV, socket.EAI_NONAME)

_WAIT = 0.2
# Of a flood, so many packets are taken at a time: it must not keep pages from their turn. Eight
# phones send 480 a second.
_FLOOD = 5000
_BATCH = 256
_PAUSE = 0.005


class Receiver:
    """Listens while it is entered with ``with``.

    Of what comes faster than it can be read the system keeps a little and drops the rest, so no
    flood takes memory.

    Args:
        take: Gets each packet, and where it came from.
        host: Address of this machine to listen on, such as 127.0.0.1 for programs on this machine
            only, or 0.0.0.0 for all its networks.
        port: Port, a free one for 0.

    Raises:
        ParameterError: It is no address of this machine, or the port is taken.
    """

    def __init__(
        self, take: Callable[[bytes, str], None], host: str = LOOPBACK, port: int = PORT
    ) -> None:
        self._take = take
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        try:
            own = ipaddress.ip_address(host)
        except ValueError:
            raise ParameterError(f"{host!r} is no address to listen on; {_ADDRESSES}") from None
        family = socket.AF_INET6 if own.version == 6 else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            if isinstance(error, OSError) and error.errno in _NOT_HERE:
                raise ParameterError(
                    f"{host} is no address of this machine; {_ADDRESSES}"
                ) from None
            reason = error.strerror if isinstance(error, OSError) else "no such port"
            raise ParameterError(
                f"UDP port {port} of {host} cannot be listened on ({reason}); end the program that "
                "uses it, or choose another with --port and in the app"
            ) from None
        self._socket.settimeout(_WAIT)

    @property
    def meaning(self) -> str:
        """What listening there means, in a sentence."""
        own = ipaddress.ip_address(self._socket.getsockname()[0])
        where = f"[{own}]:{self.port}" if own.version == 6 else f"{own}:{self.port}"
        if own.is_loopback:
            return (
                f"listening on UDP {where}: programs of this machine may send; for a phone "
                "add --listen 0.0.0.0"
            )
        seen = _address_outside() if own.is_unspecified else str(own)
        target = f" (in the app: {seen})" if seen else ""
        return (
            f"listening on UDP {where}{target}: anybody on that network may send; nothing is sent "
            "back, and the page stays on this machine"
        )

    @property
    def port(self) -> int:
        """The port it listens on."""
        return int(self._socket.getsockname()[1])

    def close(self) -> None:
        """Free its port, also where it was never entered."""
        self._socket.close()

    def __enter__(self) -> Receiver:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ended.set()
        self._thread.join()
        self.close()

    def _run(self) -> None:
        count, begun = 0, time.monotonic()
        while not self._ended.is_set():
            # Some systems say of packets that are too long that they are an error.
            with suppress(OSError):
                self._receive()
                count += 1
            if count >= _BATCH:
                if time.monotonic() - begun < _BATCH / _FLOOD:
                    time.sleep(_PAUSE)
                count, begun = 0, time.monotonic()
        # What had come before the end still counts.
        self._socket.setblocking(False)
        with suppress(OSError):
            for _ in range(_BATCH):
                self._receive()

    def _receive(self) -> None:
        content, address = self._socket.recvfrom(MOST_BYTES + 1)
        self._take(content, str(address[0]))


def _address_outside() -> str | None:
    """The address of this machine on the network that leads out, if it is on one.

    A system chooses it for a socket that is to send; nothing is sent.
    """
    with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as unsent:
        unsent.connect(("192.0.2.1", 9))  # an address that is nobody's
        return str(unsent.getsockname()[0])
    return None


_MOST_BYTES = 256  # of what a page sends
_MOST_PAGES = 8
_STATUS = 0.25  # seconds from one status to the next
_AHEAD = 2  # poses on their way to a page
_PATIENCE = 1.0  # seconds after which a pose that was not drawn, as in a hidden page, is given up
_POLICY = 1008


def require_websockets() -> None:
    """Refuse to begin without the package, before any work is done.

    Raises:
        MissingExtraError: It is not installed.
    """
    try:
        import websockets.sync.server  # noqa: F401
    except ImportError as error:
        raise MissingExtraError("websockets", "live") from error


class Pages:
    """Serves pages while it is entered with ``with``.

    Args:
        session: What they show.

    Raises:
        MissingExtraError: websockets is not installed.
    """

    def __init__(self, session: Session) -> None:
        require_websockets()
        self.session = session
        self.origins: frozenset[str] = frozenset()
        """Where the page comes from; nobody may connect before it is known."""
        self._token = secrets.token_urlsafe(24)
        self._count = threading.Semaphore(_MOST_PAGES)
        self._socket = socket.create_server((LOOPBACK, 0))
        self._open = ExitStack()

    @property
    def port(self) -> int:
        """The port it listens on."""
        return int(self._socket.getsockname()[1])

    @property
    def address(self) -> str:
        """Where pages find it."""
        return f"ws://{LOOPBACK}:{self.port}/{self._token}/"

    def admit_page(self, port: int) -> None:
        """Let the page connect that is served at a port of the loopback."""
        self.origins = frozenset(f"http://{name}:{port}" for name in (LOOPBACK, "localhost"))

    def close(self) -> None:
        """Free its port, also where it was never entered."""
        self._open.close()
        self._socket.close()

    def __enter__(self) -> Pages:
        from websockets.sync.server import serve

        quiet = logging.getLogger(__name__)
        quiet.addHandler(logging.NullHandler())
        quiet.propagate = False  # who knocks without the secret is nobody's concern
        server = serve(
            self._handle,
            sock=self._socket,
            process_request=self._admit,
            compression=None,
            max_size=_MOST_BYTES,
            max_queue=64,
            server_header=None,
            close_timeout=_PATIENCE,  # a page that hangs must not keep Ctrl-C waiting
            logger=quiet,
        )
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        self._open.callback(thread.join)
        self._open.callback(server.shutdown)
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        """None for the page that was served; for everybody else the same few words."""
        token = request.path.removeprefix("/").removesuffix("/")
        known = secrets.compare_digest(token.encode(), self._token.encode())
        origins = request.headers.get_all("Origin")
        hosts = request.headers.get_all("Host")
        own = len(origins) == 1 and origins[0] in self.origins
        if known and own and hosts == [f"{LOOPBACK}:{self.port}"]:
            return None
        return connection.respond(http.HTTPStatus.NOT_FOUND, "Not Found\n")

    def _handle(self, connection: ServerConnection) -> None:
        if not self._count.acquire(blocking=False):
            connection.close(_POLICY, "too many pages")
            return
        try:
            _Page(self.session, connection).run()
        finally:
            self._count.release()


class _Page:
    """One page that is connected: a thread sends, another hears what it says."""

    def __init__(self, session: Session, connection: ServerConnection) -> None:
        self._session, self._connection = session, connection
        self._sent: dict[int, tuple[float | None, float]] = {}
        self._last = 0
        self._watches = self._begins = True
        self._moved = threading.Condition()
        self._gone = False

    def run(self) -> None:
        from websockets.exceptions import ConnectionClosed

        sender = threading.Thread(target=self._send, daemon=True)
        sender.start()
        with suppress(ConnectionClosed):
            for message in self._connection:
                if not self._hear(message):
                    self._connection.close(_POLICY, "not understood")
        with self._moved:
            self._gone = True
            self._moved.notify_all()
        sender.join()

    def _send(self) -> None:
        from websockets.exceptions import ConnectionClosed

        sliders = {"sliders": list(self._session.match.sliders)}
        with suppress(ConnectionClosed):
            self._tell(sliders)
            told = 0.0
            while not (self._gone or self._session.closed):
                if time.monotonic() >= told + _STATUS:
                    told = time.monotonic()
                    self._tell({"status": self._session.status().for_page()})
                if not self._may_send():
                    continue
                pose = self._session.newest(self._last, _STATUS)
                if pose is not None:
                    with self._moved:
                        # The first may have waited for the page, not the page for it.
                        arrived = None if self._begins else pose.arrived
                        self._sent[pose.number] = (arrived, time.monotonic())
                        self._last, self._begins = pose.number, False
                    shown = {"weights": pose.weights, "head": pose.head}
                    self._tell({"pose": pose.number, **shown})
            self._connection.close()

    def _may_send(self) -> bool:
        """Whether another pose may go, after waiting a little for it."""

        def free() -> bool:
            given_up = time.monotonic() - _PATIENCE
            for number, (_, sent) in list(self._sent.items()):
                if sent < given_up:
                    del self._sent[number]
            return self._gone or (self._watches and len(self._sent) < _AHEAD)

        with self._moved:
            return self._moved.wait_for(free, _STATUS)

    def _tell(self, message: dict[str, Any]) -> None:
        self._connection.send(json.dumps(message, separators=(",", ":"), allow_nan=False))

    def _hear(self, message: str | bytes) -> bool:
        """Do what a page says; False where that is nothing it may say."""
        try:
            said = json.loads(message)
        except (ValueError, RecursionError):
            return False
        if not isinstance(said, dict) or len(said) != 1:
            return False
        ((what, value),) = said.items()
        is_number = isinstance(value, int) and not isinstance(value, bool)
        switches = {
            "watches": self._watch,
            "neutral": self._session.set_neutral,
            "record": self._session.record,
        }
        if what == "drawn" and is_number:
            self._was_drawn(value)
        elif what == "phone" and is_number:
            self._session.choose(value)
        elif what in switches and isinstance(value, bool):
            switches[what](value)
        else:
            return False
        return True

    def _watch(self, watches: bool) -> None:
        with self._moved:
            self._watches, self._begins, self._last = watches, True, 0
            self._sent.clear()
            self._moved.notify_all()

    def _was_drawn(self, number: int) -> None:
        with self._moved:
            arrived = self._sent.get(number, (None, 0.0))[0]
            # Those before it were taken over by it, and will never be drawn.
            for sent in [sent for sent in self._sent if sent <= number]:
                del self._sent[sent]
            self._moved.notify_all()
        if arrived is not None:
            self._session.was_drawn(arrived)


def require_possible(
    host: str = LOOPBACK, port: int = PORT, record: str | Path | None = None
) -> None:
    """Refuse what could not be received or recorded, before a rig is read, which may take long.

    Raises:
        ParameterError: An address or port cannot be used, or the file is none of a take.
        FileError: The file cannot be written.
        MissingExtraError: websockets is not installed.
    """
    require_websockets()
    if record is not None:
        if Path(record).suffix.lower() != ".csv":
            raise ParameterError(f"{record}: takes are recorded as .csv")
        require_writable(next_file(Path(record)))
    Receiver(lambda content, address: None, host, port).close()


class LivePage:
    """Receives packets and shows the face they make while it is entered with ``with``.

    Args:
        rig: The rig.
        name: What the page calls it.
        host: Address of this machine that phones send to; the loopback by default, which only
            programs of this machine reach.
        port: UDP port that phones send to; a free one for 0.
        page_port: Port of the page; a free one for 0, for None as for the viewer's `serve`.
        subject: Name or id of the phone to show; the first that sends by default.
        record: A file (.csv) to record to; none is recorded without it.
        scene: What the page shows of the rig; the rig anew by default, without colours and normals
            of vertices that its file may have.

    Raises:
        ParameterError: No weight of ARKit drives a slider of the rig, or an address or port cannot
            be used.
        FileError: The file cannot be written.
        MissingExtraError: websockets is not installed.
    """

    def __init__(
        self,
        rig: Rig,
        *,
        name: str = "live",
        host: str = LOOPBACK,
        port: int = PORT,
        page_port: int | None = 0,
        subject: str | None = None,
        record: str | Path | None = None,
        scene: Scene | None = None,
    ) -> None:
        require_possible(host, port, record)
        self.session = Session(rig.names, subject, None if record is None else Path(record))
        if not self.session.match.drives:
            if not rig.names:
                raise ParameterError(
                    "the rig has no sliders, so there is nothing that a phone could move; export "
                    "it with its blend shapes"
                )
            raise ParameterError(
                f"no weight of ARKit drives a slider of the rig ({', '.join(rig.names[:8])}); "
                "rename its sliders as ARKit or VRM do"
            )
        self._open = ExitStack()
        with ExitStack() as made:
            self._receiver = Receiver(self.session.take, host, port)
            made.callback(self._receiver.close)
            self._pages = Pages(self.session)
            made.callback(self._pages.close)
            shown = replace(scene or rig_scene(rig, name=name), start={"live": True})
            self.server = serve(shown, page_port, {"live": self._pages.address})
            made.pop_all()
        self._pages.admit_page(self.server.port)

    @property
    def port(self) -> int:
        """The UDP port that phones send to."""
        return self._receiver.port

    @property
    def address(self) -> str:
        """Where the page is."""
        return self.server.address

    @property
    def meaning(self) -> str:
        """What it means that phones send there, in a sentence."""
        return self._receiver.meaning

    def __enter__(self) -> LivePage:
        # Closed in the opposite order: first nothing comes any more, then the recording ends.
        for part in (self.server, self._pages):
            self._open.enter_context(part)
        self._open.callback(self.session.close)
        self._open.enter_context(self._receiver)
        return self

    def __exit__(self, *error: object) -> None:
        self._open.close()
