"""Runs the cells of a notebook and keeps what they show, without Jupyter.

    python examples/make_notebook.py examples/drag_a_face.ipynb

The notebook is its own source: cells are edited in it, by Jupyter or by hand, and this program
replaces their outputs by those of a run from top to bottom in an empty folder.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import copy
import io
import json
import os
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

__all__ = ["executed", "run_cell", "stored"]


def executed(notebook: dict[str, Any]) -> dict[str, Any]:
    """The notebook with the outputs of its cells, run one after another in the current folder.

    Args:
        notebook: A notebook of format 4, as parsed from its file. It stays as it is.
    """
    fresh = copy.deepcopy(notebook)
    names: dict[str, object] = {"__name__": "__main__"}
    code = (cell for cell in fresh["cells"] if cell["cell_type"] == "code")
    for count, cell in enumerate(code, start=1):
        cell["execution_count"] = count
        cell["outputs"] = run_cell("".join(cell["source"]), names, count)
    return fresh


def run_cell(source: str, names: dict[str, object], count: int) -> list[dict[str, Any]]:
    """The outputs of one cell: what it prints, and the value of an expression at its end.

    Args:
        source: The text of the cell.
        names: The names that cells before it have left, and that it adds to.
        count: Its number.
    """
    tree = ast.parse(source, f"cell {count}")
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    value = None
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(tree, f"cell {count}", "exec", dont_inherit=True), names)
        if isinstance(last, ast.Expr):
            value = eval(
                compile(ast.Expression(last.value), f"cell {count}", "eval", dont_inherit=True),
                names,
            )
    outputs: list[dict[str, Any]] = []
    if printed.getvalue():
        text = _lines(printed.getvalue())
        outputs.append({"name": "stdout", "output_type": "stream", "text": text})
    if value is not None:
        # The address of a thing says nothing to a reader, and is another in every run.
        plain = re.sub(" at 0x[0-9A-Fa-f]+", "", repr(value))
        shown: dict[str, str | list[str]] = {"text/plain": _lines(plain)}
        if hasattr(value, "_repr_html_"):
            shown["text/html"] = _lines(value._repr_html_())
        if hasattr(value, "_repr_png_"):
            shown["image/png"] = base64.b64encode(value._repr_png_()).decode()
        outputs.append(
            {
                "data": shown,
                "execution_count": count,
                "metadata": {},
                "output_type": "execute_result",
            }
        )
    return outputs


def stored(notebook: dict[str, Any]) -> str:
    """The text of the file of a notebook, as Jupyter writes it."""
    return json.dumps(notebook, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def _main(path: Path) -> None:
    notebook = json.loads(path.read_text(encoding="utf-8"))
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            fresh = executed(notebook)
        finally:
            os.chdir(before)
    path.write_text(stored(fresh), encoding="utf-8")
    print(f"{path}: {path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    _main(Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent / "first_steps.ipynb"))
