"""Numbered files: the frames of a motion, of which one is damaged or out of place."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from elastomorph.io.npz import write_npz
from elastomorph.io.obj import write_obj
from hostile import archives
from hostile.byte_changes import MOST_BYTES, changed
from hostile.case import Case, Folder, Link, Pipe
from hostile.format import Format
from hostile.seeds import face, written

__all__ = ["NumberedFrames", "sequence_folders"]


class NumberedFrames(Format):
    """Every random input is a whole frame beside a damaged one."""

    def random(self, random: Random) -> Case:
        """A damaged frame."""
        obj = self.whole()[0]
        label, content = changed(random, obj, obj)
        return Case(label, self.file, {"scan.1.obj": obj, "scan.2.obj": content})

    def cut(self, number: int, length: int) -> Case:
        """A frame cut off."""
        obj = self.whole()[0]
        files = {"scan.1.obj": obj, "scan.2.obj": obj[:length]}
        return Case(f"a frame cut to {length} bytes", self.file, dict(files))

    def fixed(self) -> Iterator[Case]:
        """All folders made by hand."""
        yield from self.folders()


def sequence_folders() -> Iterator[Case]:
    """Numbered files that do not fit each other, or whose numbers do not."""
    obj = written("a.obj", write_obj, face())
    npz = written("a.npz", write_npz, face())
    two = {"scan.1.obj": obj, "scan.2.obj": obj}
    yield Case("two frames", "scan.#.obj", dict(two), "loaded")
    yield Case("a wildcard", "scan.*.obj", dict(two), "loaded")
    yield Case("the folder", "", dict(two), "loaded")
    yield Case("archives", "scan.#.npz", {"scan.1.npz": npz, "scan.2.npz": npz}, "loaded")
    yield Case("one frame", "scan.#.obj", {"scan.1.obj": obj}, "refused")
    yield Case("none", "scan.#.obj", {}, "refused")
    yield Case("one number twice", "scan.#.obj", {"scan.1.obj": obj, "scan.01.obj": obj}, "refused")
    for number in ("9" * 200, "2147483648", "99999999999999999999"):
        yield Case(f"number {number[:9]}", "scan.#.obj", {**two, f"scan.{number}.obj": obj})
        near = {f"scan.{number[:-1]}{i}.obj": obj for i in (7, 8)}
        yield Case(f"numbers near {number[:9]}", "scan.#.obj", near)
    yield Case(
        "a link to itself", "scan.#.obj", {**two, "scan.3.obj": Link("scan.3.obj")}, "refused"
    )
    yield Case("a pipe among them", "scan.#.obj", {**two, "scan.3.obj": Pipe()}, "refused")
    yield Case("a folder among them", "scan.#.obj", {**two, "scan.3.obj": Folder()}, "loaded")
    yield Case(
        "a link among them", "scan.#.obj", {**two, "scan.3.obj": Link("scan.1.obj")}, "loaded"
    )
    yield Case("an empty frame", "scan.#.obj", {**two, "scan.3.obj": b""}, "refused")
    yield Case("another mesh", "scan.#.obj", {**two, "scan.3.obj": b"v 0 0 0\n"}, "refused")
    yield Case("brackets", "scan.[.obj", dict(two), "refused")
    yield Case("two runs", "s#n.#.obj", dict(two), "refused")
    yield Case("only #", "#.obj", {"1.obj": obj, "2.obj": obj}, "loaded")
    yield Case("a NUL", "scan.\0#.obj", dict(two), "refused")
    yield Case("formats mixed", "", {**two, "scan.3.npz": npz}, "refused")
    yield Case("two thousand frames", "f#.obj", {f"f{i}.obj": obj for i in range(1900)}, "loaded")
    zeros = next(
        content
        for label, content in archives.archive_files({"vertices": face().vertices}, "vertices")
        if label.startswith("vertices of 40 MB of zeros as i1")
    )
    bombs = {f"f{i}.npz": zeros for i in range(MOST_BYTES // len(zeros))}
    yield Case("archives of zeros", "f#.npz", dict(bombs))
    for cut in range(0, len(obj), 7):
        yield Case(f"a frame cut to {cut}", "scan.#.obj", {**two, "scan.3.obj": obj[:cut]})
