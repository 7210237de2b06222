"""A rig served to this machine, moved by a phone."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from elastomorph.errors import ParameterError
from elastomorph.io.atomic import require_writable
from elastomorph.live.pages import Pages, require_websockets
from elastomorph.live.receiver import PORT, Receiver
from elastomorph.live.recording import next_file
from elastomorph.live.session import Session
from elastomorph.rig import Rig
from elastomorph.viewer import rig_scene, serve
from elastomorph.viewer.listening import LOOPBACK
from elastomorph.viewer.scene import Scene


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
