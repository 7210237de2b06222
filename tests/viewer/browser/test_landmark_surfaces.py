"""On a template a click finds a vertex, on a scan a point of its surface."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from placing import NAMES, active, click, opened, saved
from visiting import Visit

import elastomorph as em
from elastomorph.capturing.landmarks import Landmarks, read_landmarks
from elastomorph.model.mesh import FaceLabels, UVMap
from elastomorph.viewer.landmarks import landmark_task, serve_landmarks
from small_head import head, landmarks

if TYPE_CHECKING:
    from playwright.sync_api import Page

SIDE = 7


def roof() -> em.Mesh:
    """(7, 5) vertices at whole x and y; its ridge along y is towards the viewer."""
    x, y = np.meshgrid(np.arange(SIDE), np.arange(5), indexing="ij")
    vertices = np.stack([x, y, 3.0 - abs(x - 3.0)], axis=-1).reshape(-1, 3)
    number = np.arange(SIDE * 5).reshape(SIDE, 5)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    return em.Mesh(vertices, np.stack(corners, axis=-1).reshape(-1, 4))


def pixels(page: Page) -> NDArray[np.float64]:
    """(H, W, 3) of the picture alone."""
    page.mouse.move(2, 2)
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    shot = page.screenshot(clip=page.locator(".picture").bounding_box())
    with Image.open(io.BytesIO(shot)) as image:
        return np.asarray(image.convert("RGB")).astype(float)


def frame(page: Page) -> tuple[float, float, float]:
    """Where (0, 0) of the roof is on the page, and CSS pixels a unit, by its outline."""
    box = page.locator(".picture").bounding_box()
    assert box is not None
    shown = pixels(page)
    inside = np.abs(shown - shown[2, 2]).max(axis=-1) > 24
    columns, rows = np.flatnonzero(inside.any(axis=0)), np.flatnonzero(inside.any(axis=1))
    scale = (columns[-1] + 1 - columns[0]) / (SIDE - 1)
    assert (rows[-1] + 1 - rows[0]) / 4 == pytest.approx(scale, rel=0.02)
    return box["x"] + columns[0], box["y"] + rows[-1] + 1, scale


@contextmanager
def roof_page(visit: Visit, folder: Path) -> Iterator[Page]:
    """The page with the roof as its template."""
    em.write(folder / "roof.obj", roof())
    task = landmark_task(template=folder / "roof.obj")
    with serve_landmarks(task, folder / "landmarks.json") as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, "roof.obj")
        yield page


def test_the_vertex_that_is_nearest(visit: Visit, tmp_path: Path) -> None:
    with roof_page(visit, tmp_path) as page:
        left, bottom, scale = frame(page)
        rng = np.random.default_rng(5)
        expected = dict(zip(NAMES, rng.permutation(5 * SIDE).tolist(), strict=False))
        for name, vertex in expected.items():
            at = np.array(divmod(vertex, 5)) + rng.uniform(-0.3, 0.3, 2)
            assert active(page) == name
            inside = np.clip(at, 0.02, [SIDE - 1.02, 3.98])
            click(page, np.array([left, bottom]) + scale * inside * [1, -1])
        saved(page)
    assert read_landmarks(tmp_path / "landmarks.json").vertices == expected


def test_a_point_of_a_scan(visit: Visit, tmp_path: Path) -> None:
    """Anywhere on the surface, in the scan's own coordinates, however far they are from zero."""
    far = np.array([40_000.0, -7_000.0, 1_500.0])
    em.write(tmp_path / "scan.ply", roof().with_vertices(roof().vertices + far))
    with serve_landmarks(
        landmark_task([tmp_path / "scan.ply"]), tmp_path / "landmarks.json"
    ) as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, "scan.ply")
        left, bottom, scale = frame(page)
        for at in ((1.37, 2.61), (4.9, 0.4)):
            click(page, np.array([left, bottom]) + scale * np.array(at) * [1, -1])
        saved(page)
    found = read_landmarks(tmp_path / "landmarks.json").points["scan.ply"]
    assert list(found) == list(NAMES[:2])
    for point, (x, y) in zip(found.values(), ((1.37, 2.61), (4.9, 0.4)), strict=True):
        on_roof = np.array(point) - far
        assert on_roof[:2] == pytest.approx((x, y), abs=0.02)
        assert on_roof[2] == pytest.approx(3 - abs(on_roof[0] - 3), abs=2e-3)


def test_it_turns_with_what_is_taken_hold_of(visit: Visit, tmp_path: Path) -> None:
    """A vertex that is dragged stays under the pointer, while all else goes round it."""
    with roof_page(visit, tmp_path) as page:
        left, bottom, scale = frame(page)
        before = pixels(page)
        x, y = left + scale, bottom - 2 * scale  # of the vertex at (1, 2)
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 60, y, steps=6)
        page.mouse.up()
        assert (np.abs(pixels(page) - before).max(axis=-1) > 24).mean() > 0.02
        page.mouse.click(x, y)
        saved(page)
        assert read_landmarks(tmp_path / "landmarks.json").vertices == {NAMES[0]: 7}
        page.keyboard.press("Delete")
        page.keyboard.press("1")
        inner = np.s_[6:-6, 6:-6]  # without the ring of the focus
        assert (np.abs(pixels(page) - before)[inner].max(axis=-1) > 24).mean() < 1e-3


def test_it_is_found_again_as_it_was_left(visit: Visit, tmp_path: Path) -> None:
    """Whether or not somebody has moved it."""
    for name in ("one.obj", "two.obj"):
        em.write(tmp_path / name, roof())
    task = landmark_task([tmp_path / "one.obj", tmp_path / "two.obj"])
    with serve_landmarks(task, tmp_path / "landmarks.json") as server:
        page = visit.blank(server.address, size=(1100, 760))
        for moves in ("", "+++"):
            opened(page, "one.obj")
            for key in moves:
                page.keyboard.press(key)
            before = pixels(page)
            page.keyboard.press("]")
            opened(page, "two.obj")
            page.keyboard.press("[")
            opened(page, "one.obj")
            assert (np.abs(pixels(page) - before).max(axis=-1) > 24).mean() < 1e-3


def test_the_built_in_head_needs_no_clicks(visit: Visit, tmp_path: Path) -> None:
    with serve_landmarks(landmark_task(template="built-in"), tmp_path / "landmarks.json") as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, "built-in")
        assert page.get_by_text("15 of 15 points").is_visible()
        assert active(page) is None
        assert page.get_by_role("alert").get_by_text("Left and right").count() == 0


def test_a_mirrored_scan_is_noticed(visit: Visit, tmp_path: Path) -> None:
    """The points of a face on its mirror image: left and right cannot both be the subject's."""
    mesh = head()
    known = landmarks()
    mirrored = mesh.vertices * [-1, 1, 1]
    em.write(tmp_path / "scan.ply", mesh.with_vertices(mirrored))
    points = {"scan.ply": {name: tuple(mirrored[vertex]) for name, vertex in known.items()}}
    task = landmark_task([tmp_path / "scan.ply"], known=em_landmarks(points))
    with serve_landmarks(task, tmp_path / "landmarks.json") as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, "scan.ply")
        words = page.get_by_role("alert").get_by_text("Left and right").inner_text()
        assert "the surface is mirrored" in words
        assert "Right jaw, Left jaw" in words


def test_a_scan_shows_its_texture(visit: Visit, tmp_path: Path) -> None:
    """Its left half is red, its right half blue; T shows the clay below."""
    image = np.zeros((4, 8, 3), np.uint8)
    image[:, :4, 0], image[:, 4:, 2] = 255, 255
    Image.fromarray(image).save(tmp_path / "skin.png")
    mesh = roof()
    uv = UVMap(mesh.vertices[:, :2] / [6, 4], mesh.faces.indices)
    skin = FaceLabels(("skin",), np.zeros(len(mesh.faces), np.int32))
    textured = em.Mesh(mesh.vertices, mesh.faces, uv, skin, material_library="scan.mtl")
    em.write(tmp_path / "scan.obj", textured)
    (tmp_path / "scan.mtl").write_text("newmtl skin\nmap_Kd skin.png\n")
    with serve_landmarks(
        landmark_task([tmp_path / "scan.obj"]), tmp_path / "landmarks.json"
    ) as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, "scan.obj")
        shown = pixels(page)
        height, width, _ = shown.shape
        left, right = shown[height // 2, width // 3], shown[height // 2, 2 * width // 3]
        assert left[0] > 150 > 40 > left[2]
        assert right[2] > 150 > 40 > right[0]
        page.keyboard.press("t")
        clay = pixels(page)[height // 2, [width // 3, 2 * width // 3]]
        assert (clay[:, 0] > clay[:, 2]).all()


def em_landmarks(points: dict[str, dict[str, tuple[float, ...]]]) -> Landmarks:
    return Landmarks(points=points)
