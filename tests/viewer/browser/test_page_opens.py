"""The page opens from disk, served and in a notebook, and never looks elsewhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from faces import Faces
from visiting import COARSE, Visit, empty_page, positions, settled, wait

from elastomorph.viewer import page as pages
from elastomorph.viewer import serve
from elastomorph.viewer.notebook import notebook_html

WELCOME = "Shows faces whose expressions move along curved, elastic paths"


def test_from_disk(visit: Visit, faces: Faces) -> None:
    page = visit(faces.together, **COARSE)
    found = page.evaluate("elastomorph.models()")
    assert [model["name"] for model in found] == list(faces.rigs)
    assert all(model["vertices"] >= len(faces.neutral.vertices) for model in found)
    assert page.title() == "Three methods – elastomorph"
    assert page.get_by_role("heading", name="Three methods").is_visible()
    assert not page.get_by_text(WELCOME).is_visible()


def test_served(visit: Visit, faces: Faces) -> None:
    with serve(faces.alone) as server:
        page = visit(server.address)
        shown = positions(page, 0, len(faces.neutral.vertices))
        np.testing.assert_allclose(shown, faces.neutral.vertices, atol=1e-4 * faces.diameter)
        assert page.evaluate("performance.getEntriesByType('resource').map(e => e.name)") == [
            server.address + "model-0.glb"
        ]


def test_the_secret_is_needed(visit: Visit, faces: Faces) -> None:
    """Without it, or by a name that somebody else's server gave this machine, there is nothing."""
    with serve(faces.alone) as server:
        page = visit(server.address)
        ask = page.context.request.get
        root = f"http://127.0.0.1:{server.port}/"
        assert ask(server.address).status == 200
        for wrong in (root, root + "index.html", root + "model-0.glb", root + "x" * 32 + "/"):
            assert ask(wrong).status == 404
        assert ask(server.address, headers={"Host": f"evil.example:{server.port}"}).status == 404


def test_another_page_gets_nothing_from_the_server(visit: Visit, faces: Faces) -> None:
    """Even one that has found out the address: reading and framing it are both refused."""
    with serve(faces.alone) as server:
        stranger = visit.browser.new_context()
        page = stranger.new_page()
        page.set_content(f'<iframe src="{server.address}"></iframe>')
        script = "address => fetch(address).then(() => 'read', () => 'refused')"
        assert page.evaluate(script, server.address + "model-0.glb") == "refused"
        frame = page.frames[1]
        frame.wait_for_load_state()
        assert frame.url.startswith("chrome-error:") or not frame.query_selector("#viewer")
        stranger.close()


def test_in_a_notebook(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """There the page is in a frame that may not use storage, cookies or the page around it."""
    file = tmp_path / "notebook.html"
    shown = notebook_html(faces.rigs["beam:2"])
    around = '<!doctype html><meta charset="utf-8" /><title>notebook</title>'
    file.write_text(around + shown, encoding="utf-8")
    page = visit.blank(file.as_uri())
    frame = page.frames[1]
    wait(frame, "window.elastomorph")
    frame.evaluate("elastomorph.ready")
    settled(frame)
    assert frame.evaluate("elastomorph.models().length") == 1
    assert frame.locator(".picture canvas").is_visible()


def test_without_a_face_it_says_what_it_is_for(visit: Visit) -> None:
    page = visit(empty_page())
    assert page.get_by_text(WELCOME).is_visible()
    assert page.evaluate("elastomorph.models()") == []
    with page.expect_file_chooser() as chosen:
        page.locator(".welcome").get_by_role("button", name="Open a GLB").click()
    assert chosen.value.is_multiple()


def test_without_3d_it_says_what_to_do(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """Where the browser draws no WebGL 2 there is an alert, not an empty page."""
    visit.forgiven = "Error creating WebGL context"
    page_text = pages.shipped_page()
    assert "<head>" in page_text
    refusing = "<script>HTMLCanvasElement.prototype.getContext = () => null</script>"
    file = tmp_path / "no-webgl.html"
    file.write_text(page_text.replace("<head>", f"<head>{refusing}"), encoding="utf-8")
    page = visit.blank(file.as_uri())
    words = page.get_by_role("alert").text_content() or ""
    assert "WebGL 2" in words
    assert "settings" in words
