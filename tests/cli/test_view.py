"""``elastomorph view``: what is shown, where, and what is refused."""

from __future__ import annotations

import base64
import json
import signal
import subprocess
import urllib.request
import zlib
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from children import started
from elastomorph.io.gltf.clips import read_weight_clips
from elastomorph.io.gltf.primitives import read_primitives
from elastomorph.rig import Rig
from elastomorph.viewer import ViewerServer
from elastomorph.viewer.server import serve_page
from foreign_files import chunks_of, glb, write_foreign_glb
from small_head import expressions, head, shapes, straight

STAND_IN = "<!doctype html><head>\n<!-- elastomorph scene -->\n</head><body></body>\n"


@pytest.fixture(autouse=True)
def _page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("elastomorph.viewer.page.shipped_page", lambda: STAND_IN)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A neutral and two targets of the small head, as files."""
    place = tmp_path / "sculpts"
    place.mkdir()
    em.write(place / "neutral.obj", head())
    for name in ("sad", "puff"):
        em.write(place / f"{name}.obj", expressions()[name])
    return place


@pytest.fixture
def small() -> Rig:
    mesh = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3]])
    target = mesh.with_vertices(mesh.vertices * 1.5)
    return Rig(mesh, {"grow": em.interpolate(mesh, target, "linear")})


def written(path: Path) -> tuple[dict[str, Any], list[bytes]]:
    """The scene in a page and its GLB files, by cutting the text."""

    def block(name: str) -> str:
        return path.read_text().split(f'id="{name}">')[1].split("</script>")[0]

    scene = json.loads(block("elastomorph-scene"))
    return scene, [
        zlib.decompress(base64.b64decode(block(model["glb"][1:]))) for model in scene["models"]
    ]


def rig_in(glb: bytes, folder: Path) -> Rig:
    path = folder / "back.glb"
    path.write_bytes(glb)
    return em.read_rig(path)


def test_a_glb_is_shown_as_it_is(small: Rig, tmp_path: Path) -> None:
    em.write(tmp_path / "face.glb", small)
    assert run("view", tmp_path / "face.glb", "-o", tmp_path / "page.html") == 0
    scene, glbs = written(tmp_path / "page.html")
    assert [(m["name"], m["role"]) for m in scene["models"]] == [("face", "rig")]
    assert glbs == [(tmp_path / "face.glb").read_bytes()]
    assert len(scene["loops"]) == len([c for c in em.extract_curves(small.neutral) if len(c) > 1])


def test_a_glb_of_others_has_no_loops(small: Rig, tmp_path: Path) -> None:
    em.write(tmp_path / "face.glb", small)
    document, blob = chunks_of(tmp_path / "face.glb")
    document["meshes"][0]["extras"] = {"targetNames": ["grow"]}
    (tmp_path / "face.glb").write_bytes(glb(document, blob))
    assert run("view", tmp_path / "face.glb", "-o", tmp_path / "page.html") == 0
    assert "loops" not in written(tmp_path / "page.html")[0]


def test_a_folder_becomes_a_rig(folder: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    assert run("view", folder, "-o", page, "--unit", "cm") == 0
    scene, (glb,) = written(page)
    assert scene["title"] == "sculpts"
    assert scene["unit"] == "cm"
    assert scene["diameter"] == pytest.approx(head().diameter)
    rig = rig_in(glb, tmp_path)
    assert rig.names == ("puff", "sad")
    assert all(morph.choice is not None for morph in rig.morphs.values())


def test_methods_are_compared(folder: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    assert run("view", folder, "--method", "linear", "--method", "beam:3", "-o", page) == 0
    scene, glbs = written(page)
    assert [(m["name"], m["role"]) for m in scene["models"]] == [
        ("linear", "method"),
        ("beam R=3", "method"),
    ]
    assert scene["start"] == {"arrangement": "side", "shown": [0, 1]}
    for shown, method in zip(glbs, ("linear", "beam:3"), strict=True):
        path = em.interpolate(head(), expressions()["sad"], method)
        found = rig_in(shown, tmp_path).pose({"sad": 0.5})
        np.testing.assert_allclose(found, path.at(0.5), atol=2e-6 * head().diameter)


def test_a_rig_file_gets_new_paths_where_a_method_is_named(small: Rig, tmp_path: Path) -> None:
    em.write(tmp_path / "face.npz", small)
    page = tmp_path / "page.html"
    assert run("view", tmp_path / "face.npz", "--method", "ease:2", "-o", page) == 0
    _, (glb,) = written(page)
    rig = rig_in(glb, tmp_path)
    assert rig.morphs["grow"].method == "ease R=2"
    np.testing.assert_allclose(rig.pose({"grow": 0.5}), 1.125 * small.neutral.vertices, atol=1e-6)


def test_files_are_compared(small: Rig, tmp_path: Path) -> None:
    em.write(tmp_path / "a.glb", small)
    em.write(tmp_path / "b.npz", small)
    page = tmp_path / "page.html"
    assert run("view", tmp_path / "a.glb", tmp_path / "b.npz", "-o", page, "--json") == 0
    scene, glbs = written(page)
    assert [m["name"] for m in scene["models"]] == ["a", "b"]
    assert len(glbs) == 2


def test_every_file_by_every_method(small: Rig, tmp_path: Path) -> None:
    em.write(tmp_path / "a.npz", small)
    em.write(tmp_path / "b.npz", small)
    page = tmp_path / "page.html"
    files = [tmp_path / "a.npz", tmp_path / "b.npz"]
    assert run("view", *files, "--method", "linear", "--method", "cosine", "-o", page) == 0
    scene, _ = written(page)
    assert scene["title"] == "a and b: linear, cosine"
    assert scene["name"] == "a and b", "what is kept of them is theirs by any method"
    names = ["a, linear", "a, cosine", "b, linear", "b, cosine"]
    assert [m["name"] for m in scene["models"]] == names


def test_the_words_after_writing(
    small: Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    em.write(tmp_path / "a.glb", small)
    page = tmp_path / "page.html"
    assert run("view", tmp_path / "a.glb", "-o", page, "--json") == 0
    assert json.loads(capsys.readouterr().out) == {
        "written": str(page),
        "bytes": page.stat().st_size,
    }
    assert run("view", tmp_path / "a.glb", "-o", page) == 0
    assert capsys.readouterr().out.startswith(f"a → {page} (")


@pytest.fixture
def visited(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, bytes]]:
    """Addresses the browser was sent to, and what it found there; nobody waits."""
    found: list[tuple[str, bytes]] = []

    def visit(address: str) -> bool:
        with urllib.request.urlopen(address, timeout=60) as reply:
            found.append((address, reply.read()))
        return True

    monkeypatch.setattr("webbrowser.open", visit)
    monkeypatch.setattr(ViewerServer, "wait", lambda self: None)
    return found


def test_the_browser_is_sent_to_the_page(
    small: Rig, tmp_path: Path, visited: list[tuple[str, bytes]], capsys: pytest.CaptureFixture[str]
) -> None:
    em.write(tmp_path / "a.glb", small)
    assert run("view", tmp_path / "a.glb") == 0
    ((address, content),) = visited
    assert address in capsys.readouterr().out
    assert b"model-0.glb" in content


def test_every_run_has_the_usual_port(
    small: Rig,
    tmp_path: Path,
    visited: list[tuple[str, bytes]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """So that the browser finds again what it kept; a number is kept to, and 0 is a free one."""
    em.write(tmp_path / "a.glb", small)
    with serve_page(b"") as server:
        usual = server.port
    monkeypatch.setattr("elastomorph.viewer.server.USUAL_PORT", usual)
    for more in ((), (), ("--port", "0")):
        assert run("view", tmp_path / "a.glb", *more) == 0
    small.view(say=lambda words: None)
    ports = [urlsplit(address).port for address, _ in visited]
    assert [port == usual for port in ports] == [True, True, False, True]


def test_no_browser_and_json(
    small: Rig, tmp_path: Path, visited: list[tuple[str, bytes]], capsys: pytest.CaptureFixture[str]
) -> None:
    em.write(tmp_path / "a.glb", small)
    assert run("view", tmp_path / "a.glb", "--no-open", "--json") == 0
    address = json.loads(capsys.readouterr().out)["address"]
    assert address.startswith("http://127.0.0.1:")
    assert not visited


def test_a_report_is_served(tmp_path: Path, visited: list[tuple[str, bytes]]) -> None:
    (tmp_path / "report.html").write_text("<!doctype html><p>Table 1")
    assert run("view", tmp_path / "report.html") == 0
    assert visited[0][1] == b"<!doctype html><p>Table 1"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere.glb"], "nowhere.glb"),
        (["nowhere"], "nowhere"),
        (["nowhere.html"], "nowhere.html"),
        (["text.glb"], "text.glb, line 1: this is no glTF file"),
        (["text.html", "text.glb"], "by itself"),
        (["text.html", "-o", "other.html"], "by itself"),
        (["face.npz", "-o", "face.obj"], ".html"),
        (["face.npz", "-o", "page.html", "--port", "8000"], "not both"),
        (["face.npz", "face.npz"], "given twice"),
        (["face.npz", "--method", "linear", "--method", "linear"], "given twice"),
        (["face.npz", "--method", "bean"], "bean"),
        (["face.npz", "other.npz"], "only models of one neutral"),
        (["points.npz"], "no polygons"),
        (["face.npz", "--port", "70000"], "70000"),
    ],
)
def test_mistakes(
    arguments: list[str],
    message: str,
    small: Rig,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    em.write("face.npz", small)
    em.write("other.npz", straight("jawOpen"))
    em.write("points.npz", Rig(em.Mesh(np.eye(3)), {}))
    for name in ("text.glb", "text.html"):
        Path(name).write_text("text")
    before = sorted(tmp_path.iterdir())
    assert run("view", *arguments, "--no-open") == 1
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert message in said
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_when_asked(tmp_path: Path, number: signal.Signals) -> None:
    """Ctrl-C is how one leaves, not an error; until then the page is there."""
    (tmp_path / "report.html").write_text("a report")
    words = ("-m", "elastomorph", "view", "report.html", "--no-open", "--json")
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with started(*words, cwd=tmp_path, **pipes) as process:
        assert process.stdout is not None
        lines = [process.stdout.readline() for _ in range(3)]
        address = json.loads("".join(lines))["address"]
        with urllib.request.urlopen(address, timeout=60) as reply:
            assert reply.read() == b"a report"
        process.send_signal(number)
        _, said = process.communicate(timeout=60)
    assert process.returncode == (0 if number is signal.SIGINT else 128 + number)
    assert said == ""


def test_a_glb_of_others_is_bent_and_keeps_its_clips(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shapes_of = {"jawOpen": shapes()["jawOpen"]}
    rig = Rig(head(), {name: em.interpolate(head(), m, "linear") for name, m in shapes_of.items()})
    bare = write_foreign_glb(tmp_path / "bare.glb", rig)
    clips = write_foreign_glb(tmp_path / "clips.glb", rig, clips=True)
    page = tmp_path / "page.html"
    assert run("view", bare, "-o", page) == 0
    assert capsys.readouterr().err == ""
    bent = rig_in(written(page)[1][0], tmp_path).morphs["jawOpen"]
    assert bent.choice is not None
    assert len(bent.bends)
    for options in ((), ("--method", "auto")):
        assert run("view", clips, "-o", page, *options) == 0
        assert capsys.readouterr().err == ""
        shown = written(page)[1][0]
        assert len(rig_in(shown, tmp_path).morphs["jawOpen"].bends)
        (tmp_path / "shown.glb").write_bytes(shown)
        (clip,) = read_weight_clips(tmp_path / "shown.glb", rig.sliders)
        assert clip.name == "jawOpen"
        np.testing.assert_allclose(clip.weights[:, 0], clip.times, atol=1e-6)


@pytest.mark.parametrize("methods", [(), ("linear", "rotation", "beam:2")])
def test_a_character_is_read_once(
    small: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, methods: tuple[str, ...]
) -> None:
    """For all of its methods: with many targets, reading takes as long as finding paths."""
    character = write_foreign_glb(tmp_path / "face.glb", small)
    read: list[object] = []

    def counted(file: Any, placed: Any) -> Any:
        read.append(file.path)
        return read_primitives(file, placed)

    monkeypatch.setattr("elastomorph.io.gltf.reader.read_primitives", counted)
    named = [word for method in methods for word in ("--method", method)]
    assert run("view", character, *named, "-o", tmp_path / "page.html") == 0
    assert len(read) == 1
    assert len(written(tmp_path / "page.html")[1]) == max(1, len(methods))


def test_a_compressed_glb_of_ours_is_unpacked_for_the_page(small: Rig, tmp_path: Path) -> None:
    em.write(tmp_path / "face.glb", small, compress=True)
    page = tmp_path / "page.html"
    assert run("view", tmp_path / "face.glb", "-o", page) == 0
    shown = written(page)[1][0]
    (tmp_path / "shown.glb").write_bytes(shown)
    document, _ = chunks_of(tmp_path / "shown.glb")
    assert not any("compression" in name for name in document.get("extensionsUsed", []))
    back = rig_in(shown, tmp_path)
    assert back.names == small.names
    reach = 1e-4 * small.neutral.diameter
    np.testing.assert_allclose(back.neutral.vertices, small.neutral.vertices, atol=reach)
