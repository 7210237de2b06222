"""One hostile input: what lies in its folder, and which of it a reader is given."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass, field
from pathlib import Path

__all__ = ["Case", "Entry", "Folder", "Link", "Pipe"]


@dataclass(frozen=True)
class Link:
    """A symbolic link to a name, inside the folder or out of it."""

    target: str


@dataclass(frozen=True)
class Folder:
    """An empty folder under the name of a file."""


@dataclass(frozen=True)
class Pipe:
    """A named pipe that nobody ever writes to."""


Entry = bytes | Link | Folder | Pipe


@dataclass(frozen=True)
class Case:
    """An input.

    Attributes:
        label: What was done to make it.
        name: The path given to the reader, below the folder of the case; a pattern for sequences.
        files: What lies in the folder, by name; names may lead into folders and, with ``..``, one
            step out of it.
        wanted: Whether it must be refused ("refused"), must load ("loaded"), or may do either.
    """

    label: str
    name: str
    files: dict[str, Entry] = field(default_factory=dict)
    wanted: str = "either"

    @property
    def size(self) -> int:
        """Bytes of all files together."""
        return sum(len(entry) for entry in self.files.values() if isinstance(entry, bytes))

    def write(self, folder: Path) -> Path:
        """Write it below a folder that is emptied first; returns the path for the reader."""
        shutil.rmtree(folder, ignore_errors=True)
        inside = folder / "inside"
        inside.mkdir(parents=True)
        for name, entry in self.files.items():
            path = inside / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(entry, Link):
                path.symlink_to(entry.target)
            elif isinstance(entry, Folder):
                path.mkdir()
            elif isinstance(entry, Pipe):
                os.mkfifo(path)
            else:
                path.write_bytes(entry)
        return inside / self.name
