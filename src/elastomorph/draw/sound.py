"""The sound of a movie: of a sound file or another movie, laid to the picture sample by sample."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

from elastomorph.draw.movie import find_encoder
from elastomorph.errors import FormatError
from elastomorph.io.atomic import opened

SAMPLES = 48_000
"""A second."""


@dataclass(frozen=True)
class Sound:
    """What is heard with a movie.

    Attributes:
        path: WAV, MP3, or whatever else ffmpeg hears something in, such as a movie.
        start: The second of it that is heard with the first frame; below 0, it begins later.
        seconds: How long the movie is: what is missing at the end is silent.
    """

    path: Path
    start: float
    seconds: float

    @property
    def words(self) -> list[str]:
        """What tells ffmpeg to read it, as its second input, and to lay it to the picture."""
        # Counted in samples from the beginning of the file, whatever its own time stamps are.
        steps = [f"aresample={SAMPLES}:async=1:first_pts=0"]
        first = round(self.start * SAMPLES)
        if first > 0:
            steps += [f"atrim=start_sample={first}", "asetpts=PTS-STARTPTS"]
        elif first < 0:
            steps.append(f"adelay=delays={-first}S:all=1")
        steps += ["apad", f"atrim=end_sample={round(self.seconds * SAMPLES)}"]
        heard = ["-map", "0:v:0", "-map", "1:a:0", "-af", ",".join(steps)]
        coded = ["-c:a", "aac", "-b:a", "192k", "-flags:a", "+bitexact"]
        return [*_input(self.path), *heard, *coded]


def sound_length(path: str | Path) -> float:
    """Seconds of sound in a file, counted by decoding it.

    Raises:
        FileError: It is missing or cannot be read.
        FormatError: There is no sound in it.
    """
    with opened(path):
        pass
    command = [find_encoder(), "-nostdin", "-hide_banner", "-loglevel", "error"]
    command += [*_input(Path(path)), "-map", "0:a:0", "-af", f"aresample={SAMPLES}:async=1"]
    told = subprocess.run(
        [*command, "-f", "null", "-progress", "pipe:1", "-"], capture_output=True, text=True
    )
    lengths = re.findall(r"^out_time_us=(\d+)$", told.stdout, re.MULTILINE)
    seconds = int(lengths[-1]) / 1e6 if lengths else 0.0
    if seconds <= 0:
        raise FormatError(
            path, "there is no sound in it that can be read; expected WAV, MP3 or a movie with it"
        )
    return seconds


def _input(path: Path) -> list[str]:
    """A file of this machine and nothing else: a playlist in it opens no address."""
    return ["-protocol_whitelist", "file,pipe", "-i", f"file:{path}"]
