"""Takes recorded from a stream, in the columns of Live Link Face (.csv)."""

from __future__ import annotations

import errno
import heapq
import itertools
import os
import sys
from contextlib import ExitStack
from io import FileIO
from pathlib import Path

from elastomorph.errors import ElastomorphError
from elastomorph.io.atomic import replacing_path
from elastomorph.io.timecode import BASES, TimecodeClock
from elastomorph.live.packets import COLUMNS, NAMES, FacePacket
from elastomorph.live.phones import Order

_HELD = 0.25  # seconds that frames wait for late ones before they are written
_LONGEST_PAUSE = 60.0  # seconds; a longer one is between two takes
_LIVE_LINK_BASE = 60
_FROM_PACKET = [NAMES.index(name) for name in COLUMNS]
_HEADER = ",".join(["Timecode", "BlendShapeCount", *COLUMNS])
_NO_FACE = f"0{',' * len(COLUMNS)}"


class Recorder:
    """Records one phone at a time, each recording into a file of its own.

    A file appears when its recording ends: until then it has a temporary name beside it. Frames
    are kept as they were sent, sorted, each once; what is later than a quarter of a second is left
    out. In memory are only those that wait. Where no more can be written, as on a full disk, the
    file holds the whole lines until then.

    Args:
        path: The first file; later ones are ``take-2.csv`` and so on. A face cannot be recorded
            again, so none of them replaces a file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.wanted = False
        self.problem = ""
        self.frames = 0
        self.files: list[tuple[Path, int]] = []
        """Those that were written, and how many frames are in each."""
        self._file: FileIO | None = None
        self._lines = self._bytes = 0  # written whole
        self._open = ExitStack()
        self._final = path
        self._device = ""
        self._waiting: list[tuple[float, int, FacePacket]] = []
        self._turn = itertools.count()
        self._newest = self._written = float("-inf")

    def start(self) -> None:
        """Record from the next frame on."""
        self.wanted, self.problem = True, ""

    def stop(self) -> None:
        """End the recording, if there is one: its file is then there."""
        self.wanted = False
        self._finish()

    def take(self, packet: FacePacket, order: Order, position: float) -> None:
        """Record a frame, unless it was there already or is of another phone or stream."""
        if not self.wanted or order in ("twice", "apart"):
            return
        if self._file is not None and packet.device != self._device:
            return
        pause = (position - self._newest) / packet.per_second
        try:
            if self._file is not None and (order == "again" or pause > _LONGEST_PAUSE):
                self._finish()
            if self._file is None:
                self._begin(packet.device)
            if position <= self._written:
                return
            self._newest = max(self._newest, position)
            self.frames += 1
            heapq.heappush(self._waiting, (position, next(self._turn), packet))
            self._write(self._newest - _HELD * packet.per_second)
        except (ElastomorphError, OSError) as error:
            self._give_up(error)

    @property
    def file(self) -> Path | None:
        """The file that is being recorded."""
        return None if self._file is None else self._final

    def _begin(self, device: str) -> None:
        self._final = next_file(self.path)
        place = self._open.enter_context(replacing_path(self._final))
        self._file = self._open.enter_context(FileIO(place, "w"))
        self._device, self.frames, self._lines, self._bytes = device, 0, 0, 0
        self._put(self._file, _HEADER)
        self._newest = self._written = float("-inf")

    def _write(self, until: float) -> None:
        while self._file is not None and self._waiting and self._waiting[0][0] <= until:
            self._written, _, packet = heapq.heappop(self._waiting)
            self._put(self._file, _row(packet))
            self._lines += 1

    def _put(self, file: FileIO, line: str) -> None:
        """Write a line, at once: what waited in a buffer would be lost where the disk is full."""
        content = f"{line}\n".encode()
        if file.write(content) < len(content):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._bytes += len(content)

    def _finish(self) -> None:
        try:
            self._write(float("inf"))
            self._close()
        except (ElastomorphError, OSError) as error:
            self._give_up(error)

    def _close(self) -> None:
        if self._file is not None:
            os.fsync(self._file.fileno())
            self._file = None
            self._open.close()
            self.files.append((self._final, self._lines))

    def _give_up(self, error: Exception) -> None:
        """End with what was written; the stream goes on."""
        self.wanted = False
        self._waiting.clear()
        self.problem = (isinstance(error, OSError) and error.strerror) or str(error)
        try:
            if self._file is not None and self._lines > 0:
                self._file.truncate(self._bytes)
                self._close()
                self.problem += f"; the {self._lines:,} frames until then are in {self._final.name}"
            self._open.__exit__(*sys.exc_info())
        except (ElastomorphError, OSError) as last:
            self.problem = str(last)
        self._file, self._open = None, ExitStack()


def next_file(path: Path) -> Path:
    """Where a recording goes: ``take.csv``, or ``take-2.csv`` and so on where that is there."""
    file, number = path, 1
    while file.exists():
        number += 1
        file = path.with_stem(f"{path.stem}-{number}")
    return file


def _row(packet: FacePacket) -> str:
    """A line of a take: the timecode, how many weights, and these."""
    base = round(packet.per_second)
    count = packet.count
    if base not in BASES:
        base, count = _LIVE_LINK_BASE, count * _LIVE_LINK_BASE / packet.per_second
    # The numbering without drop-frame: what is counted are frames.
    timecode = TimecodeClock(base, False, float(base)).text(count, 3)
    if not packet.weights:
        return f"{timecode},{_NO_FACE}"
    weights = (f"{packet.weights[place]:.10f}" for place in _FROM_PACKET)
    return f"{timecode},{len(COLUMNS)},{','.join(weights)}"
