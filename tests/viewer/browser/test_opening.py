"""Files and folders that the running command opens for its page."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from faces import Faces, distances, glb
from serving import NAMES, serving, write_folder
from visiting import COARSE, SMALL, Visit, positions, state, update, wait

import elastomorph as em
from character_makers import make
from elastomorph.rig import Rig
from elastomorph.viewer import ViewerServer
from needs import extra

if TYPE_CHECKING:
    from playwright.sync_api import Page

FILES = "input[type=file]"
# A folder as Chromium hands it out: entries that are asked for their content, a part at a time.
DROP_FOLDER = """files => {
    const read = ([path, text]) => ({
        isFile: true, isDirectory: false, fullPath: '/' + path,
        file: found => found(new File([text], path.split('/').pop())),
    });
    let left = [files.slice(0, 2), files.slice(2), []];
    const folder = {
        isFile: false, isDirectory: true, fullPath: '/' + files[0][0].split('/')[0],
        createReader: () => ({readEntries: found => found(left.shift().map(read))}),
    };
    const event = new Event('drop', {bubbles: true, cancelable: true});
    event.dataTransfer = {
        types: ['Files'], files: [], items: [{webkitGetAsEntry: () => folder}],
    };
    document.querySelector('.picture').dispatchEvent(event);
}"""


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_folder(tmp_path_factory.mktemp("rigs") / "Ada")


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ViewerServer]:
    """The command shows some other face: a tetrahedron."""
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    tip = em.Mesh(vertices, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    up = tip.with_vertices(tip.vertices * [1, 1, 2])
    file = tmp_path / "tip.npz"
    em.write(file, Rig(tip, {"up": em.interpolate(tip, up, "linear")}))
    with serving(file) as started:
        yield started


def opened(page: Page, title: str) -> None:
    wait(page, f"document.querySelector('header h1').textContent === '{title}'")


def test_a_folder_that_is_dropped(visit: Visit, server: ViewerServer, meshes: Path) -> None:
    page = visit(server.address, size=SMALL, **COARSE)
    files = [[f"Ada/{file.name}", file.read_text()] for file in sorted(meshes.iterdir())]
    page.evaluate(DROP_FOLDER, [*files, ["Ada/.DS_Store", "x"]])
    opened(page, "Ada")
    update(page, weights={"jawOpen": 1}, t=0.5)
    truth = em.read_rig(meshes)["jawOpen"].at(0.5)
    diameter = em.read(meshes / "neutral.obj").diameter
    assert distances(positions(page, 0, len(truth)), truth).max() < 1e-4 * diameter
    page.get_by_role("tab", name="Methods").click()
    page.get_by_role("row", name="mouthSmile_L").wait_for()
    assert page.get_by_role("button", name="Save").is_disabled()


def test_a_folder_that_is_chosen(visit: Visit, server: ViewerServer, meshes: Path) -> None:
    page = visit(server.address, size=SMALL, **COARSE)
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Open a folder of meshes").click()
    chooser.value.set_files(str(meshes))
    opened(page, "Ada")
    names = {"targets": len(NAMES)}
    assert page.evaluate("elastomorph.models()[0].vertices") >= 5000, names


def test_meshes_that_are_chosen_one_by_one(
    visit: Visit, server: ViewerServer, meshes: Path
) -> None:
    page = visit(server.address, size=SMALL, **COARSE)
    page.locator(FILES).set_input_files([meshes / "neutral.obj", meshes / "jawOpen.obj"])
    wait(page, "elastomorph.models()[0].vertices > 5000")


@pytest.mark.parametrize("suffix", [".usda", ".vrm"])
def test_files_of_our_exporters(
    visit: Visit, server: ViewerServer, faces: Faces, tmp_path: Path, suffix: str
) -> None:
    rig = faces.rigs["beam:2"].only(["jawOpen"])
    file = tmp_path / f"head{suffix}"
    if suffix == ".vrm":
        file.write_bytes(glb(rig))
    else:
        extra("pxr", "usd")
        em.write(file, rig)
    page = visit(server.address, size=SMALL, **COARSE)
    page.locator(FILES).set_input_files(file)
    opened(page, "head")
    update(page, weights={"jawOpen": 1}, t=0.5)
    truth = rig.pose({"jawOpen": 0.5})
    error = distances(positions(page, 0, len(truth)), truth).max()
    assert error < 2e-3 * faces.diameter  # USD holds in-betweens of the path


@pytest.mark.parametrize("name", ["vrm0", "vrm1", "placed-files"])
def test_characters_of_others(
    visit: Visit, server: ViewerServer, tmp_path: Path, name: str
) -> None:
    """Faces of several meshes on a skeleton; of a .gltf with the buffers beside it."""
    folder = tmp_path / name
    folder.mkdir()
    file = make(name, folder)
    page = visit(server.address, size=SMALL, **COARSE)
    page.locator(FILES).set_input_files(sorted(folder.iterdir()))
    opened(page, file.stem)
    rig = em.read_rig(file)
    update(page, weights={"jawOpen": 1})
    assert page.evaluate("elastomorph.readout().targets") >= 1
    assert page.evaluate("elastomorph.models()[0].vertices") >= len(rig.neutral.vertices)


@pytest.mark.realdata
def test_the_fbx_of_others(visit: Visit, server: ViewerServer, data_dir: Path) -> None:
    extra("ufbx", "fbx")
    page = visit(server.address, size=SMALL, **COARSE)
    page.locator(FILES).set_input_files(data_dir / "facecap" / "FaceCapHeadGeneric.fbx")
    opened(page, "FaceCapHeadGeneric")


def test_problems_are_told_and_the_face_stays(visit: Visit, server: ViewerServer) -> None:
    page = visit(server.address, size=SMALL, **COARSE)
    before = state(page)
    for name, content, problem in (
        ("head.fbx", b"Kaydara FBX Binary  \0", "head.fbx"),
        ("head.vrm", b"no", "head.vrm"),
        ("neutral.obj", b"v 0 0 x\n", "neutral.obj"),
    ):
        page.locator(FILES).set_input_files({"name": name, "mimeType": "", "buffer": content})
        message = page.get_by_role("alert").locator(".message").last
        message.get_by_text(problem).wait_for()
        assert "/tmp" not in message.inner_text()
        message.get_by_role("button", name="Dismiss").click()
    assert state(page) == before
    assert page.evaluate("elastomorph.models()[0].name") == "tip"


def test_more_than_a_page_may_send(visit: Visit, server: ViewerServer) -> None:
    page = visit(server.address, size=SMALL, **COARSE)
    page.evaluate(DROP_FOLDER, [[f"Ada/{number}.obj", "v"] for number in range(2100)])
    page.get_by_role("alert").get_by_text("more than a page may send").wait_for()


def test_a_page_alone_says_which_command(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, size=SMALL)
    assert page.get_by_role("button", name="Open a folder of meshes").count() == 0
    page.evaluate(DROP_FOLDER, [["Ada/neutral.obj", "v 0 0 0"]])
    page.get_by_role("alert").get_by_text('Run "elastomorph view Ada"').wait_for()


def test_another_site_cannot_send(visit: Visit, server: ViewerServer, faces: Faces) -> None:
    """A page of another origin that knows the address, which it cannot."""
    visit.forgiven = server.address
    visits = visit(faces.alone, size=SMALL)
    body = json.dumps({"files": [["a.obj", 0]]})
    request = visits.context.request
    for origin in ("http://evil.example", "null"):
        answer = request.post(f"{server.address}open", data=body, headers={"Origin": origin})
        assert answer.status == 405
