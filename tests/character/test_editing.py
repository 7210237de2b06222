"""Methods written into settings: the lines that are meant change, and nothing else."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path

import pytest

import elastomorph as em
from elastomorph.character import read_settings
from elastomorph.character.editing import said_of, save_methods, with_methods

PATH = Path("elastomorph.toml")

COMMENTED = """\
# Ada, from the scan of March
[character]
name = "Ada"  # short

[methods]  # by target
# turns
jawOpen = "arc"   # was linear
"eye*" = "auto"

# Parts of the face.
#[regions.mouth]
#vertices = "mouth.json"
"""


def changed(text: str, **choices: str) -> str:
    return with_methods(PATH, text.encode(), choices).decode()


def test_a_line_is_changed_in_its_place() -> None:
    """The comment behind it, the order and all other lines stay."""
    assert changed(COMMENTED, jawOpen="rotation") == COMMENTED.replace('"arc"', '"rotation"')


def test_new_lines_stand_below_the_header() -> None:
    """Behind the last key they would follow a table that is a comment still."""
    found = changed(COMMENTED, smile="linear", **{"a b": "ease:2"})
    header = "[methods]  # by target\n"
    assert found == COMMENTED.replace(header, f'{header}smile = "linear"\n"a b" = "ease:2"\n')


def test_a_line_is_taken_away() -> None:
    assert changed(COMMENTED, jawOpen="") == COMMENTED.replace(
        'jawOpen = "arc"   # was linear\n', ""
    )
    assert changed(COMMENTED, unknown="") == COMMENTED


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", '[methods]\njaw = "arc"\n'),
        ("# mine", '# mine\n\n[methods]\njaw = "arc"\n'),
        ('methods = { jaw = "auto" }', 'methods = { jaw = "arc" }'),
        (
            '[timing]\ndefault = "blink"\n',
            '[timing]\ndefault = "blink"\n\n[methods]\njaw = "arc"\n',
        ),
        ('methods.jaw = "auto" # so\n', 'methods.jaw = "arc" # so\n'),
        ('[methods]\njaw = { method = "beam:2" }', '[methods]\njaw = { method = "arc" }'),
        ('[methods.jaw]\nclosure = "rest"\n', '[methods.jaw]\nmethod = "arc"\nclosure = "rest"\n'),
        ('[methods]\r\njaw = "auto"\r\n', '[methods]\r\njaw = "arc"\r\n'),
        ('\ufeff[methods]\njaw = "auto"\n', '\ufeff[methods]\njaw = "arc"\n'),
        (
            '[inbetweens.jaw]\n"0.5" = "half.obj"\n# as scanned\n',
            '[inbetweens.jaw]\nmethod = "arc"\n"0.5" = "half.obj"\n# as scanned\n',
        ),
        (
            '[methods.other]\nmethod = "auto"\n',
            '[methods.other]\nmethod = "auto"\n\n[methods]\njaw = "arc"\n',
        ),
    ],
)
def test_every_way_to_write_it(text: str, expected: str) -> None:
    found = changed(text, jaw="arc")
    assert found == expected
    assert tomllib.loads(found.removeprefix("\ufeff"))


def test_what_the_text_of_a_method_states_is_stated_once() -> None:
    text = '[methods.jaw]\nmethod = "beam:2"\nclosure = "rest"\nstiffness = "length"\n'
    expected = '[methods.jaw]\nmethod = "beam:3:limit"\nstiffness = "length"\n'
    assert changed(text, jaw="beam:3:limit") == expected


@pytest.mark.parametrize("text", ['a = """\n[methods]\n"""\n', 'methods.jaw = "auto"\n'])
def test_what_cannot_be_told_apart_is_left_alone(text: str) -> None:
    with pytest.raises(em.FormatError, match="write them by hand: brow = 'arc'"):
        changed(text, brow="arc")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    place = tmp_path / "elastomorph.toml"
    place.write_text('[methods]\njawOpen = "arc"\n')
    return place


def test_saved_methods_are_read_again(file: Path) -> None:
    after = save_methods(file, {"jawOpen": "rotation", "smile": "beam:3"}, {"jawOpen": "arc"})
    assert after == read_settings(file)
    assert (said_of(after, "jawOpen"), said_of(after, "smile")) == ("rotation", "beam:3")


def test_a_file_is_made_where_there_is_none(tmp_path: Path) -> None:
    save_methods(tmp_path / "elastomorph.toml", {"jawOpen": "arc"}, {})
    assert read_settings(tmp_path).methods["jawOpen"].name == "arc"


def test_what_an_editor_wrote_meanwhile_stays(file: Path) -> None:
    """Other lines are merged; the same line is refused, and nothing is lost."""
    theirs = '# theirs\n[methods]\njawOpen = "arc"\nsmile = "linear"\n'
    file.write_text(theirs)
    save_methods(file, {"jawOpen": "rotation"}, {"jawOpen": "arc"})
    assert file.read_text() == theirs.replace('"arc"', '"rotation"')
    with pytest.raises(em.FormatError, match=r"of smile it now says 'linear'.*read it 'nothing'"):
        save_methods(file, {"brow": "arc", "smile": "rotation"}, {})
    assert file.read_text() == theirs.replace('"arc"', '"rotation"')


@pytest.mark.parametrize(
    ("content", "choice", "problem"),
    [
        ("[methods", "arc", "not TOML"),
        ("[metods]\n", "arc", "did you mean 'methods'"),
        ("", "bend", "must be one of linear"),
        ("", "beam:2:so", "beam:2:so"),
        ("", 'arc"\n[character]\nrig = "x', "must be one of"),
    ],
)
def test_nothing_is_written_that_could_not_be_read(
    tmp_path: Path, content: str, choice: str, problem: str
) -> None:
    file = tmp_path / "elastomorph.toml"
    file.write_text(content)
    with pytest.raises(em.ElastomorphError, match=problem):
        save_methods(file, {"jawOpen": choice}, {})
    assert file.read_text() == content


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anyway")
def test_a_folder_that_may_not_be_written_in(file: Path) -> None:
    file.parent.chmod(0o500)
    try:
        with pytest.raises(em.FileError, match="permission"):
            save_methods(file, {"jawOpen": "rotation"}, {"jawOpen": "arc"})
    finally:
        file.parent.chmod(0o700)
