"""The report of a capture shows what was measured, and draws poses where their photographs are."""

from __future__ import annotations

import json
import re
from base64 import b64decode
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from parsed_page import Element, parsed
from small_capture import SIZE, WALL, camera, capture, template

from elastomorph.capturing.work.captured import Captured
from elastomorph.capturing.work.registered import Registered
from elastomorph.errors import FileError, FormatError
from needs import MODULES, extra

extra("embreex", "capture")
cv2 = extra("cv2", "capture")

from elastomorph.report.capture import (  # noqa: E402  # noqa: E402  # noqa: E402
    Trust,
    beside,
    camera_picture,
    capture_page,
    confidence_colours,
    duration,
    findings,
    frontal,
    headline,
    pose_picture,
    vertex_groups,
    write_capture_report,
    write_register_report,
)

AXE = MODULES / "axe-core" / "axe.min.js"


@pytest.fixture(scope="module")
def captured(tmp_path_factory: pytest.TempPathFactory) -> Captured:
    return capture(tmp_path_factory.mktemp("photographs"))


@pytest.fixture(scope="module")
def page(captured: Captured) -> str:
    return capture_page(captured, name="Ada", unit="cm", call="elastomorph capture photos")


@pytest.fixture(scope="module")
def root(page: str) -> Element:
    return parsed(page)


def table_of(root: Element, caption: str) -> list[list[str]]:
    """The cells of a table, by the beginning of its caption, row by row."""
    (found,) = (each for each in root.all("table") if each.one("caption").text.startswith(caption))
    return [[cell.text for cell in row.all("th", "td")] for row in found.all("tr")]


def test_sections_are_in_the_order_of_the_work(root: Element) -> None:
    assert [each.text for each in root.all("h2")] == [
        "What was captured",
        "Cameras",
        "Photograph by photograph",
        "Surface and correspondence",
        "Pose by pose",
        "What can be trusted",
        "How long it took",
    ]
    assert root.one("h1").text == "Ada"


def test_photographs_and_why_some_are_rejected(root: Element) -> None:
    rows = table_of(root, "Photographs of each pose")
    assert rows[1] == ["rest", "2 of 3", "1,234", "0.375", "0.500 (1.jpg)"]
    assert rows[2][0] == "long & <b>"
    rejected = table_of(root, "Photographs that are not used")
    assert rejected[1:] == [
        ["2.jpg", "rest", "it shows <nothing>"],
        ["2.jpg", "long & <b>", "it shows <nothing>"],
    ]


def test_surface_and_correspondence_are_apart(root: Element) -> None:
    surface = table_of(root, "Points of the surface")
    skin = table_of(root, "Skin of the neutral")
    assert surface == [
        ["Pose", "Points", "Median", "95 % below"],
        ["rest", "1,200", "0.030", "0.110"],
        ["long & <b>", "1,200", "0.030", "0.110"],
    ]
    assert skin[0] == ["Pose", "Matches", "Median", "95 % below",
                       "Vertices in 4 photographs or more"]  # fmt: skip
    assert skin[1:] == [["long & <b>", "900", "0.420", "1.230", "87.5\u00a0%"]]
    headings = [each.text for each in root.all("h3")]
    assert headings.index("Correspondence") < headings.index("Surface")
    assert table_of(root, "How far points of the still part")[1] == ["long & <b>", "0.340", "77"]


def test_where_nothing_is_known_of_correspondence_it_is_said(captured: Captured) -> None:
    figures = json.loads(json.dumps(captured.figures))
    del figures["poses"]["long & <b>"]["correspondence"]
    text = parsed(capture_page(replace(captured, figures=figures))).text
    assert "Nothing was measured of it: there is no pose beside the neutral." in text


def test_the_list_holds_all_that_are_flagged(captured: Captured, page: str) -> None:
    (packed,) = re.findall(r'href="data:application/json;base64,([^"]+)" download', page)
    listed = json.loads(b64decode(packed))
    assert listed["below"] == 0.5
    for pose, mesh in captured.poses.items():
        found = sorted(listed["doubtful"][pose] + listed["unseen"][pose])
        assert found == np.flatnonzero(mesh.confidence < 0.5).tolist()
    assert len(listed["doubtful"]["long & <b>"]) > 20


def test_doubtful_vertices_are_counted_by_pose_and_by_group(
    captured: Captured, root: Element
) -> None:
    """The nose that is flagged faces the cameras: it is doubtful, not unseen."""
    doubtful = int(captured.poses["long & <b>"].flagged.sum())
    count = len(captured.poses["rest"].vertices)
    rows = table_of(root, "Vertices of each pose")
    assert rows[0] == ["Pose", "Trusted", "Doubtful", "Seen by no camera", "Trusted of those seen"]
    assert rows[1] == ["rest", f"{count:,}", "0", "0", "100\u00a0%"]
    assert rows[2][:4] == ["long & <b>", f"{count - doubtful:,}", f"{doubtful:,}", "0"]
    groups = table_of(root, "Doubtful vertices of each part")
    assert groups[0] == ["Group", "Vertices", "rest", "long & <b>"]
    parts = {row[0]: row[1:] for row in groups[1:]}
    assert set(parts) == {"face", "nose", "unnamed"}
    assert sum(int(cells[0].replace(",", "")) for cells in parts.values()) == count
    assert sum(int(cells[2].replace(",", "")) for cells in parts.values()) == doubtful


def test_what_no_camera_saw_is_told_apart_from_what_is_doubtful(captured: Captured) -> None:
    """Cameras stand before the ball: its back, flagged as its nose is, was seen by none."""
    mesh, cameras = captured.poses["rest"], captured.cameras["rest"]
    depth = mesh.vertices[:, 2]
    flagged = Registered.of(mesh, mesh.vertices, np.where(np.abs(depth) > 0.9, 0.1, 0.8))
    own = Trust.of(flagged, cameras)
    assert (own.unseen, own.doubtful) == ((depth < -0.9).sum(), (depth > 0.9).sum())
    assert own.trusted + own.unseen + own.doubtful == len(depth)
    assert own.share == pytest.approx(1 - own.doubtful / (len(depth) - own.unseen))
    both = {"a": own, "b": Trust(own.seen & False, own.seen)}
    share = int(100 * own.share)
    assert headline(both).replace("\u00a0", " ") == (
        f"2 poses of {len(depth):,} vertices each. Of what the cameras saw, {share} to 100 % can "
        "be trusted, least in a."
    )
    unseen, doubtful = findings({"a": own})
    assert unseen.startswith("No camera saw ")
    assert "doubtful although cameras saw them." in doubtful
    assert findings({"b": both["b"]}) == []


def test_groups_are_those_of_the_polygons() -> None:
    mesh = template()
    parts = vertex_groups(mesh)
    assert sum(own.sum() for own in parts.values()) == len(mesh.vertices)
    assert mesh.groups is not None
    for number, face in enumerate(mesh.faces):
        label = int(mesh.groups.of_face[number])
        own = {name for name, chosen in parts.items() for v in face if chosen[v]}
        if label == 1:  # a vertex of several parts is of the first
            assert own <= {"nose", "face"}
        if label == -1:
            assert "nose" not in own
    bare = replace_labels(mesh)
    assert list(vertex_groups(bare)) == ["whole mesh"]


def replace_labels(mesh: Any) -> Any:
    from elastomorph.model.mesh import Mesh

    return Mesh(mesh.vertices, mesh.faces)


def test_the_page_asks_nobody_for_anything(page: str) -> None:
    assert not re.findall(r'(?:src|srcset|poster)="(?!data:)', page)
    assert page.count("<script") == 1  # what copies tables


@pytest.mark.parametrize("radial", [0.0, 0.1, -0.08])
def test_a_pose_is_drawn_where_its_photograph_shows_it(tmp_path: Path, radial: float) -> None:
    """The outline of the mesh is that of the skin, whatever the lens; edges lie on it."""
    made = capture(tmp_path, radial=radial)
    pose = "long & <b>"
    mesh, own = made.poses[pose], made.cameras[pose][0]
    image = pose_picture(mesh, own, made.photographs[pose][own.name])
    width = (image.shape[1] - 16) // 3
    assert image.shape[1] == 3 * width + 16
    taken, over, painted = (image[:, k * (width + 8) :][:, :width].astype(int) for k in range(3))
    skin = abs(taken - WALL).sum(axis=2) > 120
    drawn = (painted < 250).any(axis=2)
    assert 0.1 < skin.mean() < 0.95
    assert (skin & drawn).sum() / (skin | drawn).sum() > 0.985
    lines = abs(over - taken).sum(axis=2) > 60
    assert lines.sum() > 0.02 * skin.sum()
    wide = cv2.dilate(skin.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0  # as lines on it are
    assert (lines & wide).sum() > 0.99 * lines.sum()


def test_flagged_vertices_are_red_and_others_never() -> None:
    shares = np.array([0.0, 0.2, 0.4999, 0.5, 0.7, 1.0])
    red, green, blue = confidence_colours(shares).T
    assert (red - green > 0.45).tolist() == [True, True, True, False, False, False]
    assert (np.diff(green[:3]) > 0).all()
    assert (np.diff(blue[3:]) > 0).all()


def test_the_camera_in_front_is_chosen(captured: Captured) -> None:
    """The one that faces most of what is trusted."""
    mesh, cameras = captured.poses["rest"], captured.cameras["rest"]
    front = Registered.of(mesh, mesh.vertices, (mesh.vertices[:, 2] > 0.3).astype(float))
    side = Registered.of(mesh, mesh.vertices, (mesh.vertices[:, 0] < -0.5).astype(float))
    assert frontal(cameras, front).name == "1.jpg"
    assert frontal(cameras, side).name == "0.jpg"


def test_other_poses_are_shown_from_the_same_side(captured: Captured) -> None:
    pose = captured.poses["long & <b>"]
    for front in captured.cameras["rest"]:
        assert beside(front, captured.cameras["long & <b>"], pose).name == front.name


def test_cameras_are_drawn_around_the_head_where_they_stand() -> None:
    """A camera on the face's left is right of it from the front, and left of it from above too."""
    red, own = (255, 0, 0), [camera("a", 50.0)]
    image = camera_picture({"a": own}, {"a": red}, template(), (200, 200)).astype(int)
    views = [image[:, k * 208 :][:, :200] for k in range(3)]
    for view, right in zip(views, (True, False, True), strict=True):
        marked = (view[..., 0] > 200) & (view[..., 1] < 120)
        grey = (view.max(axis=2) < 240) & (np.ptp(view, axis=2) < 20)
        assert marked.sum() > 20
        assert grey.sum() > 200
        assert (np.nonzero(marked)[1].mean() > np.nonzero(grey)[1].mean()) == right


def test_cameras_alone_are_reported(captured: Captured) -> None:
    figures = {"poses": captured.figures["poses"], "seconds": {}}
    page = capture_page(Captured({}, captured.cameras, captured.photographs, "rest", figures))
    root = parsed(page)
    assert "4 cameras found; no poses were asked for." in root.text
    assert len(root.all("img")) == 1
    assert "Pose by pose" not in [each.text for each in root.all("h2")]


def test_a_photograph_that_is_gone_leaves_its_pose_out(captured: Captured, tmp_path: Path) -> None:
    broken = tmp_path / "broken.jpg"
    broken.write_text("no picture")
    photographs = {
        "rest": dict.fromkeys(captured.photographs["rest"], tmp_path / "gone.jpg"),
        "long & <b>": dict.fromkeys(captured.photographs["long & <b>"], broken),
    }
    said: list[str] = []
    page = capture_page(replace(captured, photographs=photographs), say=said.append)
    root = parsed(page)
    assert "rest is not shown: its photograph cannot be opened any more." in root.text
    assert "long & <b> is not shown" in root.text
    assert len(root.all("img")) == 1
    assert str(tmp_path) not in page
    assert sum("gone.jpg" in each or "broken.jpg" in each for each in said) == 2


def test_nothing_measured_is_no_error(captured: Captured) -> None:
    page = capture_page(replace(captured, figures={}))
    assert "None: every photograph is used." in parsed(page).text


def test_it_is_written_whole_or_not_at_all(captured: Captured, tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"suffix \.html"):
        write_capture_report(captured, tmp_path / "a.txt")
    with pytest.raises(FileError):
        write_capture_report(captured, tmp_path / "none" / "a.html")
    assert not list(tmp_path.iterdir())
    write_capture_report(captured, tmp_path / "a.html")
    assert (tmp_path / "a.html").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.04, "0.0 s"),
        (9.94, "9.9 s"),
        (9.96, "10 s"),
        (59.6, "1 min 0 s"),
        (250, "4 min 10 s"),
        (3900, "1 h 5 min"),
    ],
)
def test_durations_are_read_at_a_glance(seconds: float, text: str) -> None:
    assert duration(seconds).replace("\u00a0", " ") == text


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1280, 720), (390, 844)])
def test_it_opens_from_disk_and_gives_the_list(
    browser: Any, page: str, tmp_path: Path, size: tuple[int, int], theme: str
) -> None:
    file = tmp_path / "report.html"
    file.write_text(page, encoding="utf-8")
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]}, color_scheme=theme, accept_downloads=True
    )
    said: list[str] = []
    asked: list[str] = []
    tab = context.new_page()
    tab.on("console", lambda message: said.append(message.text))
    tab.on("request", lambda request: asked.append(request.url))
    tab.goto(file.as_uri())
    assert tab.evaluate("document.documentElement.scrollWidth") == size[0]
    tab.evaluate("Promise.all([...document.images].map(image => image.decode()))")
    if AXE.is_file():
        found = tab.evaluate(AXE.read_text(encoding="utf-8") + "; axe.run(document)")
        assert [each["id"] for each in found["violations"]] == []
    with tab.expect_download() as download:
        tab.click("a[download]")
    assert download.value.suggested_filename == "flagged.json"
    assert set(json.loads(Path(download.value.path()).read_text())["doubtful"]) == {
        "rest",
        "long & <b>",
    }
    assert said == []
    assert [url for url in asked if not url.startswith("data:")] == [file.as_uri()]
    context.close()


def test_pictures_are_no_larger_than_they_are_shown(captured: Captured) -> None:
    """Photographs of many pixels are made smaller before they are drawn on."""
    mesh = captured.poses["rest"]
    own = captured.cameras["rest"][1]
    image = pose_picture(mesh, own, captured.photographs["rest"][own.name])
    assert image.shape[0] <= SIZE[1]
    assert image.shape[0] <= 570


def test_a_take_of_scans_has_a_page_with_every_pose_and_some_pictures(tmp_path: Path) -> None:
    """Each of many poses has its row; a dozen of what is doubted is told, and as many pictures."""
    mesh = template()
    figures = {"correspondence": "by landmarks", "surface_mean": 0.02, "shown": 0.9, "flagged": 0.5}
    confidence = np.linspace(0, 1, len(mesh.vertices))
    poses = {
        f"f{k:03}": Registered.of(
            mesh,
            mesh.vertices,
            confidence,
            figures | ({"head": {"doubt_degrees": 1.5, "doubt_mean": k / 8}} if k < 20 else {}),
        )
        for k in range(30)
    }
    write_register_report(poses, tmp_path / "report.html", name="Ada", call="elastomorph register")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    root = parsed(text)
    rows = table_of(root, "Each pose")
    assert [row[0] for row in rows if row[0].startswith("f")] == list(poses)
    assert text.count("the head may be turned by 1.5° otherwise.") == 12
    assert "f019: the head may be turned" in text
    assert "So may those of 5 more" in text  # above 0.25 % of D are 3 to 19
    assert text.count("data:image/webp") == 12
    with pytest.raises(FormatError):
        write_register_report(poses, tmp_path / "report.txt")
