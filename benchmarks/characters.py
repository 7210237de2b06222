"""Whether characters come out of `bend` whole, with their paths bent: a row a file.

Run:  python benchmarks/characters.py FILE… [--synthetic] [--no-validator]

Each file is bent, and judged by code that shares nothing with the package (``acceptance/``): the
Khronos validator finds nothing new; what bends do not need is as it was; with every slider at 0 and
1, and every clip at its keys, vertices are where they were; between, they follow ``auto``, which is
computed anew from the original; `unbend` gives the original back; bending twice is bending once;
players of VRM show what they showed; a dry run says what is then written.

Prints targets of the mesh that has most of them, sliders that bend, bytes, seconds, and the largest
deviations as fractions of D: at the ends, from ``auto`` between (and how far that is from the
straight line), of clips between keys. Where a path is unsteady, it is compared
within what numbers a hundred-millionth off make of it. Problems follow below a row; any ends with
status 1.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from acceptance.judging import Verdict, judge

HEAD = (
    f"{'file':32} {'targets':>9} {'bent':>4} {'bytes before':>12} {'after':>10} {'ratio':>5} "
    f"{'s':>5} {'ends':>7} {'between':>7} {'straight':>8} {'clips':>7}  problems"
)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--synthetic", action="store_true", help="and those that the tests make")
    parser.add_argument("--no-validator", action="store_true")
    parser.add_argument("--problems", type=int, default=5, help="shown of each file")
    options = parser.parse_args()
    bad = False
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        files = [*options.files, *(synthetic(folder) if options.synthetic else ())]
        print(HEAD)
        for number, file in enumerate(files):
            own = folder / str(number)
            own.mkdir()
            verdict = judged(file, own, options)
            print(row(verdict), flush=True)
            for problem in verdict.problems[: options.problems]:
                print(f"    {problem}")
            bad |= bool(verdict.problems)
    return int(bad)


def judged(file: Path, folder: Path, options: argparse.Namespace) -> Verdict:
    """What is found of a file; that it cannot be bent is a finding too."""
    try:
        validator = not options.no_validator
        return judge(file, folder, validator=validator)
    except Exception as problem:
        return Verdict(file, [f"{type(problem).__name__}: {problem}"])


def row(own: Verdict) -> str:
    """A verdict as a row of the table."""
    before, after = own.bytes
    return (
        f"{own.source.name[:32]:32} {own.targets[0]:4} {own.targets[1]:4} {own.bent:4} "
        f"{before:12,} {after:10,} {after / max(before, 1):5.2f} {own.seconds:5.1f} "
        f"{own.ends:7.0e} {own.between:7.0e} {own.straight:8.0e} {own.clips:7.0e}  "
        f"{len(own.problems) or 'none'}{f' ({own.unsteady} unsteady)' if own.unsteady else ''}"
    )


def synthetic(folder: Path) -> list[Path]:
    """The characters that the tests make."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "characters"))
    from character_makers import RECIPES, make

    return [make(name, folder) for name in RECIPES]


if __name__ == "__main__":
    sys.exit(main())
