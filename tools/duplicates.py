"""Finds code that stands in two places: the same steps, whatever its variables are called.

    python tools/duplicates.py [FOLDER] [LINES]

Lines of code are compared; comments, documentation, imports, the heads of functions, lists of
exported names and empty lines are left out. Names of variables may differ, as long as they differ
in the same way throughout; names of what is called, of attributes and of arguments count.
"""

from __future__ import annotations

import ast
import io
import keyword
import sys
import tokenize
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

LINES = 11
"""So many lines in a row are a duplicate; ten are not."""

_LAYOUT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}


@dataclass(frozen=True)
class Line:
    """A line of code as words: ``(word, whether it is the name of a variable)``."""

    file: Path
    number: int
    words: tuple[tuple[str, bool], ...]


@dataclass(frozen=True)
class Duplicate:
    """The same lines of code in two places, each from its first line of a file to its last."""

    lines: int
    first: tuple[Path, int, int]
    second: tuple[Path, int, int]

    def __str__(self) -> str:
        places = (f"{file}:{start}-{end}" for file, start, end in (self.first, self.second))
        return f"{self.lines} lines  {'  '.join(places)}"


def duplicates(files: Sequence[Path], lines: int = LINES) -> list[Duplicate]:
    """The longest runs of lines that two places share, longest first."""
    code = {file: list(_code_lines(file)) for file in files}
    places: dict[tuple[object, ...], list[tuple[Path, int]]] = defaultdict(list)
    for file, own in code.items():
        for start in range(len(own) - lines + 1):
            places[_shape(own[start : start + lines])].append((file, start))
    pairs: set[tuple[tuple[Path, int], tuple[Path, int]]] = set()
    for same in places.values():
        pairs.update((a, b) for a, b in combinations(same, 2) if _apart(a, b, lines))
    found = []
    for (file, start), (other, there) in pairs:
        if ((file, start - 1), (other, there - 1)) in pairs:
            continue  # a part of a longer run
        length = lines
        while ((file, start + length - lines + 1), (other, there + length - lines + 1)) in pairs:
            length += 1
        a, b = code[file][start : start + length], code[other][there : there + length]
        spans = ((each[0].file, each[0].number, each[-1].number) for each in (a, b))
        found.append(Duplicate(length, *spans))
    return sorted(found, key=lambda each: (-each.lines, each.first, each.second))


def _apart(a: tuple[Path, int], b: tuple[Path, int], lines: int) -> bool:
    return a[0] != b[0] or abs(a[1] - b[1]) >= lines


def _shape(lines: Sequence[Line]) -> tuple[object, ...]:
    """The lines with each variable replaced by a number, in the order of their appearance."""
    numbers: dict[str, int] = {}
    return tuple(
        tuple(numbers.setdefault(word, len(numbers)) if own else word for word, own in line.words)
        for line in lines
    )


def _code_lines(file: Path) -> Iterator[Line]:
    text = file.read_text()
    skipped = _skipped(ast.parse(text))
    rows: dict[int, list[tuple[str, bool]]] = defaultdict(list)
    tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    depth = 0
    for before, token, after in zip([None, *tokens], tokens, [*tokens[1:], None], strict=False):
        depth += token.string in ("(", "[", "{") and token.type == tokenize.OP
        depth -= token.string in (")", "]", "}") and token.type == tokenize.OP
        row = token.start[0]
        if row in skipped or token.type in _LAYOUT:
            continue
        follows, leads = after.string if after else "", before.string if before else ""
        variable = (
            token.type == tokenize.NAME
            and not keyword.iskeyword(token.string)
            and leads != "."
            and follows != "("
            and not (depth and follows == "=")
        )
        rows[row].append((token.string, variable))
    for row in sorted(rows):
        words = tuple(rows[row])
        if any(word not in ")]},:" for word, _ in words):
            yield Line(file, row, words)


def _skipped(tree: ast.Module) -> set[int]:
    """Lines of imports, documentation, heads of functions and lists of exported names."""
    rows: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            rows.update(range(node.lineno, (node.end_lineno or 0) + 1))
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            if isinstance(node.value.value, str):
                rows.update(range(node.lineno, (node.end_lineno or 0) + 1))
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            rows.update(range(node.lineno, node.body[0].lineno))
        elif isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            rows.update(range(node.lineno, (node.end_lineno or 0) + 1))
    return rows


def main() -> None:
    """Print what is found; the exit status is 1 where anything is."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "src")
    lines = int(sys.argv[2]) if len(sys.argv) > 2 else LINES
    found = duplicates(sorted(folder.rglob("*.py")), lines)
    print("\n".join(map(str, found)) or f"no {lines} lines of code stand twice")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
