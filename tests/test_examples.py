"""The example notebooks: valid, run as they stand, and show what a run shows."""

from __future__ import annotations

import base64
import importlib.util
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from needs import extra

pytestmark = pytest.mark.documentation

EXAMPLES = Path(__file__).parents[1] / "examples"
NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))


def _program() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_notebook", EXAMPLES / "make_notebook.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def path(request: pytest.FixtureRequest) -> Path:
    found: Path = request.param
    return found


@pytest.fixture
def notebook(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


class Frame(HTMLParser):
    """The page within a frame."""

    page: str | None = None

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "iframe":
            self.page = dict(attrs)["srcdoc"]


def scene_of(html: str) -> dict[str, Any] | None:
    """The scene of the viewer in a frame, without its files; None where there is no frame."""
    frame = Frame()
    frame.feed(html)
    if frame.page is None:
        return None
    text = frame.page.split('id="elastomorph-scene">')[1].split("</script>")[0]
    scene: dict[str, Any] = json.loads(text)
    return scene


def outputs(notebook: dict[str, Any]) -> list[list[dict[str, Any]]]:
    return [cell["outputs"] for cell in notebook["cells"] if cell["cell_type"] == "code"]


def test_there_is_a_notebook() -> None:
    assert {path.stem for path in NOTEBOOKS} >= {"first_steps", "drag_a_face"}


def test_it_is_a_notebook_of_format_4(notebook: dict[str, Any]) -> None:
    """What the format asks for: kinds and names of cells, lists of lines, kinds of outputs."""
    assert set(notebook) == {"cells", "metadata", "nbformat", "nbformat_minor"}
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    assert notebook["metadata"]["kernelspec"]["name"] == "python3"
    names = [cell["id"] for cell in notebook["cells"]]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[a-zA-Z0-9_-]{1,64}", name) for name in names)
    for cell in notebook["cells"]:
        lines = cell["source"]
        assert all(line.endswith("\n") for line in lines[:-1])
        assert "\n" not in "".join(lines[-1:])
        keys = {"cell_type", "id", "metadata", "source"}
        if cell["cell_type"] == "code":
            keys |= {"execution_count", "outputs"}
        else:
            assert cell["cell_type"] == "markdown"
        assert set(cell) == keys
    for number, found in enumerate(outputs(notebook), start=1):
        for output in found:
            if output["output_type"] == "stream":
                assert set(output) == {"output_type", "name", "text"}
            else:
                assert output["output_type"] == "execute_result"
                assert set(output) == {"output_type", "data", "metadata", "execution_count"}
                assert output["execution_count"] == number
                assert "text/plain" in output["data"]


def test_it_is_small(path: Path) -> None:
    assert path.stat().st_size < 3_000_000


def pixels(encoded: str) -> np.ndarray:
    image = extra("PIL.Image", "demo").open(io.BytesIO(base64.b64decode(encoded)))
    return np.asarray(image.convert("RGB"), dtype=float)


def agree(kind: str, old: str, new: str) -> bool:
    """Texts and tables to the letter, pictures as far as renderers agree; of the viewer its scene.

    Returns whether something was seen: a picture or a scene.
    """
    if kind == "image/png":
        assert pixels(old).shape == pixels(new).shape
        assert np.abs(pixels(old) - pixels(new)).mean() < 2
        return True
    scene = scene_of(new)
    if scene is None:
        assert old == new
        return False
    stored = scene_of(old)
    assert stored is not None
    # The last digit of a distance is the machine's.
    assert stored.pop("diameter") == pytest.approx(scene.pop("diameter"))
    assert stored == scene
    return True


def test_it_runs_without_jupyter_and_shows_what_a_run_shows(
    notebook: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its cells executed one after another, as a reader would type them."""
    if "elastomorph.draw" in str(notebook["cells"]):
        extra("vtkmodules", "demo")
    monkeypatch.chdir(tmp_path)
    fresh = outputs(_program().executed(notebook))
    seen = 0
    for before, after in zip(outputs(notebook), fresh, strict=True):
        assert len(before) == len(after)
        for old, new in zip(before, after, strict=True):
            assert old.get("text") == new.get("text")
            assert old.get("data", {}).keys() == new.get("data", {}).keys()
            for kind, text in new.get("data", {}).items():
                seen += agree(kind, "".join(old["data"][kind]), "".join(text))
    assert seen >= 1


def test_its_links_lead_somewhere(path: Path, notebook: dict[str, Any]) -> None:
    text = "".join("".join(cell["source"]) for cell in notebook["cells"])
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", text):
        if not target.startswith("http"):
            assert (path.parent / target).exists(), target


def test_the_program_shows_what_a_notebook_would() -> None:
    """Prints, then the value at the end; nothing for None, statements or an empty cell.

    A picture is kept as it is, and no address of the machine.
    """
    run = _program().run_cell
    names: dict[str, object] = {}
    assert run("x = 2", names, 1) == []
    assert run("", names, 2) == []
    assert run("None", names, 3) == []
    printed, value = run("print(x)\nx + 1", names, 4)
    assert printed == {"name": "stdout", "output_type": "stream", "text": ["2\n"]}
    assert value["data"] == {"text/plain": ["3"]}
    assert value["execution_count"] == 4
    drawn = "class Drawn:\n    def _repr_png_(self): return b'png'\nDrawn()"
    (shown,) = run(drawn, {"__name__": "cell"}, 5)
    assert shown["data"] == {"text/plain": ["<cell.Drawn object>"], "image/png": "cG5n"}
    with pytest.raises(ZeroDivisionError):
        run("1 / 0", names, 6)
