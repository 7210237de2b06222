"""Every example in README and docs runs as it stands, and every link leads somewhere.

A page is run from top to bottom, as a reader would type it, in a folder with the files that
examples speak of. What a line of the program is shown to print is compared with what it prints;
``…`` stands for lines left out. A comment before a block says what is special about it:
``needs the real rig``, ``runs in Blender``, or ``file: NAME`` for a file to save.
"""

from __future__ import annotations

import contextlib
import importlib
import inspect
import io
import itertools
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.spatial import cKDTree
from small_scans import in_single_steps

import elastomorph as em
from elastomorph import errors
from elastomorph.cli import main
from elastomorph.doctor import KINDS
from elastomorph.io.sample_files import write_samples
from elastomorph.model.mesh import FaceLabels
from needs import MODULES, extra, node

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
BLOCK = re.compile(r"^(?:<!-- ([^\n]*) -->\n)?```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
REAL, BLENDER, FILE = "needs the real rig", "runs in Blender", "file: "


class Block(NamedTuple):
    """One example of a page."""

    mark: str
    language: str
    text: str


def blocks(page: Path) -> list[Block]:
    return [Block(*found) for found in BLOCK.findall(page.read_text(encoding="utf-8"))]


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def pages_with(*languages: str, mark: str = "") -> list[object]:
    """Parameters: pages with examples of these languages; slow where the program is called."""
    found = []
    for page in PAGES:
        kinds = {each.language for each in blocks(page) if each.mark == mark}
        if kinds & set(languages):
            marks = [pytest.mark.slow] if "console" in kinds else []
            found.append(pytest.param(page, id=name_of(page), marks=marks))
    return found


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files the examples speak of, as 'elastomorph samples' makes them, once."""
    folder = tmp_path_factory.mktemp("samples")
    write_samples(folder)
    return folder


@pytest.fixture
def files(samples: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An own copy of them to work in; nothing waits for a browser, and nothing opens one.

    Pictures that nobody looks at are of one sample a pixel, clips of few frames, and scans are
    registered in few steps.
    """
    folder = tmp_path / "work"
    shutil.copytree(samples, folder)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr("elastomorph.viewer.server.ViewerServer.wait", lambda server: None)
    monkeypatch.setattr("webbrowser.open", lambda address: True)
    monkeypatch.setattr("elastomorph.draw.stage.LARGE", 0)
    monkeypatch.setattr("elastomorph.cli.takes.SWING_FRAMES", 6)
    in_single_steps(monkeypatch)
    return folder


@pytest.mark.documentation
@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("page", pages_with("python", "console"))
@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
def test_examples_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The blocks of a page run one after another, as a reader would type them.

    Pages on data sets need no samples.
    """
    if page.stem.startswith("farm"):
        (tmp_path / "empty").mkdir()
        monkeypatch.chdir(tmp_path / "empty")
    run_page(page, mark="")


@pytest.mark.documentation
@pytest.mark.slow
@pytest.mark.realdata
@pytest.mark.parametrize("page", pages_with("python", "console", mark=REAL))
def test_examples_run_on_the_real_rig(page: Path, files: Path, data_dir: Path) -> None:
    (files / "ict-facekit").symlink_to(data_dir / "ict-facekit")
    run_page(page, mark=REAL)


def run_page(page: Path, mark: str) -> None:
    names: dict[str, object] = {}
    for block in blocks(page):
        if block.mark.startswith(FILE):
            Path(block.mark.removeprefix(FILE)).write_text(block.text, encoding="utf-8")
        if block.mark != mark:
            continue
        if block.language == "python":
            exec(compile(block.text, str(page), "exec"), names)
        elif block.language == "console":
            for line, shown in calls(block.text):
                run_line(line, shown)


def calls(text: str) -> Iterator[tuple[str, list[str]]]:
    """The lines of a block that call the program, each with what it is shown to print."""
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        line, *shown = part.splitlines()
        # A path/to/… is the reader's own.
        if line.startswith("elastomorph ") and "path/to" not in line:
            yield line, shown


def run_line(line: str, shown: list[str]) -> None:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), pytest.raises(SystemExit) as stopped:
        main(shlex.split(line)[1:])
    assert not stopped.value.code, line
    lines = [" ".join(each.split()) for each in printed.getvalue().splitlines()]
    for expected in shown:
        if expected.strip() and expected != "…":
            wanted = " ".join(expected.split())
            place = next((n for n, each in enumerate(lines) if each.startswith(wanted)), None)
            assert place is not None, f"{line}\nprints no (further) line {wanted!r}\n{lines}"
            lines = lines[place + 1 :]


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_pictures_and_anchors_exist(page: Path) -> None:
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"\w+:", target):
            continue
        file, _, anchor = target.partition("#")
        place = page.parent / file if file else page
        assert place.exists(), target
        if anchor:
            assert anchor in anchors(place), target


def anchors(page: Path) -> set[str]:
    """The anchors that a code host, and the site, give to the headings of a page."""
    headings = re.findall(r"^#+ (.+)$", BLOCK.sub("", page.read_text(encoding="utf-8")), re.M)
    return {re.sub(r"[^\w\- ]", "", each.lower()).strip().replace(" ", "-") for each in headings}


def test_every_page_is_in_a_table_of_contents() -> None:
    listed = set(re.findall(r"^([\w/-]+)$", (DOCS / "index.md").read_text(), re.MULTILINE))
    pages = {page.relative_to(DOCS).with_suffix("").as_posix() for page in DOCS.rglob("*.md")}
    assert pages - {"index"} <= listed


def test_the_readme_has_the_commands_of_the_makefile() -> None:
    makefile = (ROOT / "Makefile").read_text()
    for page in PAGES:
        for command in re.findall(r"^\$ make (\w+)", page.read_text(), re.MULTILINE):
            assert f"\n{command}:" in makefile, (page, command)


ROOMS = (
    *("bending", "character", "curves", "doctor", "draw", "evaluation", "physics"),
    *("report", "rivals", "samples", "viewer"),
)


def test_the_quick_start_names_what_is_installed() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    page = (DOCS / "quick-start.md").read_text(encoding="utf-8")
    needed = {re.match(r"[\w-]+", line)[0] for line in project["dependencies"]}  # type: ignore[index]
    paragraph = next(text for text in page.split("\n\n") if "nothing beyond" in text).lower()
    assert not {name for name in needed if name not in paragraph}
    rows = re.findall(r"^\| (`.+?`) \|", page, re.MULTILINE)
    assert set(re.findall(r"`(\w+)`", " ".join(rows))) == {*project["optional-dependencies"]} - {
        "dev"
    }


def test_every_public_name_is_in_the_api_reference_once() -> None:
    text = "\n".join(page.read_text() for page in (DOCS / "api").glob("*.md"))
    shown = re.findall(r"^\.\. auto(?!module)\w+:: elastomorph\.([\w.]+)$", text, re.MULTILINE)
    rooms = {room: importlib.import_module(f"elastomorph.{room}").__all__ for room in ROOMS}
    # Constants are listed where they are explained.
    named = [(room, name) for room, names in rooms.items() for name in names if not name.isupper()]
    deeper = {f"{room}.{name}" for room, name in named}
    same = {name for name in deeper if name.partition(".")[2] in em.__all__}
    assert set(em.__all__) | deeper - same <= set(shown)
    assert len(shown) == len(set(shown))


def test_every_error_is_in_the_index() -> None:
    assert set(errors.__all__) <= set(headings_of(DOCS / "errors.md"))


def test_every_finding_is_explained() -> None:
    assert set(KINDS) <= anchors(DOCS / "findings.md")


def headings_of(page: Path) -> list[str]:
    return [each.strip("`") for each in re.findall(r"^#+ (.+)$", page.read_text(), re.MULTILINE)]


def test_messages_in_the_index_are_those_of_the_program() -> None:
    """Each message of the index, in its pieces between ``…``, is somewhere in the source."""
    source = " ".join(
        re.sub(r'"\s*\n\s*f?"', "", file.read_text(encoding="utf-8"))
        for file in sorted((ROOT / "src").rglob("*.py"))
    )
    messages = re.findall(r"^\| `([^`]+)`", (DOCS / "errors.md").read_text(), re.MULTILINE)
    assert len(messages) > 30
    for message in messages:
        for piece in filter(None, (piece.strip() for piece in message.split("…"))):
            assert piece in source, f"no such message: {piece!r} of {message!r}"


def test_each_benchmark_is_on_its_page() -> None:
    text = (DOCS / "benchmarks.md").read_text()
    for script in sorted((ROOT / "benchmarks").glob("*.py")):
        if "__main__" in script.read_text():
            assert f"python benchmarks/{script.name}" in text, script.name


def test_every_verb_shows_an_example() -> None:
    """Help reads like a manual page: what it does, examples on lines of their own, options."""
    from typer.core import TyperGroup
    from typer.main import get_command
    from typer.testing import CliRunner

    from elastomorph.cli import app

    def verbs(group: TyperGroup, before: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
        for name, command in group.commands.items():
            if isinstance(command, TyperGroup):
                yield from verbs(command, (*before, name))
            else:
                yield (*before, name)

    program = get_command(app)
    assert isinstance(program, TyperGroup)
    for words in verbs(program):
        text = CliRunner().invoke(app, [*words, "--help"], env={"COLUMNS": "80"}).output
        assert re.search(rf"^ *elastomorph {' '.join(words)} ", text, re.MULTILINE), words


class TestTutorialFour:
    """What the tutorial on performances gives to other programs does what it says."""

    PAGE = DOCS / "tutorials" / "performance.md"

    def code(self, mark: str) -> str:
        return next(each.text for each in blocks(self.PAGE) if each.mark == mark)

    @pytest.mark.documentation
    @pytest.mark.slow
    def test_three_js_draws_the_pose(self, files: Path) -> None:
        """Every vertex of every mesh, one for each material, is where `rig.pose` puts it."""
        program = node("three")
        (files / "node_modules").symlink_to(MODULES)
        (files / "elastomorph.mjs").write_text(self.code(FILE + "elastomorph.js"))
        (files / "check.mjs").write_text(CHECK)
        done = subprocess.run(
            [program, "check.mjs"], capture_output=True, text=True, timeout=60, check=False
        )
        assert done.returncode == 0, done.stderr
        rig = em.read_rig("head.glb")
        posed = rig.pose({"jawOpen": 0.6, "mouthSmileLeft": 1.2})
        # Seams repeat vertices, so they are told by where they are at rest and in the pose.
        expected = np.hstack([rig.neutral.vertices, posed])
        drawn = np.fromfile("drawn.f32", dtype="<f4").reshape(-1, 6)
        for some, others in ((drawn, expected), (expected, drawn)):
            apart, _ = cKDTree(others).query(some)
            assert apart.max() < 1e-5 * rig.neutral.diameter

    def test_the_page_imports_what_npm_installs(self) -> None:
        page = self.code(FILE + "index.html")
        node("three")
        for place in re.findall(r'"\./node_modules/([^"]+)"', page):
            assert (MODULES / place).exists(), place
        assert not re.search(r"https?:", page)

    def test_bezier_keys_are_the_bend_curves(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """The handles of the script for Blender: exact for cubics, close for anything steeper."""
        monkeypatch.setitem(sys.modules, "bpy", types.ModuleType("bpy"))
        names: dict[str, object] = {}
        exec(compile(self.code(BLENDER), "script", "exec"), names)
        bezier = names["bezier"]
        assert inspect.isfunction(bezier)
        for curve, within in (
            (em.BendCurve.power(2), 1e-12),
            (em.BendCurve.power(3), 1e-12),
            (em.BendCurve.power(7), 2e-3),
        ):
            keys = bezier(curve.breaks.tolist(), curve.coefficients.tolist())
            for (a, _, out), (b, back, _) in itertools.pairwise(keys):
                for u in np.linspace(0, 1, 7):
                    mix = np.array([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u * u * (1 - u), u**3])
                    t, value = mix @ np.array([a, out, back, b])
                    assert t == pytest.approx((1 - u) * a[0] + u * b[0])
                    assert value == pytest.approx(float(curve(t)), abs=within)

    def test_the_script_for_blender_drives_what_each_mesh_has(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """A file has a mesh for each material: here one stands still, one has a part of targets."""
        ladder = np.array([[x, y, 0.0] for y in range(4) for x in range(2)])
        rungs = [[2 * n, 2 * n + 1, 2 * n + 3, 2 * n + 2] for n in range(3)]
        labels = FaceLabels(("still", "chin", "lid"), np.array([1, 0, 2], dtype=np.int32))
        neutral = em.Mesh(ladder, rungs, materials=labels)
        moved = {"jaw": [0, 6], "blink": [6]}
        paths = {}
        for name, rows in moved.items():
            half, whole = (
                neutral.with_vertices(ladder + np.isin(range(8), rows)[:, None] * np.array(way))
                for way in ([0.2, 0, 0.5], [0, 0, 1])
            )
            paths[name] = em.through(neutral, whole, {0.5: half})
        em.write(tmp_path / "head.glb", em.Rig(neutral, paths))
        bends = [{"jaw.bend1"}, {"jaw.bend1", "blink.bend1"}]
        imported = [types.SimpleNamespace(key_blocks=keys) for keys in bends]
        for keys in imported:
            keys.animation_data_clear = lambda: None
        meshes = [types.SimpleNamespace(data=types.SimpleNamespace(shape_keys=k)) for k in imported]
        bpy: Any = types.ModuleType("bpy")
        bpy.ops = types.SimpleNamespace(
            import_scene=types.SimpleNamespace(gltf=lambda filepath: None)
        )
        bpy.context = types.SimpleNamespace(
            selected_objects=[types.SimpleNamespace(data=object()), *meshes]
        )
        monkeypatch.setitem(sys.modules, "bpy", bpy)
        names: dict[str, Any] = {}
        exec(compile(self.code(BLENDER), "script", "exec"), names)
        driven: list[tuple[int, str, str]] = []
        names["drive"] = lambda keys, slider, target, curve: driven.append(
            (imported.index(keys), slider, target)
        )
        names["import_paths"](str(tmp_path / "head.glb"))
        assert set(driven) == {
            (0, "jaw", "jaw.bend1"),
            (1, "jaw", "jaw.bend1"),
            (1, "blink", "blink.bend1"),
        }

    def test_every_script_for_blender_is_python(self) -> None:
        for each in blocks(self.PAGE):
            if each.mark == BLENDER:
                compile(each.text, "script for Blender", "exec")


CHECK = """
import { readFile, writeFile } from 'node:fs/promises';
import { Texture, Vector3 } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { pose } from './elastomorph.mjs';

const bytes = await readFile('head.glb');
const content = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
// Node shows no images.
const loader = new GLTFLoader().register(() => ({
  name: 'blank',
  loadTexture: async () => new Texture(),
}));
const { scene } = await loader.parseAsync(content, '');
pose(scene, { jawOpen: 0.6, mouthSmileLeft: 1.2 });
const found = [];
const vertex = new Vector3();
scene.traverse((mesh) => {
  if (!mesh.isMesh) return;
  const { position } = mesh.geometry.attributes;
  for (let i = 0; i < position.count; i += 1) {
    found.push(...vertex.fromBufferAttribute(position, i));
    found.push(...mesh.getVertexPosition(i, vertex));
  }
});
await writeFile('drawn.f32', new Float32Array(found));
"""


@pytest.mark.documentation
@pytest.mark.slow
def test_the_site_builds_and_asks_nobody_for_anything(tmp_path: Path) -> None:
    """Without a warning; and no page loads anything that is not beside it."""
    extra("furo", "dev")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    done = subprocess.run(
        [*command, str(DOCS), str(tmp_path / "site")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    for page in (tmp_path / "site").rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        loaded = re.findall(r"<(?:script|img|iframe|link)\b[^>]*?(?:src|href)=\"([^\"]+)\"", text)
        assert not [each for each in loaded if re.match(r"(?:https?:)?//", each)], page.name
