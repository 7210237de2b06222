"""Files that a page sends are opened as the command opens them, and nothing is left of them."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import pytest
from asking import get, packed, post, send, told
from pages import read_back

import elastomorph as em
from elastomorph.rig import Rig
from elastomorph.viewer import ViewerServer, rig_scene, serve
from elastomorph.viewer.listening import Offer
from elastomorph.viewer.uploads import MOST_FILES, Uploads
from streams import wait

TRIANGLE = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
MOVED = b"v 0 0 0\nv 1 0 1\nv 0 1 0\nf 1 2 3\n"
FOLDER: dict[str, bytes | Path] = {"Ada/neutral.obj": TRIANGLE, "Ada/jawOpen.obj": MOVED}


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where temporary files go; a neighbour of theirs must stay as it is."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    (tmp_path / "neighbour.txt").write_text("mine")
    return folder


@pytest.fixture
def server(place: Path, stand_in: str, rig: Rig) -> ViewerServer:
    shelf: dict[str, Offer] = {}
    return serve(rig_scene(rig), 0, {"open": Uploads(shelf).service()}, shelf)


def left(place: Path) -> list[str]:
    return sorted(str(file.relative_to(place.parent)) for file in place.parent.rglob("*"))


UNTOUCHED = ["neighbour.txt", "temporary"]


def test_a_folder_of_meshes(server: ViewerServer, place: Path, tmp_path: Path) -> None:
    with server:
        found = send(server, FOLDER)
        scene = found["done"]["scene"]
        assert scene["title"] == "Ada"
        assert [model["name"] for model in scene["models"]] == ["Ada"]
        status, glb = get(server, scene["models"][0]["glb"])
        assert status == 200
        assert scene["services"] == {"open": "open", "methods": "opened-1/methods"}
        asked = told(*post(server, "opened-1/methods", b"{}"))
        assert [row["name"] for row in asked["done"]["rows"]] == ["jawOpen"]
    assert left(place) == UNTOUCHED
    assert read_back(glb, tmp_path).names == ("jawOpen",)
    assert found["says"][:2] == ["receiving neutral.obj, 1 of 2", "receiving jawOpen.obj, 2 of 2"]


def test_settings_among_them_count(server: ViewerServer, tmp_path: Path) -> None:
    settings = b'[methods]\njawOpen = "ease:2"\n'
    with server:
        done = send(server, {**FOLDER, "Ada/elastomorph.toml": settings})["done"]
        glb = get(server, done["scene"]["models"][0]["glb"])[1]
    assert read_back(glb, tmp_path)["jawOpen"].method == "ease R=2"


def test_settings_reach_for_nothing_else(server: ViewerServer, place: Path, tmp_path: Path) -> None:
    secret = tmp_path / "secret.json"
    secret.write_text("[[0, 1, 2]]")
    with server:
        for name in (str(secret), "../../../secret.json"):
            text = f'[character]\ncurves = "{name}"\n'.encode()
            problem = send(server, {**FOLDER, "Ada/elastomorph.toml": text})["problem"]
            assert "not among the files" in problem or "does not exist" in problem
            assert str(place) not in problem


@pytest.mark.parametrize("suffix", [".npz", ".glb", ".vrm"])
def test_rig_files(server: ViewerServer, rig: Rig, tmp_path: Path, suffix: str) -> None:
    file = tmp_path / "tip.glb"
    if suffix == ".npz":
        file = file.with_suffix(".npz")
    em.write(file, rig)
    with server:
        done = send(server, {f"tip{suffix}": file})["done"]
        glb = get(server, done["scene"]["models"][0]["glb"])[1]
    assert set(read_back(glb, tmp_path).names) == {"up", "plain"}


def test_only_the_last_few_are_kept(server: ViewerServer) -> None:
    with server:
        for _ in range(4):
            send(server, FOLDER)
        found = [get(server, f"opened-{number}/model-0.glb")[0] for number in (1, 2, 3, 4)]
    assert found == [404, 200, 200, 200]


@pytest.mark.parametrize(
    "name",
    ["../evil.obj", "a/../../evil.obj", "/etc/evil.obj", "a//b.obj", "./a.obj", "", ".."]
    + ["/".join("abcdefgh"), "x" * 200 + ".obj"],
)
def test_names_that_lead_elsewhere(server: ViewerServer, place: Path, name: str) -> None:
    with server:
        assert "rename it" in send(server, {"neutral.obj": TRIANGLE, name: MOVED})["problem"]
    assert left(place) == UNTOUCHED


@pytest.mark.parametrize(
    ("files", "problem"),
    [
        ({"a/x.obj": MOVED, "A/X.obj": TRIANGLE}, "two files are called"),
        ({"a.fbx": b"no", "b.fbx": b"no"}, "several rigs: a.fbx, b.fbx"),
        ({"Ada/notes.txt": b"no"}, "Ada"),
        ({"head.vrm": b"no"}, "head.vrm"),
        ({"head.fbx": b"Kaydara FBX Binary  \0"}, "head.fbx"),
        ({"head.usda": b"#usda 9.9"}, "head.usda"),
        ({"Ada/neutral.obj": TRIANGLE, "Ada/jaw.obj": b"v 0 0 x\n"}, "jaw.obj"),
        ({"Ada/neutral.obj": TRIANGLE, "Ada/jaw.obj": b"v 0 0 0\n"}, "jaw.obj"),
        ({f"{number}.obj": b"" for number in range(MOST_FILES + 1)}, "more than the 2,000"),
    ],
)
def test_what_cannot_be_opened_is_a_sentence(
    server: ViewerServer, place: Path, files: dict[str, bytes | Path], problem: str
) -> None:
    with server:
        told_ = send(server, files)["problem"]
    assert problem in told_
    assert str(place) not in told_
    assert left(place) == UNTOUCHED


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"{}\n",
        b'{"files": []}\n',
        b'{"files": [["a.obj", -1]]}\n',
        b'{"files": [["a.obj", 1], ["a.obj", 1]]}\nxx',
        b'{"files": [["a.obj", 99999999999999999999999]]}\nx',
        b'{"files": [["a.obj", 2]]}\nx',
        b'{"files": [["a.obj", 1]]}\nxx',
        b"x" * 2_000_000,
        b"[" * 100_000 + b"\n",
    ],
)
def test_streams_that_are_not_what_they_say(server: ViewerServer, place: Path, body: bytes) -> None:
    with server:
        problem = told(*post(server, "open", body))["problem"]
    assert "what was sent" in problem or "were sent" in problem
    assert left(place) == UNTOUCHED


def test_other_sites_send_nothing(server: ViewerServer, place: Path) -> None:
    with server:
        assert post(server, "open", packed(FOLDER), Origin="http://evil.example")[0] == 405
        assert post(server, "open", packed(FOLDER), Origin="null")[0] == 405
        assert post(server, "open", packed(FOLDER), Origin="")[0] == 405
    assert left(place) == UNTOUCHED


def test_too_much_is_refused_before_it_is_read(server: ViewerServer) -> None:
    with server:
        assert post(server, "open", b"", **{"Content-Length": str(3 << 30)})[0] == 413


def test_a_page_that_goes_away(server: ViewerServer, place: Path) -> None:
    """Half of the files: nothing is opened, and nothing is left of them."""
    import socket

    body = packed(FOLDER)
    head = (
        f"POST /{server.token}/open HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
        f"Origin: http://127.0.0.1:{server.port}\r\nContent-Length: {len(body)}\r\n\r\n"
    )
    with server:
        with socket.create_connection(("127.0.0.1", server.port)) as connection:
            connection.sendall(head.encode() + body[:-5])
        wait(lambda: not any(place.iterdir()))
        assert left(place) == UNTOUCHED
        assert send(server, FOLDER)["done"]


def test_no_room_for_them(server: ViewerServer, monkeypatch: pytest.MonkeyPatch) -> None:
    usage = type("Usage", (), {"free": 1_000_000})
    monkeypatch.setattr("elastomorph.viewer.uploads.shutil.disk_usage", lambda _: usage)
    with server:
        assert "only 1 MB are free" in send(server, FOLDER)["problem"]


@pytest.mark.realdata
def test_an_fbx_of_others(server: ViewerServer, data_dir: Path) -> None:
    file = data_dir / "facecap" / "FaceCapHeadGeneric.fbx"
    with server:
        scene = send(server, {file.name: file})["done"]["scene"]
        document = get(server, scene["models"][0]["glb"])[1]
    length = int.from_bytes(document[12:16], "little")
    names = json.loads(document[20 : 20 + length])["meshes"][0]["extras"]["targetNames"]
    assert len(set(names)) >= 52
