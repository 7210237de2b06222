"""The figures of the house: how large, how knotted and how slow to open the package is.

    python tools/house.py               figures of this checkout
    python tools/house.py --at v0.2.0   beside those of another revision
    python tools/house.py --list        with the name of everything that breaks a rule
    python tools/house.py --check       nothing but what breaks a rule; fails where there is any

Rooms, the order they stand in and the methods that may hand upward are those of the contracts in
`pyproject.toml`. A module that has moved counts where it stands today.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tarfile
import tempfile
import time
import tokenize
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path

import grimp
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from duplicates import duplicates

ROOT = Path(__file__).parents[1]
PACKAGE = "elastomorph"

COMPLEXITY = 15
RUNS = 7


@dataclass
class Figures:
    """What was counted in one checkout, and the names of what breaks a rule."""

    rooms: dict[str, tuple[int, int]] = field(default_factory=dict)
    comments: int = 0
    complex: list[str] = field(default_factory=list)
    upward: list[str] = field(default_factory=list)
    circles: list[str] = field(default_factory=list)
    duplicates: list[str] = field(default_factory=list)
    python_seconds: tuple[float, float] = (0.0, 0.0)
    import_seconds: tuple[float, float] = (0.0, 0.0)
    help_seconds: tuple[float, float] = (0.0, 0.0)
    route: list[str] = field(default_factory=list)
    named_imports: int = 0

    @property
    def broken(self) -> dict[str, list[str]]:
        """Everything that breaks a rule, by the words for the rule."""
        return {
            f"functions more complex than {COMPLEXITY}": self.complex,
            "imports upward": self.upward,
            "circles of imports": self.circles,
            "duplicates over ten lines": self.duplicates,
        }


def counted(root: Path, *, timed: bool = True) -> Figures:
    """The figures of a checkout; without those that need the package to run, if not timed."""
    found = Figures()
    package = root / "src" / PACKAGE
    sources = sorted(package.rglob("*.py"))
    for file in sources:
        text = file.read_text()
        lines, comments = lines_of_code(text)
        room = room_of(_module_of(file, package))
        files, before = found.rooms.get(room, (0, 0))
        found.rooms[room] = (files + 1, before + lines)
        found.comments += comments
    found.complex = _complex(package)
    found.upward, found.circles = _arrows(root)
    found.duplicates = [str(each).replace(f"{package}/", "") for each in duplicates(sources)]
    if timed:
        found.python_seconds = _least_seconds(root, "pass")
        found.import_seconds = _least_seconds(root, f"import {PACKAGE}")
        found.help_seconds = _least_seconds(
            root, f"import sys; from {PACKAGE}.cli import main; sys.argv[1:] = ['--help']; main()"
        )
        found.route, found.named_imports = _route(root)
    return found


def _module_of(file: Path, package: Path) -> str:
    parts = file.relative_to(package.parent).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def lines_of_code(text: str) -> tuple[int, int]:
    """The lines with code, docstrings and blank ones left out, and the comments of a source."""
    lines: set[int] = set()
    comments = 0
    start = True  # of a statement: a string that is all of one is a docstring
    for token in tokenize.generate_tokens(iter(text.splitlines(keepends=True)).__next__):
        if token.type == tokenize.COMMENT:
            comments += 1
        elif token.type in (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT):
            start = True
        elif token.type not in (tokenize.NL, tokenize.ENDMARKER):
            if not (start and token.type == tokenize.STRING):
                lines.update(range(token.start[0], token.end[0] + 1))
            start = False
    return len(lines), comments


def _complex(package: Path) -> list[str]:
    rule = f"lint.mccabe.max-complexity={COMPLEXITY}"
    words = (
        sys.executable,
        "-m",
        "ruff",
        "check",
        "--isolated",
        "--select",
        "C901",
        "--output-format",
        "concise",
    )
    done = subprocess.run(
        [*words, "--no-cache", "--config", rule, str(package)], capture_output=True, text=True
    )
    lines = [line for line in done.stdout.splitlines() if " C901 " in line]
    return [line.replace(f"{package}/", "").replace(" C901", "") for line in lines]


# ---- imports -----------------------------------------------------------------------------------


def _contract() -> tuple[dict[str, int], set[tuple[str, ...]]]:
    """The height of each room, and the imports that may lead upward."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    layers = next(each for each in settings["contracts"] if each["type"] == "layers")
    height = {
        room.strip(): -row
        for row, rooms in enumerate(layers["layers"])
        for room in rooms.split("|")
    }
    allowed = {tuple(each.split(" -> ")) for each in layers["ignore_imports"]}
    return height, allowed


HEIGHT, FORWARDS = _contract()
# Where the modules of the first layout stand today, and which of them left `report` for `draw`.
STOOD = {
    "character": "settings",
    "model": "bend_curve components extent inspection mesh morph polygon_normals polygons rigid "
    "sequence surface",
    "paths": "baking rotations",
    "rig": "performance timing",
    "samples": "paper_expressions",
}
MOVED = {module: room for room, modules in STOOD.items() for module in modules.split()}
DRAWN = """
    actors camera clips closures contact_sheet curves_picture extras eyes face_strip figure framing
    gif graphs grid heat inbetween_graph materials method_style method_words movement_graph movie
    normals pictures portrait pose_pictures posed render stage strips take_strip time_laws turntable
    vtk_arrays window
"""


def room_of(module: str) -> str:
    """The room that a module stands in, or would stand in today."""
    _, room, part, *_ = [*module.split("."), "", ""]
    if room == "report" and part in DRAWN.split():
        return "draw"
    return MOVED.get(room, room if room in HEIGHT else "top")


def _arrows(root: Path) -> tuple[list[str], list[str]]:
    """Imports that lead upward or aside, and circles, imports within functions among them."""
    sys.path.insert(0, str(root / "src"))
    try:
        graph = grimp.build_graph(PACKAGE, exclude_type_checking_imports=True, cache_dir=None)
    finally:
        sys.path.remove(str(root / "src"))
    upward = []
    for importer in sorted(graph.modules):
        for imported in sorted(graph.find_modules_directly_imported_by(importer)):
            if (importer, imported) in FORWARDS:
                graph.remove_import(importer=importer, imported=imported)
            elif not _allowed(room_of(importer), room_of(imported)):
                upward.append(f"{importer} -> {imported}")
    found = circles({m: graph.find_modules_directly_imported_by(m) for m in graph.modules})
    return upward, [" ".join(each) for each in found]


def _allowed(importer: str, imported: str) -> bool:
    if importer == imported or importer not in HEIGHT or imported not in HEIGHT:
        return importer == imported or importer == "top"
    return HEIGHT[imported] < HEIGHT[importer]


def circles(imports: dict[str, set[str]]) -> list[list[str]]:
    """The sets of modules that reach each other, each in the order of names."""
    names = sorted(imports)
    edges = [(names.index(a), names.index(b)) for a in names for b in imports[a]]
    ones = np.ones(len(edges))
    graph = csr_array((ones, tuple(np.reshape(edges, (-1, 2)).T)), shape=(len(names),) * 2)
    count, own = connected_components(graph, connection="strong")
    sets = [
        [name for name, set_ in zip(names, own, strict=True) if set_ == i] for i in range(count)
    ]
    return sorted(each for each in sets if len(each) > 1)


# ---- what needs the package to run ---------------------------------------------------------------


def _least_seconds(root: Path, code: str) -> tuple[float, float]:
    """The least time of a process of its own, its start included, and of a processor for it."""
    elapsed, used = [], []
    for _ in range(RUNS):
        before, start = os.times(), time.perf_counter()
        _run(root, "-c", code)
        elapsed.append(time.perf_counter() - start)
        after = os.times()
        used.append(sum(after[2:4]) - sum(before[2:4]))  # of children, in user and in system
    return min(elapsed), min(used)


def _route(root: Path) -> tuple[list[str], int]:
    """Files whose functions run on the way of a vertex, and imports on it by name."""
    files, named = json.loads(_run(root, str(ROOT / "tools" / "route.py")))
    package = f"{root / 'src' / PACKAGE}/"
    return [str(file).replace(package, "") for file in files], len(named)


def _run(root: Path, *words: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "ignore", *words],
        env=os.environ | {"PYTHONPATH": str(root / "src")},
        capture_output=True,
        check=True,
        text=True,
    )
    return done.stdout


# ---- printing ------------------------------------------------------------------------------------


@contextmanager
def checkout(revision: str) -> Iterator[Path]:
    """A folder with the files of a revision."""
    packed = subprocess.run(
        ["git", "-C", str(ROOT), "archive", revision, "src"], capture_output=True, check=True
    ).stdout
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(fileobj=BytesIO(packed)) as archive:
            archive.extractall(folder, filter="data")
        yield Path(folder)


def _seconds(least: tuple[float, float]) -> str:
    return "{:.2f} s (cpu {:.2f})".format(*least)


ROWS: dict[str, Callable[[Figures], object]] = {
    "files": lambda f: sum(files for files, _ in f.rooms.values()),
    "lines of code": lambda f: f"{sum(lines for _, lines in f.rooms.values()):,}",
    "comments": lambda f: f"{f.comments:,}",
    "python alone": lambda f: _seconds(f.python_seconds),
    f"import {PACKAGE}": lambda f: _seconds(f.import_seconds),
    f"{PACKAGE} --help": lambda f: _seconds(f.help_seconds),
    "files a vertex passes": lambda f: len(f.route),
    "imports by name on its way": lambda f: f.named_imports,
}


def _print(columns: dict[str, Figures]) -> None:
    def row(name: str, values: list[object]) -> None:
        print(f"{name:36}" + "".join(f"{value!s:>20}" for value in values))

    row("", list(columns))
    rooms = Counter({room: 1 for own in columns.values() for room in own.rooms})
    for room in sorted(rooms, key=lambda each: -HEIGHT.get(each, 9)):
        counts = [own.rooms.get(room, (0, 0)) for own in columns.values()]
        row(f"  {room}", [f"{files} files {lines:6,}" for files, lines in counts])
    for name, value in ROWS.items():
        row(name, [value(own) for own in columns.values()])
    for name in Figures().broken:
        row(name, [len(own.broken[name]) for own in columns.values()])


def main() -> None:
    """Print the figures, or check them."""
    parser = argparse.ArgumentParser(description=__doc__, add_help=True)
    parser.add_argument("--at", metavar="REVISION", help="print another revision's beside them")
    parser.add_argument("--list", action="store_true", help="name everything that breaks a rule")
    parser.add_argument("--check", action="store_true", help="fail where a rule is broken")
    chosen = parser.parse_args()
    here = counted(ROOT, timed=not chosen.check)
    if chosen.check:
        broken = {what: names for what, names in here.broken.items() if names}
        _name(broken)
        sys.exit(bool(broken))
    columns = {"now": here}
    if chosen.at:
        with checkout(chosen.at) as other:
            columns = {chosen.at: counted(other), "now": here}
    _print(columns)
    if chosen.list:
        _name(here.broken)
        print("\nfiles a vertex passes\n  " + "\n  ".join(here.route))


def _name(broken: dict[str, list[str]]) -> None:
    for what, things in broken.items():
        print(f"\n{what}: {len(things)}")
        print("".join(f"  {thing}\n" for thing in things), end="")


if __name__ == "__main__":
    main()
