"""How large the house is: files, lines of code, comments, tests, pages and the page's own code.

    python tools/count.py [FOLDER]

FOLDER is another checkout, to compare with. A line of code has something on it that is no comment
and no docstring. Comments are told without those that speak to a tool. What the last row counts is
listed by ``tools/route.py``.
"""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
import tokenize
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parents[1]
PRAGMA = re.compile(r"#\s*(noqa|type:|fmt:|pragma|ruff:|mypy:|!)")
IGNORED = {"node_modules", "out", "_build", ".venv"}


def lines_of_code(text: str) -> tuple[int, int]:
    """Lines with code in a source, and comments that say something."""
    lines: set[int] = set()
    comments = 0
    start = True  # of a statement: a string that is all of one is a docstring
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            comments += not PRAGMA.match(token.string)
        elif token.type in (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT):
            start = True
        elif token.type not in (tokenize.NL, tokenize.ENDMARKER):
            if not (start and token.type == tokenize.STRING):
                lines.update(range(token.start[0], token.end[0] + 1))
            start = False
    return len(lines), comments


def files(root: Path, *folders: str, suffixes: Iterable[str]) -> list[Path]:
    """The files in some folders of a checkout, what is built and installed left out."""
    ends = tuple(suffixes)
    every = (file for folder in folders for file in (root / folder).rglob("*"))
    return [f for f in every if f.suffix in ends and not IGNORED & {*f.relative_to(root).parts}]


def counted(root: Path, *folders: str) -> str:
    """Files, lines of code and comments of folders with Python."""
    sources = files(root, *folders, suffixes=[".py"])
    code, comments = map(sum, zip(*(lines_of_code(f.read_text()) for f in sources), strict=True))
    return f"{len(sources):5} files {code:8,} lines of code {100 * comments / code:5.1f} % comments"


def on_the_way(root: Path) -> int:
    """Files of the package in which something runs from an OBJ to a GLB."""
    words = [sys.executable, "-W", "ignore", str(ROOT / "tools" / "route.py")]
    path = {"PYTHONPATH": str(root / "src")}
    done = subprocess.run(words, env=os.environ | path, capture_output=True, check=True, text=True)
    return len(json.loads(done.stdout)[0])


def main() -> None:
    """Print the table."""
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT
    moved = [name for name in ("research", "benchmarks", "tools") if (root / name).is_dir()]
    for folder in sorted({f.parent for f in files(root, "src", suffixes=[".py"])}):
        if folder.parent == root / "src" / "elastomorph":
            print(f"  {folder.name:34}{counted(root, str(folder.relative_to(root)))}")
    print(f"{'src':36}{counted(root, 'src')}")
    print(f"{'src, ' + ', '.join(moved):36}{counted(root, 'src', *moved)}")
    tests = files(root, "tests", suffixes=[".py"])
    print(f"{'tests':36}{sum(f.read_text().count(chr(10)) for f in tests):17,} lines")
    pages = files(root, "web", "runtimes", "integrations", suffixes=[".ts", ".tsx"])
    print(f"{'TypeScript':36}{sum(f.read_text().count(chr(10)) for f in pages):17,} lines")
    words = files(root, "docs", suffixes=[".md"])
    print(f"{'documentation':36}{sum(len(f.read_text().split()) for f in words):17,} words")
    print(f"{'files from an OBJ to a GLB':36}{on_the_way(root):17,}")


if __name__ == "__main__":
    main()
