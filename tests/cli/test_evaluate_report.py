"""``evaluate --report``: the page, what it names, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import typer
from calls import status_of

import elastomorph as em
from elastomorph.cli.evaluate import evaluate
from elastomorph.cli.output import command_line


@pytest.fixture(autouse=True)
def scans(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Five frames of a sheet that is lifted, in a folder with a telling name."""
    folder = tmp_path / "secret project"
    folder.mkdir()
    y, x = np.mgrid[0.0:5, 0.0:5]
    flat = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    corners = [[i, i + 1, i + 6, i + 5] for r in range(4) for i in range(5 * r, 5 * r + 4)]
    neutral = em.Mesh(flat, corners)
    for number in range(5):
        lifted = flat + [0, 0, (number / 4) ** 2] * (1 + flat[:, :1])
        em.write(folder / f"scan.{number}.obj", neutral.with_vertices(lifted))
    monkeypatch.chdir(tmp_path)
    return folder


def test_the_page_is_written_without_folders(
    scans: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whoever gets the page learns the names of files, not where they lie."""
    scan = scans / "scan.#.obj"
    assert status_of("evaluate", scan, "--report", "r.html", "--no-pictures", "--unit", "mm") == 0
    assert "written to r.html" in capsys.readouterr().out
    text = Path("r.html").read_text(encoding="utf-8")
    assert "<h1>scan.#.obj</h1>" in text
    assert "secret" not in text
    assert (
        "elastomorph evaluate &#39;scan.#.obj&#39; --report r.html --unit mm --no-pictures" in text
    )
    assert re.search(r"D = [\d.]+ mm", text)


def test_every_method_and_its_in_betweens(scans: Path) -> None:
    """Without being asked."""
    assert status_of("evaluate", scans / "scan.#.obj", "--report", "r.html",
                     "--no-pictures", "--mass", "2") == 0  # fmt: skip
    text = Path("r.html").read_text(encoding="utf-8")
    for label in ("linear", "beam R=2", "plate R=2", "arc", "rotation", "auto"):
        assert f'<th scope="row" class="name">{label}' in text
    assert "straight within 0.0500\u00a0% of D" in text
    assert "Given frames of this very recording" in text
    assert "What would help" in text
    assert "m = 2, c = 1, k = 1" in text


def test_a_take_of_markers_and_its_movements(capsys: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng(1)
    points = rng.normal(size=(6, 3))
    level = np.concatenate([np.zeros(60), np.linspace(0, 1, 50), np.linspace(1, 0, 50),
                            np.zeros(60)])  # fmt: skip
    moved = points + 0.2 * level[:, None, None] * rng.normal(size=(6, 3))
    np.savez("take.npz", positions=moved, names=np.array(list("abcdef")))
    Path("curves.json").write_text('[["a", "b", "c"], ["d", "e", "f"]]')
    common = ("evaluate", "take.npz", "--curves", "curves.json", "--no-pictures", "--report")
    assert status_of(*common, "whole.html") == 0
    whole = Path("whole.html").read_text(encoding="utf-8")
    assert "6 markers, without polygons" in whole
    assert "--movements judges each onset" in whole
    assert "plate and rotation follow a surface, and markers have no polygons" in whole
    assert status_of(*common, "parts.html", "--movements") == 0
    parts = Path("parts.html").read_text(encoding="utf-8")
    assert "1 onset and 1 offset" in parts
    assert "curves of curves.json" in parts
    said = capsys.readouterr().out
    assert said.count("written to") == 2
    assert " ".join(said.split()).count("Left out: plate and rotation") == 2


@pytest.mark.parametrize(
    ("page", "message"), [("r.pdf", "suffix .html"), ("no/where.html", "does not exist")]
)
def test_a_page_that_cannot_be_written_is_refused_at_once(
    scans: Path, page: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before the frames are read, which may take minutes."""
    assert status_of("evaluate", "missing.#.obj", "--report", page) == 1
    assert message in capsys.readouterr().err


def test_a_call_is_told_as_it_was_given() -> None:
    said: list[str] = []
    app = typer.Typer()

    @app.command("verb")
    def verb(
        context: typer.Context,
        file: str,
        number: int = 3,
        method: list[str] | None = None,
        loud: bool = False,
        pictures: bool = True,
    ) -> None:
        said.append(command_line(context))

    for words, told in (
        (["a/b/c d.obj"], "'c d.obj'"),
        (["x.obj", "--number", "3"], "x.obj --number 3"),
        (["--method", "beam:2", "x", "--method", "linear"], "x --method beam:2 --method linear"),
        (["x", "--no-pictures", "--loud"], "x --loud --no-pictures"),
        (["C:\\work\\x.obj"], "x.obj"),
    ):
        app(words, standalone_mode=False)
        assert said[-1].split(" ", 2)[0] == "elastomorph"
        assert said[-1].endswith(f" {told}")
    assert evaluate.__doc__ is not None
    assert "--report" in evaluate.__doc__
