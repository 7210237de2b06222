"""The package as it is installed: a wheel, and nothing but what it must have."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from importlib import metadata
from pathlib import Path

import pytest

from elastomorph.samples.built_in_head import IMAGES

ROOT = Path(__file__).parents[1]
CORE = {"jinja2", "numpy", "scipy", "typer", "rich", "threadpoolctl", "tomlkit"}

pytestmark = pytest.mark.slow


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def needed_by(name: str) -> set[str]:
    """A distribution and all that it needs without extras, as installed here."""
    found: set[str] = set()
    open_names = [normal(name)]
    while open_names:
        name = open_names.pop()
        if name in found:
            continue
        try:
            requires = metadata.requires(name) or []
        except metadata.PackageNotFoundError:  # needed elsewhere only, by its marker
            continue
        found.add(name)
        plain = [text for text in requires if "extra ==" not in text]
        open_names += [normal(re.split(r"[^\w.-]", text)[0]) for text in plain]
    return found


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    done = subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Variables for a Python that sees the wheel, the core dependencies and nothing else."""
    place = tmp_path_factory.mktemp("environment")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(place)
    for name in set().union(*map(needed_by, CORE)):
        for file in metadata.files(name) or []:
            top = file.parts[0]
            if top not in ("..", "__pycache__") and not (place / top).exists():
                (place / top).symlink_to(
                    Path(str(file.locate())).parents[len(file.parts) - 2]
                    if len(file.parts) > 1
                    else Path(str(file.locate()))
                )
    return {**os.environ, "PYTHONPATH": str(place), "XDG_CACHE_HOME": str(place / "cache")}


def run(environment: dict[str, str], folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """A command of the installed package; -S hides the packages of this environment."""
    return subprocess.run(
        [sys.executable, "-S", "-P", "-m", "elastomorph", *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )


def test_a_wheel_holds_the_package_and_its_pages_only(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    info = next(name.split("/")[0] for name in names if name.endswith(".dist-info/METADATA"))
    source = {
        f"elastomorph/{path.relative_to(ROOT / 'src' / 'elastomorph').as_posix()}"
        for path in (ROOT / "src" / "elastomorph").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert {name for name in names if not name.startswith(info)} == source
    pages = {"viewer/landmarks_page/index.html", "viewer/page/index.html"}
    pages |= {"report/templates/page.html", "report/templates/page.css"}
    pages |= {"character/templates/elastomorph.toml"}
    head = {"neutral.npz", "shapes.npz", "paths.npz", "motion.npz", *IMAGES, "ict-facekit/LICENSE"}
    files = {"py.typed", *pages, *(f"samples/{name}" for name in head)}
    assert {f"elastomorph/{name}" for name in files} <= names
    assert f"{info}/licenses/LICENSE" in names
    assert f"{info}/licenses/src/elastomorph/samples/ict-facekit/LICENSE" in names
    assert wheel.stat().st_size <= 6e6


def test_the_core_needs_six_packages(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        name = next(name for name in archive.namelist() if name.endswith("METADATA"))
        text = archive.read(name).decode()
    plain = re.findall(r"^Requires-Dist: ([\w-]+)(?!.*extra ==)", text, re.MULTILINE)
    assert set(plain) == CORE
    extras = set(re.findall(r"^Provides-Extra: (\S+)", text, re.MULTILINE))
    named = {"demo", "gltf", "usd", "fbx", "torch", "notebook", "dev", "capture", "rivals", "farm"}
    assert extras == {*named, "mocap", "live", "s3"}


def test_the_main_path_runs_on_the_core_alone(environment: dict[str, str], tmp_path: Path) -> None:
    def succeed(*words: str) -> str:
        done = run(environment, tmp_path, *words)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert succeed("--version").strip() == metadata.version("elastomorph")
    succeed("export", "built-in", "-o", "head.npz", "--only", "jawOpen")
    succeed("export", "head.npz", "-o", "head.glb")
    succeed("view", "head.glb", "-o", "head.html")
    succeed("blend", "head.npz", "--levels", "2", "-o", "face.####.obj")
    faces = sorted(path.name for path in tmp_path.glob("face.*.obj"))
    assert faces
    assert "vertices" in succeed("inspect", faces[0])
    succeed("interpolate", faces[0], faces[-1], "--frames", "3", "-o", "scan.####.obj")
    assert "LME" in succeed("evaluate", "scan.####.obj", "--method", "linear")


@pytest.mark.parametrize(
    ("words", "extra"),
    [
        (("curves", "head.obj", "-o", "c.json", "--picture", "c.png"), "demo"),
        (("export", "built-in", "-o", "head.usda", "--only", "jawOpen"), "usd"),
        (("export", "head.fbx", "-o", "head.npz"), "fbx"),
        (("live", "built-in", "--no-open"), "live"),
    ],
    ids=["demo", "usd", "fbx", "live"],
)
def test_what_is_missing_says_how_to_install_itself(
    environment: dict[str, str], tmp_path: Path, words: tuple[str, ...], extra: str
) -> None:
    (tmp_path / "head.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 4 3\n")
    (tmp_path / "head.fbx").write_text("; FBX 7.4.0 project file\n")
    before = set(tmp_path.iterdir())
    done = run(environment, tmp_path, *words)
    assert done.returncode == 1
    assert f"pip install 'elastomorph[{extra}]'" in done.stderr
    assert "Traceback" not in done.stderr
    assert set(tmp_path.iterdir()) - before <= {tmp_path / "c.json"}
