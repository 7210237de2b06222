"""What every reader makes of hostile files: cut off, damaged, contradictory, made to harm.

Run:  python benchmarks/hostile_files.py [--seconds N] [--seed N] [--formats OBJ GLB ...]

Each input must load and be sound, or be refused by one ElastomorphError that names the file. Below
a megabyte it may take at most 2 seconds of processor time and 256 MB of memory above the start, in
this process and in one that the reader starts. Prints a row a format, and exits with 1 if anything
else happened; such inputs are kept in --keep and tried again with
--formats NAME --seed N --case NUMBER.

N seconds are shared by the formats (default 120); inputs made by hand are all tried, however long
that takes, cuts and random damage as far as the time goes.

With --atheris NAME  inputs are instead chosen by the code they reach, by the package atheris, which
is not among the requirements: pip install atheris (it has wheels for Python 3.11 on Linux).
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from hostile.formats import FORMATS, Format
from hostile.table import Row, run
from hostile.trial import MOST_MEMORY, MOST_SECONDS, cases, find_format, tried


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = [known.name for known in FORMATS]
    parser.add_argument("--seconds", type=float, default=120.0, help="for all formats together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--formats", nargs="+", choices=names, default=names, metavar="NAME")
    parser.add_argument("--case", type=int, help="try one input only and show what comes of it")
    parser.add_argument("--keep", type=Path, default=Path("out/hostile"), help="for failures")
    parser.add_argument("--list", action="store_true", help="list the formats")
    parser.add_argument("--messages", action="store_true", help="show all messages, shortest first")
    parser.add_argument("--atheris", choices=names, metavar="NAME")
    options = parser.parse_args()
    if options.list:
        print("\n".join(names))
        return 0
    if options.atheris:
        return fuzz(options.atheris, options.seconds)
    with tempfile.TemporaryDirectory(prefix="hostile-") as place:
        if options.case is not None:
            return show(find_format(options.formats[0]), options.seed, options.case, Path(place))
        return table(options, Path(place))


def table(options: argparse.Namespace, place: Path) -> int:
    """Try all formats; prints the table."""
    print(f"seed {options.seed}; limits {MOST_SECONDS:g} s and {MOST_MEMORY >> 20} MB below 1 MB")
    print(f"{'format':<16} {'tried':>7} {'loaded':>7} {'refused':>7} {'other':>6}", end="")
    print(f" {'worst s':>8} {'worst MB':>9}")
    rows: list[Row] = []
    for name in options.formats:
        known = find_format(name)
        share = options.seconds / len(options.formats)
        row = run(name, options.seed, share, place / "trial")
        rows.append(row)
        print(
            f"{name:<16} {row.tried:>7,} {row.loaded:>7,} {row.refused:>7,} "
            f"{len(row.failures):>6,} {row.seconds:>8.2f} {row.memory / 2**20:>9.0f}",
            flush=True,
        )
        report(known, options, row)
    failures = sum(len(row.failures) for row in rows)
    tried_in_all = sum(row.tried for row in rows)
    print(
        f"{tried_in_all:,} inputs, {failures:,} that neither loaded nor were refused as they must"
    )
    return 1 if failures else 0


def report(known: Format, options: argparse.Namespace, row: Row) -> None:
    """Print the failures of a format and keep their inputs."""
    if options.messages:
        for message, number in sorted(row.messages.items(), key=lambda item: len(item[0])):
            print(f"    {number}: {message!a}")
        print(f"    slowest {row.slowest}\n    largest {row.largest}")
    for number, label, problem in row.failures[:12]:
        folder = options.keep / known.name / str(number)
        case, _ = next(cases(known, options.seed, number))
        try:
            case.write(folder)
        except (OSError, ValueError):
            shutil.rmtree(folder, ignore_errors=True)
        last = problem.strip().splitlines()[-1]
        print(f"  FAILED --formats '{known.name}' --seed {options.seed} --case {number}: {label}")
        print(f"         {last[:300]}")
    if len(row.failures) > 12:
        print(f"  … and {len(row.failures) - 12} more")


def show(known: Format, seed: int, number: int, place: Path) -> int:
    """Try one input again."""
    case, _ = next(cases(known, seed, number))
    told = tried(known, case, number, place)
    for key in ("label", "outcome", "message", "problem"):
        print(f"{key}: {told[key]}")
    print(f"{told['seconds']:.2f} s, {told['memory'] / 2**20:.0f} MB above the start")
    return 1 if told["outcome"] == "failed" else 0


def fuzz(name: str, seconds: float) -> int:
    """Let atheris choose inputs; ends at the first failure."""
    if find_spec("atheris") is None:
        print("this needs the package atheris: pip install atheris", file=sys.stderr)
        return 1
    command = [sys.executable, "-m", "hostile.fuzz", name, str(int(seconds))]
    paths = [str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])]
    env = os.environ | {"PYTHONPATH": os.pathsep.join(paths)}
    return subprocess.run(command, env=env, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
