"""The UDP socket that phones send to; nothing is ever sent back."""

from __future__ import annotations

import errno
import ipaddress
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress

from elastomorph.errors import ParameterError
from elastomorph.live.packets import MOST_BYTES
from elastomorph.viewer.listening import LOOPBACK

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
