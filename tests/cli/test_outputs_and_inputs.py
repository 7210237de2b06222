"""No verb writes over what it reads, whatever the file is called, unless it is told to."""

from __future__ import annotations

import inspect
import os
from pathlib import Path

import pytest
import typer
from calls import printed_by
from calls import status_of as run
from small_files import write_all

import elastomorph as em
from elastomorph.cli import verb
from elastomorph.cli.app import HEADINGS, VERBS, loaded
from elastomorph.errors import FileError
from elastomorph.io.atomic import inputs_kept, read_bytes, replacing, unnoted

CALLS = [
    (["interpolate", "neutral.obj", "jawOpen.obj", "-o", "{}"], "jawOpen.obj"),
    (["interpolate", "neutral.obj", "jawOpen.obj", "-o", "{}"], "neutral.obj"),
    (["interpolate", "scan.0001.obj", "jawOpen.obj", "--frames", "3", "-o", "scan.####.obj"],
     "scan.0001.obj"),
    (["interpolate", "neutral.obj", "jawOpen.obj", "-o", "a.obj", "--region", "part.json",
      "--picture", "{}"], "part.json"),
    (["curves", "neutral.obj", "--curves", "curves.json", "-o", "{}"], "curves.json"),
    (["curves", "neutral.obj", "--picture", "{}"], "neutral.obj"),
    (["evaluate", "motion.npz", "--no-pictures", "--report", "{}"], "motion.npz"),
    (["inbetweens", "suggest", "motion.npz", "-o", "{}"], "motion.npz"),
    (["learn", "motion.npz", "-o", "{}"], "motion.npz"),
    (["blend", "ours.glb", "-w", "smile=1", "-o", "{}"], "ours.glb"),
    (["blend", "face", "-w", "smile=1", "-o", "{}"], "face/neutral.obj"),
    (["blend", "ours.npz", "--levels", "2", "--sheet", "{}"], "ours.npz"),
    (["blend", "ours.npz", "-w", "smile=1", "-o", "a.obj", "--grid", "{}"], "ours.npz"),
    (["export", "ours.glb", "-o", "{}"], "ours.glb"),
    (["bend", "ours.glb", "-o", "{}"], "ours.glb"),
    (["unbend", "ours.glb", "-o", "{}"], "ours.glb"),
    (["blend", "character/elastomorph.toml", "-w", "smile=1", "-o", "{}"], "character/smile.obj"),
    (["export", "face", "--settings", "own.toml", "-o", "{}"], "own.toml"),
    (["hold", "ours.glb", "-o", "{}"], "ours.glb"),
    (["animate", "ours.glb", "take.csv", "-o", "{}"], "ours.glb"),
    (["animate", "ours.glb", "take.csv", "--picture", "{}"], "take.csv"),
    (["track", "ours.glb", "motion.npz", "-o", "{}"], "motion.npz"),
    (["farm", "ours.glb", "--faces", "9", "-o", "{}"], "ours.glb"),
    (["render", "ours.glb", "-p", "smile=1", "-o", "{}"], "ours.glb"),
    (["view", "ours.glb", "-o", "{}"], "ours.glb"),
    (["live", "ours.glb", "--replay", "take.csv", "--record", "{}"], "take.csv"),
]  # fmt: skip
"""A call of every verb with an output, and the input that it is."""

KINDS = ["itself", "a link", "a hard link"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    write_all(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def another_name(file: Path, kind: str) -> Path:
    """The file by a name of that kind, with the same suffix, in the same folder."""
    if kind == "itself":
        return file
    name = file.with_name(f"other{file.suffix}")
    (name.symlink_to if kind == "a link" else name.hardlink_to)(file.absolute())
    return name


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("words", "name"), CALLS, ids=[f"{w[0]} {n}" for w, n in CALLS])
def test_an_output_that_is_an_input_is_refused(
    here: Path, words: list[str], name: str, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = Path(name)
    before = file.read_bytes()
    output = another_name(file, kind)
    there = sorted(here.rglob("*"))
    assert run(*(word.format(output) for word in words)) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert said.count("\n") == 1
    assert file.read_bytes() == before
    assert sorted(here.rglob("*")) == there
    if output.suffix in (".obj", ".glb", ".npz"):
        assert "--overwrite" in said


def test_every_verb_with_an_output_is_tried() -> None:
    """A verb that gains an output without a row above fails here."""
    tried = {words[0] for words, _ in CALLS}
    tried |= {
        "capture",
        "demo",
        "doctor",
        "register",
        "samples",
    }  # folders of their own, guarded where files are written
    for name in VERBS:
        if "overwrite" in typer.main.get_params_from_function(loaded(name)):
            assert name in tried


def test_what_a_verb_is_for_is_the_start_of_its_words() -> None:
    """It is listed without the verb being imported."""
    for name, text in VERBS.items():
        assert inspect.getdoc(loaded(name)).startswith(text.rstrip(".")), name


def test_each_verb_is_listed_under_one_heading() -> None:
    listed = " ".join(HEADINGS.values()).split()
    assert sorted(listed) == sorted({*VERBS, "inbetweens"})
    assert all(f"{heading}:" in printed_by("--help") for heading in HEADINGS)


def test_overwrite_allows_it(here: Path) -> None:
    words = ["interpolate", "neutral.obj", "jawOpen.obj", "-t", "0", "-o", "jawOpen.obj"]
    assert run(*words, "--overwrite") == 0
    assert (em.read("jawOpen.obj").vertices == em.read("neutral.obj").vertices).all()


def test_an_output_that_is_there_and_no_input_is_replaced(here: Path) -> None:
    for _ in range(2):
        assert run("interpolate", "neutral.obj", "jawOpen.obj", "-o", "half.obj") == 0
        assert run("export", "face", "-o", "rig.npz") == 0


def test_a_file_that_was_read_on_the_way_is_kept(here: Path) -> None:
    """What no word of the call names, such as the targets of settings, is known when it is read."""
    with inputs_kept():
        read_bytes("jawOpen.obj")
        os.link("jawOpen.obj", "hard.obj")
        with pytest.raises(FileError, match="was read as an input"), replacing("hard.obj"):
            pass
        with replacing("smile.obj") as file:
            file.write(b"new")
        with unnoted(), replacing("jawOpen.obj") as file:
            file.write(b"a cache")
        read_bytes("smile.obj")
        with replacing("smile.obj") as file:
            file.write(b"read again by the command that wrote it, and written again")
    with replacing("neutral.obj") as file:
        file.write(b"from Python")


@pytest.mark.parametrize(
    ("words", "package", "extra"),
    [
        (["export", "face", "-o", "a.usdc"], "pxr", "usd"),
        (["export", "face", "-o", "a.glb", "--compress"], "meshopt", "gltf"),
        (["animate", "face", "take.csv", "-o", "a.usda"], "pxr", "usd"),
        (["curves", "neutral.obj", "--picture", "a.png"], "vtkmodules", "demo"),
        (["blend", "face", "--sheet", "a.png"], "PIL", "demo"),
        (["evaluate", "motion.npz", "-o", "tables"], "matplotlib", "demo"),
        (["evaluate", "motion.npz", "--report", "a.html"], "matplotlib", "demo"),
        (["demo", "--data", "face", "-o", "a"], "vtkmodules", "demo"),
    ],
)
def test_a_missing_package_is_noticed_before_anything_is_read(
    here: Path,
    words: list[str],
    package: str,
    extra: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for file in here.rglob("*.obj"):
        file.write_text("v broken")
    found = verb.find_spec
    monkeypatch.setattr(verb, "find_spec", lambda n: None if n == package else found(n))
    assert run(*words) == 1
    assert f"pip install 'elastomorph[{extra}]'" in capsys.readouterr().err
