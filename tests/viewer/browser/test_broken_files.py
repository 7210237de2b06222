"""Files that cannot be shown: an alert that says what to do, and the page as it was."""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING

import pytest
from faces import Faces, distances, glb
from visiting import COARSE, SMALL, Visit, empty_page, positions, settled, state, update, wait

if TYPE_CHECKING:
    from playwright.sync_api import Page


def glb_of(document: dict[str, object]) -> bytes:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text))
    return head + struct.pack("<I4s", len(text), b"JSON") + text


SPLATS = glb_of(
    {
        "asset": {"version": "2.0"},
        "extensionsRequired": ["KHR_gaussian_splatting"],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    }
)

# Name, content, what is said to be wrong, and what is said to do about it.
BROKEN: dict[str, tuple[str, bytes, str, str]] = {
    "empty": ("empty.glb", b"", "the file is empty", "Export it again"),
    "text": ("notes.glb", b"Meeting at nine.\n", "not a GLB", "elastomorph export"),
    "HTML": ("head.glb", b"<!DOCTYPE html><p>Sign in</p>", "HTML page", "elastomorph export"),
    "OBJ": (
        "head.obj",
        b"v 0 0 0\nv 1 0 0\nf 1 2 3\n",
        "alone opens GLB files",
        "elastomorph export",
    ),
    "FBX": (
        "head.fbx",
        b"Kaydara FBX Binary  \0",
        "elastomorph view head.fbx",
        "elastomorph export",
    ),
    "extension": ("small.glb", SPLATS, "KHR_gaussian_splatting", "Export it again without it"),
    "old": ("old.glb", glb_of({"asset": {"version": "1.0"}}), "glTF 1.0", "as glTF 2.0"),
    "JSON": ("things.gltf", b'{"things": []}', "no glTF", "Open a .glb"),
    "no mesh": ("bare.glb", glb_of({"asset": {"version": "2.0"}}), "mesh", "xport"),
}


def choose(page: Page, name: str, content: bytes) -> None:
    page.locator("input[type=file]").set_input_files(
        {"name": name, "mimeType": "", "buffer": content}
    )


def drop(page: Page, name: str, content: bytes) -> None:
    transfer = page.evaluate_handle(
        """([name, bytes]) => {
            const transfer = new DataTransfer();
            transfer.items.add(new File([new Uint8Array(bytes)], name));
            return transfer;
        }""",
        [name, list(content)],
    )
    for happening in ("dragenter", "dragover", "drop"):
        page.dispatch_event(".picture", happening, {"dataTransfer": transfer})


@pytest.mark.parametrize("put", [choose, drop])
def test_broken_files_are_explained(visit: Visit, faces: Faces, put) -> None:
    page = visit(faces.alone, size=SMALL)
    update(page, weights={"jawOpen": 0.6})
    before = state(page)
    for name, content, problem, remedy in BROKEN.values():
        put(page, name, content)
        message = page.get_by_role("alert").locator(".message").last
        message.get_by_text(name).wait_for()
        words = message.inner_text()
        assert problem.lower() in words.lower(), words
        assert remedy in words, words
        message.get_by_role("button", name="Dismiss").click()
    assert_as_before(page, faces, before)


def test_truncated_files_are_explained(visit: Visit, faces: Faces) -> None:
    """A file that was cut off anywhere says so, and never shows half a face."""
    page = visit(faces.alone, size=SMALL)
    update(page, weights={"jawOpen": 0.6})
    before, whole = state(page), glb(faces.rigs["linear"])
    for share in (0.00002, 0.001, 0.3, 0.9, 0.99999):
        choose(page, "head.glb", whole[: max(1, int(share * len(whole)))])
        message = page.get_by_role("alert").locator(".message")
        message.wait_for()
        assert message.inner_text().startswith("head.glb: ")
        assert "again" in message.inner_text() or "elastomorph export" in message.inner_text()
        page.keyboard.press("Escape")
    assert page.get_by_role("alert").locator(".message").count() == 0
    assert_as_before(page, faces, before)


def test_the_welcome_page_survives_a_broken_file(visit: Visit, faces: Faces) -> None:
    """And then shows the next one that is whole."""
    page = visit(empty_page())
    choose(page, *BROKEN["text"][:2])
    page.get_by_role("alert").get_by_text("notes.glb").wait_for()
    assert page.get_by_role("button", name="Open a GLB…").first.is_visible()
    drop(page, "head.glb", glb(faces.rigs["beam:2"]))
    wait(page, "elastomorph.models().length === 1")
    found = positions(page, 0, len(faces.neutral.vertices))
    assert distances(found, faces.neutral.vertices).max() < 1e-4 * faces.diameter


def test_a_file_of_the_same_vertices_joins(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    choose(page, "other.glb", glb(faces.rigs["linear"]))
    wait(page, "elastomorph.models().length === 2")
    now = state(page)
    assert now["arrangement"] == "side"
    assert now["shown"] == [0, 1]
    settled(page)
    assert page.locator(".model-name").all_inner_texts() == ["beam:2", "other"]


def test_a_file_of_other_vertices_stands_alone(visit: Visit, faces: Faces) -> None:
    page = visit(faces.together, size=SMALL)
    choose(page, "triangle.glb", triangle())
    wait(page, "elastomorph.models().length === 1")
    assert page.evaluate("elastomorph.models()[0].vertices") == 3
    assert state(page)["arrangement"] == "single"
    assert state(page)["weights"] == {}


def assert_as_before(page: Page, faces: Faces, before: dict[str, object]) -> None:
    assert state(page) == before
    found = positions(page, 0, len(faces.neutral.vertices))
    truth = faces.rigs["beam:2"].pose({"jawOpen": 0.6})
    assert distances(found, truth).max() < 1e-4 * faces.diameter


def triangle() -> bytes:
    """The smallest GLB of others: one triangle, without morph targets."""
    points = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    head = glb_of(
        {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [
                {
                    **{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                    **{"min": [0, 0, 0], "max": [1, 1, 0]},
                }
            ],
            "bufferViews": [{"buffer": 0, "byteLength": len(points)}],
            "buffers": [{"byteLength": len(points)}],
        }
    )
    whole = head + struct.pack("<I4s", len(points), b"BIN\0") + points
    return whole[:8] + struct.pack("<I", len(whole)) + whole[12:]
