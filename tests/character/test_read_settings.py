"""What is not understood is refused, with file, line and the nearest known name."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from characters import TABLES, as_toml, write_settings_file
from elastomorph.character import Settings, find_settings, read_settings, rig_from_settings
from elastomorph.character.schema import FREE, tables
from elastomorph.errors import ElastomorphError, FileError, FormatError

TOP = {name.partition(".")[0] for name in (*tables(), *FREE)} - {"material"}

FULL = """\
# A character
[character]
name = "Ada"
neutral = "neutral.obj"
targets = [
  "shapes/*.obj",
]

[method]
default = "beam:3"
material = { damping = 2 }

[methods]
jawOpen = "rotation"
"sm*" = { method = "arc", tolerance = 1e-3 }

[regions.left]
vertices = "0-20,22"
falloff = 2

[regions.left.material]
rigidity = 0.01

[inbetweens.brow]
0.3 = "brow_30.obj"
"0.6" = "brow_60.obj"
"""


def written(folder: Path, text: str, name: str = "some.toml") -> Path:
    (folder / name).write_text(text)
    return folder / name


def test_an_empty_file_is_the_folder_as_it_is(character: Path) -> None:
    found = read_settings(written(character, ""))
    assert found == Settings(found.path, found.character)
    assert found.character.folder == character


def test_times_may_be_written_bare(character: Path) -> None:
    """To TOML a bare 0.3 is the key 3 of the table 0; to an artist it is a time."""
    found = read_settings(written(character, FULL))
    assert found.inbetweens["brow"].files == {0.3: "brow_30.obj", 0.6: "brow_60.obj"}


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("[method]", "[metod]", 9, "unknown table or key 'metod': did you mean 'method'"),
        ("default =", "defalt =", 10, "unknown key 'defalt' in [method]: did you mean 'default'"),
        ("name =", "nam =", 3, "'nam' in [character]: did you mean 'name'"),
        ("{ damping", "{ dampin", 11, "'dampin' in [method.material]: did you mean 'damping'"),
        ("rigidity = 0.01", "ridigity = 0.01", 22, "did you mean 'rigidity'"),
        ('"beam:3"', '"beem:3"', 10, "method.default: method must be one of"),
        ('"beam:3"', '"beam:99"', 10, "method.default: "),
        (
            '"beam:3"',
            "3",
            10,
            "'method.default' must be text in quotes, such as \"beam:3\"; found 3",
        ),
        (
            "damping = 2",
            "damping = -2",
            11,
            "method.material.damping: damping must be a number above 0",
        ),
        ("damping = 2", "damping = nan", 11, "'method.material.damping' must be a finite number"),
        ("damping = 2", "damping = true", 11, "must be a finite number, such as 2.0; found true"),
        ("tolerance = 1e-3", "tolerance = 0", 15, "tolerance must be a number above 0"),
        ('"rotation"', "1979-05-27", 14, "'methods.jawOpen' must be text in quotes"),
        ('"neutral.obj"', '"neutrl.obj"', 4, "names the file 'neutrl.obj', which does not exist"),
        ('"shapes/*.obj"', '"shapes/no.obj"', 5, "'shapes/no.obj', which does not exist"),
        ('"shapes/*.obj"', "7", 5, "must be text or a list of texts"),
        ('"0-20,22"', '"left.jsn"', 18, "regions.left.vertices: region 'left.jsn'"),
        ('"0-20,22"', '"lost.json"', 18, "names the file 'lost.json'"),
        ('"0-20,22"', "[1, -2]", 18, "must be a file, ranges such as"),
        ('vertices = "0-20,22"', "", 17, "the region 'left' has no 'vertices'"),
        ("falloff = 2", "falloff = -1", 19, "falloff must be from 0"),
        ("rigidity = 0.01", "", 17, "the region 'left' says nothing that is done there"),
        ("0.3 =", "1.3 =", 25, "must be between 0 (the neutral) and 1 (the target), found 1.3"),
        ('"0.6"', '"0.30"', 26, "two in-betweens of 'brow' are at 0.3"),
        ('"0.6"', '"metod"', 26, "'metod' in [inbetweens.brow] is neither a time"),
        ("brow_60.obj", "brow_61.obj", 26, "names the file 'brow_61.obj'"),
        ("jawOpen =", "brow =", 14, "'brow' has both a method and in-betweens"),
        ('name = "Ada"', 'unit = "furlong"', 3, "unknown unit 'furlong': there are mm, cm, m, in"),
        ('name = "Ada"', 'rig = "head.npz"', 3, "leave out 'rig' or 'neutral' and 'targets'"),
        ('name = "Ada"', "name = Ada", 3, "not TOML: "),
        ("[method]", '[timing]\ndefault = "soon"\n[method]', 10, "timing 'soon' is unknown"),
        ("[method]", "[export.obj]\n[method]", 9, "'obj' in [export]"),
        ("[method]", "[export.glb]\nfps = 0\n[method]", 10, "export.glb.fps: fps must be from 1"),
        ("[method]", "[export.usd]\nfps = -1\n[method]", 10, "fps must be a number above 0"),
        ("[method]", "[groups]\nall = []\n[method]", 10, "text or a list of texts"),
        ("[method]", 'timing = "cosine"\n[method]', 9, "unknown key 'timing' in [character]"),
        ('"beam:3"\n', '"beam:3"\nload = [1]\n', 10, "'beam:3' and 'load' state the same"),
        ('"beam:3"\n', '"beam:3:rest"\nclosure = "rest"\n', 10, "'closure' state the same"),
        ('"beam:3"\n', '"beam:3"\nharmonics = 1.5\n', 11, "must be a whole number"),
    ],
)
def test_a_mistake_is_named_with_its_line(
    character: Path, old: str, new: str, line: int, message: str
) -> None:
    assert FULL.count(old) == 1
    path = written(character, FULL.replace(old, new))
    with pytest.raises(FormatError) as refused:
        read_settings(path)
    assert message in str(refused.value)
    assert refused.value.line == line
    assert refused.value.path == path


def test_a_table_that_is_no_table(character: Path) -> None:
    for text in ("method = 3", "regions = 3", "regions.mouth = 3", "export.glb = 3", "methods = 3"):
        with pytest.raises(FormatError, match="is a table and must hold keys: write"):
            read_settings(written(character, text))


def test_files_that_are_no_settings(character: Path, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="there is no such file"):
        read_settings(tmp_path / "none.toml")
    with pytest.raises(FileError, match=r"has no elastomorph\.toml; 'elastomorph init"):
        read_settings(tmp_path)
    (tmp_path / "bytes.toml").write_bytes(b'[character]\nname = "\xff"\n')
    with pytest.raises(FormatError, match="line 2: not TOML: the text is not UTF-8"):
        read_settings(tmp_path / "bytes.toml")
    with pytest.raises(FormatError, match="larger than 256 KiB"):
        read_settings(written(tmp_path, "#" * (1 << 19)))
    assert find_settings(tmp_path) is None
    write_settings_file(character, TABLES)
    assert find_settings(character) == read_settings(character).path


def test_a_mark_and_lines_of_windows_are_understood(character: Path) -> None:
    (character / "some.toml").write_bytes(b"\xef\xbb\xbf" + FULL.replace("\n", "\r\n").encode())
    assert read_settings(character / "some.toml").character.name == "Ada"


def test_without_lines_where_text_runs_over_several(character: Path) -> None:
    """Something in such text may look like a key: better no line than a wrong one."""
    text = '[character]\nname = """\n[method]\ndefalt = 1\n"""\n[method]\ndefalt = "arc"\n'
    with pytest.raises(FormatError, match="did you mean 'default'") as refused:
        read_settings(written(character, text))
    assert refused.value.line is None


def assert_settings_or_refused(path: Path) -> None:
    """Reading gives settings, or the one error that names the file."""
    said = ""
    try:
        found = read_settings(path)
    except ElastomorphError as error:
        said = str(error)
    assert str(path) in said if said else isinstance(found, Settings)


KNOWN = [(table, key) for table, keys in tables().items() for key in keys]


@settings(
    max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(place=st.sampled_from([*KNOWN, *(("", name) for name in sorted(TOP))]), typo=st.data())
def test_every_misspelled_name_is_refused_with_a_known_one(
    character: Path, place: tuple[str, str], typo: st.DataObject
) -> None:
    """One letter lost, doubled, changed or swapped, anywhere in any table or key."""
    table, key = place
    index = typo.draw(st.integers(0, len(key) - 1))
    letter = typo.draw(st.sampled_from("abcdefghijklmnopqrstuvwxyz_"))
    wrong = typo.draw(
        st.sampled_from(
            [
                key[:index] + key[index + 1 :],
                key[:index] + letter + key[index:],
                key[:index] + letter + key[index + 1 :],
                key[:index] + key[index : index + 2][::-1] + key[index + 2 :],
            ]
        )
    )
    known = set(tables()[table]) if table else TOP
    assume(wrong and wrong not in known and not wrong.isdecimal())
    where = {"material": "method.material"}.get(table, table.replace("*", "left"))
    beside = {"regions.left": 'vertices = "0-3"\n', "inbetweens.left": '"0.5" = "brow_30.obj"\n'}
    text = f"[{where}]\n{beside.get(where, '')}{wrong} = 1\n" if table else f"[{wrong}]\n"
    with pytest.raises(FormatError) as refused:
        read_settings(written(character, text))
    said = str(refused.value)
    assert repr(wrong) in said
    assert refused.value.line == text.count("\n")
    hinted = said.rpartition(": ")[2]
    assert any(repr(name) in hinted for name in known) or hinted.startswith("there are "), said


def damaged(text: str) -> st.SearchStrategy[bytes]:
    """The text with a piece cut out, doubled or replaced by anything."""

    def change(cut: tuple[int, int, bytes]) -> bytes:
        raw = text.encode()
        start, length, instead = cut
        start %= len(raw) + 1
        return raw[:start] + instead + raw[start + length :]

    return st.tuples(st.integers(0, 10_000), st.integers(0, 40), st.binary(max_size=12)).map(change)


@settings(
    max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    content=st.one_of(damaged(FULL), st.binary(max_size=60), st.text(max_size=60).map(str.encode))
)
def test_any_bytes_are_settings_or_one_error(character: Path, content: bytes) -> None:
    (character / "some.toml").write_bytes(content)
    assert_settings_or_refused(character / "some.toml")


@pytest.mark.parametrize("length", range(0, len(FULL), 7))
def test_a_file_cut_off_anywhere(character: Path, length: int) -> None:
    assert_settings_or_refused(written(character, FULL[:length]))


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 100_000,
        "a = " + "{a=" * 60_000,
        ".".join(["a"] * 100_000) + " = 1",
        "[" + ".".join(["a"] * 100_000) + "]",
        "\n".join(f"[a.b{i}]" for i in range(15_000)),
        "[method]\nharmonics = " + "9" * 200_000,
        "[methods]\n" + "\n".join(f"m{i} = 'arc'" for i in range(15_000)) + "\nx = 3",
        '[method]\ndefault = "' + "beam:" * 40_000 + '"',
        '[regions.a]\nvertices = "' + "0-9," * 50_000 + '"',
        '[regions.a]\nmethod = "arc"\nvertices = "0-2147483647"',
    ],
    ids=lambda text: text[:12].replace("\n", " "),
)
def test_absurd_files_are_refused_soon(character: Path, text: str) -> None:
    path = written(character, text)
    start = time.process_time()
    with pytest.raises(FormatError):
        rig_from_settings(read_settings(path), cache=None)
    assert time.process_time() - start < 2


def test_settings_may_be_written_by_programs(character: Path) -> None:
    assert read_settings(written(character, as_toml(TABLES))).character.neutral == "neutral.obj"


@pytest.mark.parametrize("name", ["n" * 300, "n/" * 3000, "a\0b"])
def test_a_path_that_cannot_be_is_an_error_of_ours(tmp_path: Path, name: str) -> None:
    with pytest.raises(FileError):
        read_settings(tmp_path / f"{name}.toml")


@pytest.mark.parametrize(
    "text",
    [
        f"{'k' * 100_000} = 1",
        f'[method]\ndefault = "{"b" * 100_000}"',
        f'[character]\nneutral = "{"n" * 100_000}"',
        f'[inbetweens.a]\n"{"9" * 100_000}" = "a.obj"',
    ],
)
def test_a_message_about_an_endless_name_can_be_read(tmp_path: Path, text: str) -> None:
    path = tmp_path / "elastomorph.toml"
    path.write_text(text)
    with pytest.raises(FormatError, match=r"elastomorph\.toml, line") as caught:
        read_settings(path)
    assert len(str(caught.value)) < 1000
