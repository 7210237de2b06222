"""The UDP socket that phones send to; nothing is ever sent back."""

from __future__ import annotations

import ipaddress
import socket
import threading
import time
from collections.abc import Callable
from types import TracebackType

from elastomorph.errors import ParameterError
from elastomorph.live.packets import MOST_BYTES

LOOPBACK = "127.0.0.1"
PORT = 11111
"""The port that Live Link Face sends to unless told otherwise."""

_WAIT = 0.2
_BATCH = 256  # packets taken before others have their turn: a flood must not keep pages from theirs
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
        in_a_row = 0
        while not self._ended.is_set():
            begun = time.monotonic()
            try:
                content, address = self._socket.recvfrom(MOST_BYTES + 1)
            except TimeoutError:
                in_a_row = 0
                continue
            except OSError:  # what some systems say of packets that are too long
                continue
            in_a_row = in_a_row + 1 if time.monotonic() - begun < _PAUSE / _BATCH else 0
            self._take(content, str(address[0]))
            if in_a_row > _BATCH:
                in_a_row = 0
                time.sleep(_PAUSE)
