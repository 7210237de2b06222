"""The UDP socket that phones send to; nothing is ever sent back."""

from __future__ import annotations

import ipaddress
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType

from elastomorph.errors import ParameterError
from elastomorph.live.packets import MOST_BYTES

LOOPBACK = "127.0.0.1"
PORT = 11111
"""The port that Live Link Face sends to unless told otherwise."""

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
            raise ParameterError(
                f"{host!r} is no address to listen on; expected one of this machine such as "
                f"{LOOPBACK}, or 0.0.0.0 for all its networks"
            ) from None
        family = socket.AF_INET6 if own.version == 6 else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            reason = error.strerror if isinstance(error, OSError) else "no such port"
            raise ParameterError(
                f"UDP port {port} of {host} cannot be listened on ({reason}); end the program that "
                "uses it, or choose another with --port and in the app"
            ) from None
        self._socket.settimeout(_WAIT)

    @property
    def meaning(self) -> str:
        """What listening there means, in a sentence."""
        host, port = self._socket.getsockname()[:2]
        if ipaddress.ip_address(host).is_loopback:
            return (
                f"listening on UDP {host}:{port}: programs of this machine may send; for a phone "
                "add --listen 0.0.0.0"
            )
        return (
            f"listening on UDP {host}:{port}: anybody on that network may send; nothing is sent "
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

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
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
