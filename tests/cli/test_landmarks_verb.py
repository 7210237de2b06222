"""``elastomorph landmarks``: what is shown, what is saved, and what is refused."""

from __future__ import annotations

import json
import subprocess
import urllib.request
from pathlib import Path

import pytest
from calls import status_of as run
from small_files import write_all

import elastomorph as em
from children import started
from elastomorph import samples
from elastomorph.capturing.landmarks import LANDMARKS, read_landmarks
from elastomorph.viewer import ViewerServer
from small_head import head


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two photographs, a scan, and files that are none; the command runs there."""
    monkeypatch.chdir(tmp_path)
    for name in ("neutral/1.jpg", "neutral/2.jpg", "text.json", "empty/notes.txt"):
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text("text")
    em.write("scan.ply", head())
    Path("good.json").write_text('{"version": 1, "vertices": {"chin": 7}}')
    Path("far.json").write_text('{"version": 1, "vertices": {"chin": 700000}}')
    return tmp_path


def test_a_page_is_written(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("landmarks", "neutral", "--template", "built-in", "-o", "page.html", "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert said == {"written": "page.html", "bytes": Path("page.html").stat().st_size}
    assert run("landmarks", "neutral", "scan.ply", "-o", "page.html") == 0
    assert capsys.readouterr().out.startswith("neutral and scan.ply → page.html (")


def test_what_is_placed_is_saved_until_the_page_has_finished(folder: Path) -> None:
    """The command ends by itself, and says what the file holds."""
    words = ("-m", "elastomorph", "landmarks", "neutral", "--template", "built-in", "--no-open")
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with started(*words, cwd=folder, **pipes) as process:
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        content = {
            "version": 1,
            "vertices": {"chin": 5, "nose_tip": 6},
            "photographs": {"neutral": {"1.jpg": {"chin": [1, 2]}, "2.jpg": {"nose_tip": [3, 4]}}},
            "points": {},
        }
        origin = address.rpartition("/")[0].rpartition("/")[0]
        request = urllib.request.Request(
            f"{address}landmarks.json?finish", json.dumps(content).encode(), {"Origin": origin}
        )
        with urllib.request.urlopen(request, timeout=60) as reply:
            assert reply.status == 200
        out, problems = process.communicate(timeout=60)
    assert process.returncode == 0
    assert problems == ""
    assert out.splitlines()[-1] == (
        "landmarks.json: 2 vertices of the template; 2 of 15 points in 2 photographs of neutral"
    )
    assert json.loads((folder / "landmarks.json").read_text()) == content


def test_what_the_file_holds_is_gone_on_with(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pages: list[str] = []

    def visit(address: str) -> bool:
        with urllib.request.urlopen(address, timeout=60) as reply:
            pages.append(reply.read().decode())
        return True

    monkeypatch.setattr("webbrowser.open", visit)
    monkeypatch.setattr(ViewerServer, "wait", lambda self: None)
    assert run("landmarks", "--template", "scan.ply", "-o", "good.json") == 0
    assert '"vertices": {"chin": 7}' in pages[0]
    assert capsys.readouterr().out.endswith("good.json: 1 vertices of the template\n")
    em.write("own.ply", samples.head())
    assert run("landmarks", "--template", "own.ply", "-o", "new.json") == 0
    known = json.loads(task_in(pages[1]))
    assert set(known["known"]["vertices"]) == set(LANDMARKS), "it has the polygons of our own head"
    assert not Path("new.json").exists(), "nothing was placed"
    assert read_landmarks("good.json").vertices == {"chin": 7}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "nothing to place points on"),
        (["nowhere"], "nowhere"),
        (["empty"], "no JPEG, PNG or TIFF photographs"),
        (["nowhere.ply"], "nowhere.ply"),
        (["neutral/1.jpg"], "1.jpg"),
        (["neutral", "neutral"], "two files called 1.jpg"),
        (["--template", "neutral"], "neutral"),
        (["neutral", "-o", "text.json"], "text.json: it is not JSON"),
        (["neutral", "-o", "scan.ply"], "saved as .json"),
        (["neutral", "-o", "no/where.html"], "where.html"),
        (["neutral", "-o", "no/where.json"], "does not exist; create it first"),
        (["neutral", "-o", "page.html", "--port", "8000"], "not served"),
        (["neutral", "--port", "70000"], "70000"),
        (["neutral", "--working", "empty"], "no cameras are solved in it"),
        (["--template", "scan.ply", "-o", "far.json"], "vertex 700,000"),
    ],
)
def test_mistakes(
    folder: Path, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(folder.rglob("*"))
    assert run("landmarks", *arguments, "--no-open") == 1
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert message in said
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    "rig",
    ["face", "character", "foreign.glb", "foreign.vrm", "ours.glb", "ours.npz", "neutral.obj"],
)
def test_a_template_is_whatever_holds_a_neutral(
    rig: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_all(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert run("landmarks", "--template", rig, "-o", "page.html") == 0
    place = json.loads(task_in(Path("page.html").read_text()))["places"][0]
    assert (place["kind"], place["name"]) == ("template", rig)


def task_in(page: str) -> str:
    """What a page is told."""
    return page.split('id="elastomorph-landmarks">')[1].split("</script>")[0]
