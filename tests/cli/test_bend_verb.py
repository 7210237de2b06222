"""``elastomorph bend`` and ``elastomorph unbend``."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from calls import status_of as run

import elastomorph as em
from elastomorph.io.gltf.container import open_gltf
from foreign_files import chunks_of, glb
from small_head import straight


@pytest.fixture
def head(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two targets of the small head in a file, straight; the program runs in its folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    em.write("head.glb", straight("jawOpen", "eyeBlink_L"))
    return tmp_path / "head.glb"


def test_it_bends_and_says_what_it_costs(head: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("bend", "head.glb", "-o", "bent.glb") == 0
    said = capsys.readouterr().out
    for words in ("jawOpen", "2 of 2 targets bend", "before 2; bytes", "written: bent.glb"):
        assert words in said
    assert "by rounding" not in said
    em.write("small.glb", em.read_rig("head.glb", method="linear"), compress=True)
    assert run("bend", "small.glb", "-o", "tight.glb") == 0
    assert "% by rounding to the numbers of the file" in capsys.readouterr().out
    assert run("unbend", "bent.glb", "-o", "back.glb") == 0
    assert open_gltf("back.glb").document == open_gltf(head).document


def test_curves_are_given_back_and_written_beside(
    head: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("bend", "head.glb", "-o", "bent.glb") == 0
    document, blob = chunks_of(Path("bent.glb"))
    document["meshes"][0]["extras"].pop("elastomorph")
    Path("packed.glb").write_bytes(glb(document, blob))
    capsys.readouterr()
    assert run("bend", "packed.glb", "-o", "back.glb") == 1
    assert "--from" in capsys.readouterr().err
    words = ["bend", "packed.glb", "--from", "bent.glb", "--curves", "face.json"]
    assert run(*words, "--json") == 0
    assert not Path("back.glb").exists()
    facts = json.loads(capsys.readouterr().out)
    assert facts["matched"] == {"name": facts["targets"], "index": 0, "shape": 0}
    assert run("bend", "packed.glb", "--from", "face.json", "-o", "back.glb") == 0
    assert "curves are given back" in capsys.readouterr().out
    back, bent = (em.read_rig(path) for path in ("back.glb", "bent.glb"))
    pose = {"jawOpen": 0.5, "eyeBlink_L": 0.3}
    assert (back.pose(pose) == bent.pose(pose)).all()
    assert run(*words[:4], "--method", "auto", "-o", "again.glb") == 1


def test_a_dry_run_writes_nothing(head: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("bend", "head.glb", "--dry-run", "--only", "jawOpen", "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert [own["name"] for own in facts["bent"]] == ["jawOpen"]
    assert facts["straight"] == ["eyeBlink_L"]
    assert list(head.parent.iterdir()) == [head]


def test_where_nothing_bends_it_says_so_and_writes_nothing(
    head: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ("bend", "head.glb", "-o", "bent.glb", "--method", "linear")
    assert run(*words) == 0
    assert capsys.readouterr().out == "0 of 2 targets bend\nnothing bends, so nothing was written\n"
    assert run(*words, "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["written"] is facts["output"] is None
    assert list(head.parent.iterdir()) == [head]
    assert run("bend", "head.glb", "-o", "bent.glb", "--json") == 0
    assert json.loads(capsys.readouterr().out)["written"] == "bent.glb"
    assert run("bend", "bent.glb", "-o", "bent.glb", "--overwrite", "--method", "linear") == 0
    assert "'elastomorph unbend' writes the original" in capsys.readouterr().out


def test_settings_state_the_method_of_each_target(
    head: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("own.toml").write_text(
        '[character]\nrig = "head.glb"\n[method]\ndefault = "linear"\n'
        '[methods]\njawOpen = "rotation"\n'
    )
    for words in (["head.glb", "--settings", "own.toml"], ["own.toml"]):
        assert run("bend", *words, "--dry-run", "--json") == 0
        facts = json.loads(capsys.readouterr().out)
        assert [(own["name"], own["method"]) for own in facts["bent"]] == [("jawOpen", "rotation")]
    Path("other.toml").write_text('[character]\nrig = "head.glb"\n[methods]\njawOpne = "beam"\n')
    assert run("bend", "head.glb", "--settings", "other.toml", "--dry-run") == 1
    assert "'jawOpne' in [methods] is no target" in capsys.readouterr().err
    Path("parts.toml").write_text(
        '[character]\nrig = "head.glb"\n[regions.mouth]\nvertices = [1]\nmethod = "beam"\n'
    )
    assert run("bend", "parts.toml", "--dry-run") == 1
    assert "has [regions], which bend does not take" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["head.glb"], "say where to write the bent character"),
        (["head.glb", "-o", "bent.gltf"], "keeps its format"),
        (["head.glb", "-o", "bent.glb", "--only", "smile"], "no slider 'smile'"),
        (["head.glb", "-o", "bent.glb", "--tolerance", "-1"], "tolerance"),
        (["built-in", "-o", "bent.glb"], "the built-in head is in no file to bend"),
        (["head.glb", "-o", "head.glb"], "--overwrite"),
    ],
)
def test_what_cannot_be_is_one_sentence(
    head: Path, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = head.read_bytes()
    assert run("bend", *words) == 1
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert head.read_bytes() == before
    assert list(head.parent.iterdir()) == [head]


def test_only_a_bent_file_gives_its_place_to_one_that_is_bent_anew(
    head: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its original is within; the character itself is never written over."""
    before = head.read_bytes()
    assert run("bend", "head.glb", "-o", "head.glb", "--overwrite") == 1
    assert "this is the character itself" in capsys.readouterr().err
    assert head.read_bytes() == before
    assert run("bend", "head.glb", "-o", "bent.glb") == 0
    words = ("bend", "bent.glb", "-o", "bent.glb", "--only", "eyeBlink_L")
    assert run(*words) == 1
    assert run(*words, "--overwrite") == 0
    rig = em.read_rig("bent.glb")
    assert [len(rig.morphs[name].bends) > 0 for name in rig.names] == [False, True]
