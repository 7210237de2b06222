"""A format under test: its reader, and the inputs it is given."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

from hostile.byte_changes import MOST_BYTES, changed, recoded
from hostile.case import Case, Folder, Link, Pipe
from hostile.judge import sound

__all__ = ["Format"]


@dataclass(frozen=True)
class Format:
    """A format, and how it is attacked.

    Attributes:
        name: What people call it.
        file: Name of the file that the reader is given, or a pattern.
        seeds: Makes whole files; each must load.
        read: The reader.
        judge: Raises where a thing that was read is not what it must be.
        again: Writes a thing to a path below a folder and reads it back; raises where it differs.
            None where the format has no writer.
        crafted: Makes inputs by hand, each a label and the content of the file.
        folders: Makes inputs of several files.
        damage: Makes one input that is intact as a container and damaged within.
        isolated: Whether the reader works in a process of its own.
        wanted: What must become of whole files: "refused" where the format is not read.
    """

    name: str
    file: str
    seeds: Callable[[], list[bytes]]
    read: Callable[[Path], Any]
    judge: Callable[[Any], None] = sound
    again: Callable[[Any, Path], None] | None = None
    crafted: Callable[[], Iterable[tuple[str, bytes]]] = tuple
    folders: Callable[[], Iterable[Case]] = tuple
    damage: Callable[[Random], tuple[str, bytes]] | None = None
    isolated: bool = False
    wanted: str = "loaded"
    _kept: dict[str, list[bytes]] = field(default_factory=dict)

    def whole(self) -> list[bytes]:
        """The seeds, made once."""
        if "seeds" not in self._kept:
            self._kept["seeds"] = self.seeds()
        return self._kept["seeds"]

    def fixed(self) -> Iterator[Case]:
        """All inputs that chance has no part in, but for the cuts."""
        for number, seed in enumerate(self.whole()):
            yield Case(f"seed {number}", self.file, {self.file: seed}, self.wanted)
        yield from _not_files(self.file, self.whole()[0], self.wanted)
        for label, content in recoded(self.whole()[0]).items():
            yield Case(label, self.file, {self.file: content})
        for label, content in self.crafted():
            yield Case(label, self.file, {self.file: content})
        yield from self.folders()

    def cuts(self) -> list[tuple[int, int]]:
        """Every seed at every length."""
        return [(n, length) for n, seed in enumerate(self.whole()) for length in range(len(seed))]

    def cut(self, number: int, length: int) -> Case:
        """A seed cut off."""
        label = f"seed {number} cut to {length} bytes"
        return Case(label, self.file, {self.file: self.whole()[number][:length]})

    def random(self, random: Random) -> Case:
        """An input made by chance."""
        if self.damage is not None and random.random() < 0.5:
            label, content = self.damage(random)
        else:
            seed, other = random.choice(self.whole()), random.choice(self.whole())
            label, content = changed(random, seed, other)
        return Case(label, self.file, {self.file: content[: MOST_BYTES - 1]})


def _not_files(name: str, seed: bytes, wanted: str) -> Iterator[Case]:
    """Links, folders, pipes and devices under the name of a file."""
    if "#" in name:
        return
    suffix = Path(name).suffix
    yield Case("nothing", name, {}, "refused")
    yield Case("a folder", name, {name: Folder()}, "refused")
    yield Case("a pipe", name, {name: Pipe()}, "refused")
    yield Case("an endless device", name, {name: Link("/dev/zero")}, "refused")
    yield Case("an empty device", name, {name: Link("/dev/null")}, "refused")
    yield Case("a link to nothing", name, {name: Link("gone")}, "refused")
    yield Case("a link to itself", name, {name: Link(name)}, "refused")
    yield Case("a link to the file", name, {name: Link("real"), "real": seed}, wanted)
    yield Case("a link out of the folder", name, {name: Link("../../real"), "../../real": seed})
    yield Case("capitals", name.upper(), {name.upper(): seed}, wanted)
    yield Case("blanks and letters", f"a b ß漢{suffix}", {f"a b ß漢{suffix}": seed}, wanted)
    yield Case("a name too long", "n" * 300 + suffix, {}, "refused")
    yield Case("a path too long", "n/" * 3000 + name, {}, "refused")
    yield Case("a file for a folder", f"file/{name}", {"file": seed}, "refused")
    yield Case("the home folder", f"~/{name}", {}, "refused")
    yield Case("a NUL in the name", f"a\0{suffix}", {}, "refused")
