"""Scans as files hold them: what is mended, what is left out, and their colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import CaptureError, ElastomorphWarning, FormatError
from needs import extra

extra("embreex", "capture")
cv2 = extra("cv2", "capture")

from elastomorph.capturing.scans.scans import read_scan, require_one_head  # noqa: E402
from elastomorph.io.scan_colours import dressed  # noqa: E402


def ball(rows: int = 12, radius: float = 1.0, middle=(0.0, 0.0, 0.0)) -> em.Mesh:
    """A ball of triangles that face outward."""
    up, around = np.meshgrid(
        np.linspace(-1.5, 1.5, rows), np.linspace(0, 2 * np.pi, 2 * rows, endpoint=False),
        indexing="ij",
    )  # fmt: skip
    points = np.stack(
        [np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=-1
    )
    number = np.arange(points[..., 0].size).reshape(up.shape)
    right = np.roll(number, -1, axis=1)
    quads = np.stack([number[:-1], right[:-1], right[1:], number[1:]], axis=-1).reshape(-1, 4)
    return em.Mesh(points.reshape(-1, 3) * radius + middle, quads)


def joined(*meshes: em.Mesh) -> em.Mesh:
    starts = np.cumsum([0, *(len(own.vertices) for own in meshes)])
    return em.Mesh(
        np.concatenate([own.vertices for own in meshes]),
        np.concatenate(
            [own.faces.triangles() + at for own, at in zip(meshes, starts, strict=False)]
        ),
    )


def test_what_is_cut_apart_is_joined() -> None:
    """As files do that repeat a vertex at every corner."""
    whole = ball()
    corners = whole.faces.triangles()
    apart = em.Mesh(whole.vertices[corners.ravel()], np.arange(corners.size).reshape(-1, 3))
    found = read_scan(apart)
    assert len(found.surface.vertices) == len(whole.vertices)
    assert found.piece.max() == 0
    assert len(found.surface.triangles) == len(corners)


def test_triangles_twice_or_without_area_and_crumbs_are_left_out() -> None:
    whole = ball()
    corners = whole.faces.triangles()
    worse = em.Mesh(
        np.concatenate([whole.vertices, [[5.0, 5, 5], [5.01, 5, 5], [5, 5.01, 5]]]),
        np.concatenate(
            [
                corners,
                corners[:20, [1, 2, 0]],
                [[3, 3, 4]],
                [[len(whole.vertices) + i for i in range(3)]],
            ]
        ),
    )
    found = read_scan(worse)
    assert len(found.surface.triangles) == len(corners)


@pytest.mark.parametrize("turned", [False, True])
def test_triangles_show_their_outside(turned: bool) -> None:
    whole = ball()
    corners = whole.faces.triangles()
    found = read_scan(em.Mesh(whole.vertices, corners[:, ::-1] if turned else corners))
    assert found.inside_out == turned
    middles = found.surface.vertices[found.surface.triangles].mean(axis=1)
    assert (np.einsum("ij,ij->i", found.surface.face_normals, middles) > 0).all()


def test_two_of_a_size_are_two_heads_and_a_hat_is_none() -> None:
    with pytest.raises(CaptureError, match="two pieces of like size"):
        require_one_head(read_scan(joined(ball(), ball(middle=(4.0, 0, 0)))))
    require_one_head(read_scan(joined(ball(), ball(radius=0.4, middle=(4.0, 0, 0)))))
    require_one_head(read_scan(joined(ball(), ball(radius=0.9))))


def coloured(folder: Path, image: str = "skin.png") -> Path:
    """A square of two triangles, red to the left and green to the right."""
    pixels = np.zeros((8, 8, 3), dtype=np.uint8)
    pixels[:, :4, 2], pixels[:, 4:, 1] = 255, 255
    cv2.imwrite(str(folder / "skin.png"), pixels)
    (folder / "scan.mtl").write_text(f"newmtl skin\nmap_Kd {image}\n")
    (folder / "scan.obj").write_text(
        "mtllib scan.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        "usemtl skin\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
    )
    return folder / "scan.obj"


def test_colours_of_an_obj_are_those_of_its_image(tmp_path: Path) -> None:
    scan = read_scan(coloured(tmp_path))
    assert scan.skin is not None
    at = np.array([[[0.1, 0.45, 0.45], [0.8, 0.1, 0.1]]])
    triangles = np.zeros((1, 2), dtype=np.int64)
    places = np.einsum(
        "hwk,kj->hwj", at, scan.surface.vertices[scan.surface.triangles[0]]
    )[0]  # fmt: skip
    shown = scan.skin.at(triangles, at)[0]
    for place, colour in zip(places, shown, strict=True):
        assert colour.tolist() == ([255, 0, 0] if place[0] < 0.4 else [0, 255, 0])
    assert read_scan(tmp_path / "scan.obj", texture=False).skin is None


SQUARE = "v 0 0 0 {}\nv 1 0 0 {}\nv 1 1 0 {}\nv 0 1 0 {}\nf 1 2 3\nf 1 3 4\n"
RED, GREEN, BLUE = "1 0 0", "0 1 0", "0 0 1"


def test_colours_of_vertices_are_mixed_between_them(tmp_path: Path) -> None:
    (tmp_path / "scan.obj").write_text(SQUARE.format(RED, GREEN, BLUE, RED))
    scan = read_scan(tmp_path / "scan.obj")
    assert scan.skin is not None
    at = np.array([[[0.5, 0.3, 0.2], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]])
    shown = scan.skin.at(np.array([[0, 0, -1]]), at)[0]
    # Of the first triangle, whichever way round it now is, the colour is that of the place.
    corners = scan.surface.vertices[scan.surface.triangles[0]]
    of = {(0, 0): [255, 0, 0], (1, 0): [0, 255, 0], (1, 1): [0, 0, 255]}
    colours = np.array([of[int(x), int(y)] for x, y, _ in corners])
    np.testing.assert_allclose(shown[0], at[0, 0] @ colours, atol=1)
    np.testing.assert_array_equal(shown[1], colours[2])
    np.testing.assert_array_equal(shown[2], 0)
    kept = scan.only(np.array([False, True])).skin
    assert kept is not None
    np.testing.assert_array_equal(kept.corners, scan.skin.corners[1:])
    assert read_scan(tmp_path / "scan.obj", texture=False).skin is None


def test_an_image_comes_before_colours_of_vertices(tmp_path: Path) -> None:
    """And these are shown where there is no image."""
    text = coloured(tmp_path).read_text().replace("f 1/1 3/3", "usemtl bare\nf 1/1 3/3")
    lines = [line + " 0 0 1" if line.startswith("v ") else line for line in text.splitlines()]
    (tmp_path / "scan.obj").write_text("\n".join(lines))
    scan = read_scan(tmp_path / "scan.obj")
    assert scan.skin is not None
    middle = np.full((1, 2, 3), 1 / 3)
    shown = scan.skin.at(np.array([[0, 1]]), middle)[0]
    assert shown[0, 2] == 0
    assert shown[1].tolist() == [0, 0, 255]


def test_one_colour_everywhere_is_none(tmp_path: Path) -> None:
    """As programs write grey for every vertex, in which nothing can be followed."""
    (tmp_path / "scan.obj").write_text(SQUARE.format(*["0.7 0.7 0.7"] * 4))
    assert read_scan(tmp_path / "scan.obj").skin is None


def test_colours_of_a_glb_are_those_of_its_image(tmp_path: Path) -> None:
    mesh = dressed(em.read(coloured(tmp_path)))
    from_obj = read_scan(tmp_path / "scan.obj")
    em.write(tmp_path / "scan.glb", em.Rig(mesh, {}))
    from_glb = read_scan(tmp_path / "scan.glb")
    at = np.array([[[0.1, 0.45, 0.45], [0.8, 0.1, 0.1], [0.2, 0.7, 0.1], [0.3, 0.3, 0.4]]])
    triangles = np.array([[0, 0, 1, 1]])
    shown = [scan.skin.at(triangles, at) for scan in (from_obj, from_glb) if scan.skin]
    np.testing.assert_array_equal(*shown)


def test_colours_of_a_ply_are_those_of_its_image(tmp_path: Path) -> None:
    from_obj = read_scan(coloured(tmp_path))
    corners = "0 0 1 0 1 1", "0 0 1 1 0 1"
    (tmp_path / "scan.ply").write_text(
        "ply\nformat ascii 1.0\ncomment TextureFile skin.png\nelement vertex 4\n"
        "property float x\nproperty float y\nproperty float z\nelement face 2\n"
        "property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n"
        f"0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 {corners[0]}\n3 0 2 3 6 {corners[1]}\n"
    )
    at = np.array([[[0.1, 0.45, 0.45], [0.8, 0.1, 0.1], [0.2, 0.7, 0.1], [0.3, 0.3, 0.4]]])
    shown = [
        scan.skin.at(np.array([[0, 0, 1, 1]]), at)
        for scan in (from_obj, read_scan(tmp_path / "scan.ply"))
        if scan.skin
    ]
    np.testing.assert_array_equal(*shown)


def test_an_image_that_is_missing_is_told(tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match=r"gone\.png.*put the image beside the scan"):
        read_scan(coloured(tmp_path, "gone.png"))
    (tmp_path / "scan.mtl").unlink()
    with pytest.warns(ElastomorphWarning, match="no colours"):
        assert read_scan(tmp_path / "scan.obj").skin is None


def test_what_is_no_scan_is_told(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="a scan is a file"):
        read_scan(tmp_path / "scan.jpg")
