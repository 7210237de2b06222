"""Lets atheris choose inputs by the code they reach.

Started by ``hostile_files.py --atheris`` as ``python -m hostile.fuzz FORMAT [SECONDS]``, in a
process of its own, as only modules that are imported under its eye can be watched.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["elastomorph.io", "elastomorph.model.mesh"]):
    from hostile.trial import find_format

from hostile.byte_changes import MOST_BYTES
from hostile.case import Case
from hostile.judge import judged


def main(name: str, seconds: str = "0") -> None:
    """Fuzz a format; ends at the first failure, or after some seconds."""
    known = find_format(name)
    place = Path(tempfile.mkdtemp(prefix="hostile-"))
    seeds = place / "seeds"
    seeds.mkdir()
    for number, seed in enumerate(known.whole()):
        (seeds / str(number)).write_bytes(seed)

    def one(content: bytes) -> None:
        path = Case("atheris", known.file, {known.file: content}).write(place / "trial")
        thing, _ = judged(known.read, path, place / "trial")
        if thing is not None:
            known.judge(thing)

    options = [f"-max_len={MOST_BYTES - 1}", f"-max_total_time={seconds}", "-timeout=10"]
    atheris.Setup([sys.argv[0], *options, str(seeds)], one)
    atheris.Fuzz()


if __name__ == "__main__":
    main(*sys.argv[1:])
