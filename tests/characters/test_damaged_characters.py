"""A damaged character, or one made to harm: one error that names it, and nothing left behind."""

from __future__ import annotations

import json
import os
import time
import tracemalloc
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from random import Random

import pytest

import elastomorph as em
from character_makers import Recipe, make_character
from damaged_characters import EITHER, REFUSED, Change
from effort import worked
from elastomorph.errors import ElastomorphError, ElastomorphWarning
from gltf_builder import glb_of
from hostile.documents import chunks, damaged_document
from needs import not_root

pytestmark = pytest.mark.hostile

MOST_SECONDS, MOST_MEMORY = 5.0, 256 << 20


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    recipe = Recipe(parts=("teeth",), skin="bind", storage="sparse", clips=("linear", "cubic"))
    return make_character(recipe, tmp_path_factory.mktemp("sound") / "face.glb").read_bytes()


def changed(sound: bytes, change: Change, folder: Path) -> Path:
    document, blob = chunks(sound)
    spoilt = bytearray(blob)
    change(document, spoilt)
    path = folder / "face.glb"
    path.write_bytes(glb_of(document, bytes(spoilt)))
    return path


@contextmanager
def watched(path: Path, out: Path) -> Iterator[None]:
    """The source stays, nothing but the output appears, in little time and memory."""
    content, before = path.read_bytes(), sorted(path.parent.rglob("*"))
    start = time.process_time()
    yield
    assert time.process_time() - start < MOST_SECONDS
    assert path.read_bytes() == content
    assert sorted(own for own in path.parent.rglob("*") if own != out) == before


def refusal(path: Path, out: Path) -> str:
    """The message of the one error that bending raises, which leaves nothing behind."""
    with watched(path, out), pytest.raises(ElastomorphError) as caught:
        em.bend(path, out)
    assert not out.exists()
    message = str(caught.value)
    assert path.name in message
    assert len(message) < 900
    assert "\n" not in message
    return message


def attempt(path: Path, out: Path) -> bool:
    """Whether it was bent; if not, it was refused as it should be."""
    with watched(path, out), warnings.catch_warnings():
        warnings.simplefilter("ignore", ElastomorphWarning)
        problem = problem_of(em.bend, path, out)
    if problem is not None:
        assert path.name in problem
        assert len(problem) < 900
        assert not out.exists()
    return problem is None


def problem_of(action: Callable[[Path, Path], object], path: Path, out: Path) -> str | None:
    """The message of the error that it ends with, if any."""
    try:
        action(path, out)
    except ElastomorphError as problem:
        return str(problem)
    return None


def test_the_sound_one_is_bent(sound: bytes, tmp_path: Path) -> None:
    path = changed(sound, lambda *_: None, tmp_path)
    assert attempt(path, tmp_path / "out.glb")


@pytest.mark.parametrize("name", REFUSED)
def test_it_is_refused(sound: bytes, tmp_path: Path, name: str) -> None:
    refusal(changed(sound, REFUSED[name], tmp_path), tmp_path / "out.glb")


@pytest.mark.parametrize("name", EITHER)
def test_it_is_bent_or_refused(sound: bytes, tmp_path: Path, name: str) -> None:
    """What can be bent is, if anything in it bends: then `unbend` gives back what was there."""
    path = changed(sound, EITHER[name], tmp_path)
    out, back = tmp_path / "out.glb", tmp_path / "back.glb"
    if attempt(path, out) and out.exists():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ElastomorphWarning)
            em.unbend(out, back)
        assert chunks(back.read_bytes()) == chunks(path.read_bytes())


def test_a_file_that_ends_too_early(sound: bytes, tmp_path: Path) -> None:
    size = len(sound)
    text = 20 + len(json.dumps(chunks(sound)[0], ensure_ascii=False, separators=(",", ":")))
    path = tmp_path / "face.glb"
    for length in (0, 3, 4, 11, 12, 19, 20, 21, text // 2, text + 7, size // 2, size - 1):
        path.write_bytes(sound[:length])
        refusal(path, tmp_path / "out.glb")


def test_a_hundredth_of_the_bytes_are_others(sound: bytes, tmp_path: Path) -> None:
    random, path, out = Random(3), tmp_path / "face.glb", tmp_path / "out.glb"
    for _ in range(12):
        spoilt = bytearray(sound)
        for _ in range(len(sound) // 100):
            spoilt[random.randrange(len(sound))] = random.randrange(256)
        path.write_bytes(spoilt)
        attempt(path, out)
        out.unlink(missing_ok=True)


@pytest.mark.slow
def test_documents_with_other_values(sound: bytes, tmp_path: Path) -> None:
    """Some hundred documents, one to three values of each replaced or left out."""
    random = Random(11)
    document, blob = chunks(sound)
    path, out = tmp_path / "face.glb", tmp_path / "out.glb"
    end = worked() + 20
    tried = bent = 0
    while tried < 300 and worked() < end:
        label, spoilt = damaged_document(random, document)
        try:
            path.write_bytes(glb_of(spoilt, blob))
        except (RecursionError, UnicodeEncodeError):
            continue
        tried += 1
        try:
            bent += attempt(path, out)
        except BaseException as problem:
            problem.add_note(f"{tried}: {label}")
            raise
        out.unlink(missing_ok=True)
    assert tried > 30
    assert 0 < bent < tried


def test_a_small_file_takes_little_memory(sound: bytes, tmp_path: Path) -> None:
    for name in (
        "ten thousand targets",
        "thousands of millions of vertices",
        "compressed to more than there is",
        "a buffer longer than the file",
    ):
        path = changed(sound, REFUSED[name], tmp_path)
        tracemalloc.start()
        try:
            refusal(path, tmp_path / "out.glb")
            assert tracemalloc.get_traced_memory()[1] < MOST_MEMORY
        finally:
            tracemalloc.stop()


@pytest.mark.parametrize("link", ["the same", "through another folder", "a link", "a second name"])
def test_the_output_is_not_the_source(sound: bytes, tmp_path: Path, link: str) -> None:
    path = tmp_path / "face.glb"
    path.write_bytes(sound)
    (tmp_path / "below").mkdir()
    out = tmp_path / "other.glb"
    if link == "the same":
        out = path
    elif link == "through another folder":
        out = tmp_path / "below" / ".." / "face.glb"
    elif link == "a link":
        out.symlink_to(path)
    else:
        os.link(path, out)
    with pytest.raises(ElastomorphError, match="is the character itself"):
        em.bend(path, out)
    assert path.read_bytes() == sound


def test_files_of_another_character_are_kept(tmp_path: Path) -> None:
    """Files that a document refers to go with it, and replace none of the same name."""
    recipe = Recipe(suffix=".gltf", parts=("lashes",))
    path = make_character(recipe, tmp_path / "face.gltf")
    other = tmp_path / "other"
    other.mkdir()
    taken = other / "face 0.bin"
    taken.write_text("of another character")
    with pytest.raises(ElastomorphError, match=r"face 0\.bin"):
        em.bend(path, other / "bent.gltf")
    assert [own.name for own in other.iterdir()] == [taken.name]
    assert taken.read_text() == "of another character"
    taken.write_bytes((tmp_path / taken.name).read_bytes())
    em.bend(path, other / "bent.gltf")
    em.bend(path, other / "bent.gltf")


def test_outputs_of_other_kinds_are_refused(sound: bytes, tmp_path: Path) -> None:
    path = tmp_path / "face.glb"
    path.write_bytes(sound)
    for name in ("out.obj", "out", "out.txt", "out.usda", "out.fbx"):
        with pytest.raises(ElastomorphError):
            em.bend(path, tmp_path / name)
        assert not (tmp_path / name).exists()


def test_what_is_no_file(sound: bytes, tmp_path: Path) -> None:
    folder = tmp_path / "face.glb"
    folder.mkdir()
    for path in (folder, tmp_path / "nobody.glb"):
        with pytest.raises(ElastomorphError, match=path.name):
            em.bend(path, tmp_path / "out.glb")
    path = tmp_path / "whole.glb"
    path.write_bytes(sound)
    with pytest.raises(ElastomorphError):
        em.bend(path, tmp_path / "no such folder" / "out.glb")
    assert sorted(own.name for own in tmp_path.iterdir()) == ["face.glb", "whole.glb"]


@not_root
def test_a_medium_that_can_only_be_read(sound: bytes, tmp_path: Path) -> None:
    """The source may be there; the output may not."""
    medium = tmp_path / "medium"
    medium.mkdir()
    path = medium / "face.glb"
    path.write_bytes(sound)
    path.chmod(0o400)
    medium.chmod(0o500)
    try:
        assert em.bend(path, tmp_path / "out.glb")
        with pytest.raises(ElastomorphError, match=r"out\.glb"):
            em.bend(path, medium / "out.glb")
        assert [own.name for own in medium.iterdir()] == ["face.glb"]
    finally:
        medium.chmod(0o700)


def test_unbend_of_what_was_never_bent(sound: bytes, tmp_path: Path) -> None:
    path = tmp_path / "face.glb"
    path.write_bytes(sound)
    with pytest.raises(ElastomorphError, match=r"face\.glb"):
        em.unbend(path, tmp_path / "back.glb")
    assert not (tmp_path / "back.glb").exists()


def test_the_record_of_what_was_undone_is_damaged(sound: bytes, tmp_path: Path) -> None:
    """`unbend` and a second `bend` of records that were changed: the original, or an error."""
    source, bent = tmp_path / "face.glb", tmp_path / "bent.glb"
    source.write_bytes(sound)
    em.bend(source, bent)
    document, blob = chunks(bent.read_bytes())
    record = document["extras"]["elastomorph"]
    random, path, out = Random(5), tmp_path / "changed.glb", tmp_path / "out.glb"
    for number in range(60):
        _, spoilt = damaged_document(random, record)
        changed = {**document, "extras": {**document["extras"], "elastomorph": spoilt}}
        try:
            path.write_bytes(glb_of(changed, blob))
        except (RecursionError, UnicodeEncodeError):
            continue
        for action in (em.unbend, em.bend):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ElastomorphWarning)
                problem = problem_of(action, path, out)
            if problem is not None:
                assert "changed.glb" in problem, number
                assert not out.exists()
            out.unlink(missing_ok=True)


def test_a_bent_file_that_lost_its_end(sound: bytes, tmp_path: Path) -> None:
    source, bent = tmp_path / "face.glb", tmp_path / "bent.glb"
    source.write_bytes(sound)
    em.bend(source, bent)
    content = bent.read_bytes()
    cut = tmp_path / "cut.glb"
    for length in (len(content) - 4, len(content) - len(content) // 10, len(content) // 2):
        cut.write_bytes(content[:length])
        for action in (em.unbend, em.bend):
            with pytest.raises(ElastomorphError, match=r"cut\.glb"):
                action(cut, tmp_path / "out.glb")
            assert not (tmp_path / "out.glb").exists()
