"""Every example in README and docs runs as it stands."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.cli import main
from elastomorph.io.performance_csv import write_performance_csv
from elastomorph.performance import Performance
from elastomorph.samples import expressions, head, recorded_motion, shapes

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
FENCE = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def blocks(page: Path, language: str) -> list[str]:
    return [text for kind, text in FENCE.findall(page.read_text()) if kind == language]


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The files the examples speak of, made from the built-in head."""
    monkeypatch.chdir(tmp_path)
    motion = recorded_motion()
    em.write("neutral.obj", motion.neutral)
    em.write("jawOpen.obj", shapes()["jawOpen"])
    em.write("smile.obj", expressions()["grinning"])
    Path("mouth.json").write_text(str(np.arange(100, 400).tolist()))
    em.write_sequence("scan.####.obj", motion)
    to = em.prepare(head(), "beam:2")
    names = ("jawOpen", "eyeBlink_L", "mouthSmile_L")
    em.write("head.glb", em.Rig(head(), {name: to(shapes()[name]) for name in names}))
    take = Performance(("jawOpen", "eyeBlinkLeft"), np.arange(4) / 30, np.eye(4)[:, :2], 30.0)
    write_performance_csv("take.csv", take)
    return tmp_path


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
def test_python_examples_run(page: Path) -> None:
    """The blocks of a page run one after another, as a reader would type them."""
    names: dict[str, object] = {}
    for text in blocks(page, "python"):
        exec(compile(text, str(page), "exec"), names)


@pytest.mark.slow
@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_command_lines_run(page: Path) -> None:
    """Each line that calls the program ends well."""
    for text in blocks(page, "console"):
        for line in text.splitlines():
            words = shlex.split(line.removeprefix("$ "))
            if line.startswith("$ elastomorph") and "path/to" not in line:
                with pytest.raises(SystemExit) as stopped:
                    main(words[1:])
                assert not stopped.value.code, line


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_pictures_exist(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text()):
        if not target.startswith("http"):
            assert (page.parent / target).exists(), target


def test_the_readme_has_the_commands_of_the_makefile() -> None:
    makefile = (ROOT / "Makefile").read_text()
    for command in re.findall(r"make (\w+)", (ROOT / "README.md").read_text()):
        assert f"\n{command}:" in makefile
