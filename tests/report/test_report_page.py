"""One page with everything found: complete, readable by everybody, and closed in itself."""

from __future__ import annotations

import base64
import hashlib
import io
import re
from collections.abc import Sequence
from dataclasses import replace
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from parsed_page import Element, parsed, shown
from PIL import Image
from stand_in import VIEWER

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.errors import FileError, FormatError
from elastomorph.evaluation import Evaluation, evaluate, suggest_inbetweens
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Choice
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method
from elastomorph.physics import Material
from elastomorph.report import About, Picture, report_page, write_report
from elastomorph.report.comparison import live_viewer, recipe
from elastomorph.report.document import Section, compared

SCRIPT = (files("elastomorph.report") / "templates" / "copy.js").read_text(encoding="utf-8")
PAPER = "https://doi.org/10.3390/axioms13030185"
ANSWER = ["outcome", "faces", "viewer"]
APPENDIX = ["compared", "errors", "more", "graphs", "recipe"]
SECTIONS = [*ANSWER, *APPENDIX]


@pytest.fixture(scope="module")
def markers() -> Evaluation:
    """Twelve points without polygons on two curves."""
    rng = np.random.default_rng(3)
    points = rng.normal(size=(12, 3))
    moves = rng.normal(size=(12, 3))
    frames = np.stack([points + t**2 * moves for t in np.linspace(0, 1, 6)])
    curves = CurveNetwork([Curve(range(6)), Curve(range(6, 12))], 12)
    return evaluate(MeshSequence(Mesh(points), frames), ["linear", "ease:2"], curves)


def test_sections_come_in_order_under_headings_that_skip_no_level(root: Element) -> None:
    sections = root.one("main").all("section")
    assert [each.attributes["aria-labelledby"] for each in sections] == SECTIONS
    levels = [int(each.tag[1]) for each in root.all("h1", "h2", "h3", "h4")]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    for section, name in zip(sections, SECTIONS, strict=True):
        assert section.one("h2").attributes["id"] == name
    links = [a.attributes["href"] for a in root.one("nav").all("a")]
    assert links == [f"#{name}" for name in (*ANSWER, "appendix")]
    (appendix,) = (e for e in root.all("div") if e.attributes.get("class") == "appendix")
    assert [a.attributes["href"] for a in appendix.all("a")] == [f"#{name}" for name in APPENDIX]


def test_landmarks_and_language_are_there(root: Element) -> None:
    assert root.one("html").attributes["lang"] == "en"
    for tag in ("header", "nav", "main", "footer", "title"):
        assert root.one(tag).text.strip()
    assert root.one("h1").text == "ball & more"


def test_ids_are_unique(root: Element) -> None:
    ids = [each.attributes["id"] for each in root.all() if "id" in each.attributes]
    assert len(ids) == len(set(ids))


def test_every_picture_says_what_is_seen(root: Element) -> None:
    images = root.all("img")
    assert len(images) == 4
    for image in images:
        assert len(image.attributes["alt"]) > 60
        picture = _decoded(image)
        assert picture.format == "WEBP"
        assert picture.size == (int(image.attributes["width"]), int(image.attributes["height"]))
        assert np.asarray(picture.convert("RGB")).std() > 10
    for graph in root.all("svg"):
        assert graph.attributes["role"] == "img"
        assert len(graph.attributes["aria-label"]) > 60
    for figure in root.all("figure"):
        assert len(figure.one("figcaption").text) > 60


def test_the_size_of_a_part_is_not_called_that_of_the_face(evaluation: Evaluation) -> None:
    """Where the errors of a part are in D of the whole, both sizes are named."""
    part = replace(evaluation, extent=40.0)
    facts = {f.one("dt").text: f.one("dd").text for f in _facts(part)}
    own = evaluation.truth.mesh.diameter
    assert facts["Size"].startswith("D = 40.0 cm, the size of the whole face")
    assert facts["Size"].endswith(f"the parts compared here measure {own:#.3g}")
    assert "Face" not in facts
    whole = {f.one("dt").text: f.one("dd").text for f in _facts(evaluation)}
    assert whole["Size"].startswith(f"D = {own:#.3g}")
    assert "Parts" not in whole


def _facts(evaluation: Evaluation) -> list[Element]:
    root = shown(compared(evaluation, About(unit="cm")))
    return [each for each in root.all("div") if each.attributes.get("class") == "fact"]


def test_auto_is_described_as_what_it_is(evaluation: Evaluation) -> None:
    """Its paths are straight lines or rotations, and called so; what chose them is `auto`."""
    morph = replace(evaluation["linear"].morph, choice=Choice(1e-4, 2e-3))
    result = replace(evaluation["linear"], label="auto", morph=morph)
    auto = replace(evaluation, results=(result,))
    root = shown(recipe(auto.truth, auto, About()))
    cells = [cell.text for cell in root.one("tbody").all("td")]
    assert cells[0] == "the straight line where rotation hardly differs from it, else rotation"
    assert "straight within 0.200\u00a0% of D" in cells[1]


def test_the_page_leads_nowhere_but_to_the_paper(page: str, root: Element) -> None:
    assert set(re.findall(r"https?://[^\"'<> ]+", page)) == {PAPER}
    for each in root.all():
        for name in ("src", "href", "action", "data", "poster", "srcset"):
            value = each.attributes.get(name, "#")
            assert value.startswith(("#", "data:image/webp;")) or value == PAPER
    assert not root.all("link", "base", "object", "embed")
    assert [each.text for each in root.all("script")] == [SCRIPT]
    (style,) = root.all("style")
    assert "url(" not in style.text
    assert "@import" not in style.text


def test_the_policy_forbids_requests(root: Element) -> None:
    policy = next(
        each.attributes["content"] for each in root.all("meta")
        if each.attributes.get("http-equiv") == "Content-Security-Policy"
    )  # fmt: skip
    assert policy.startswith("default-src 'none'; ")
    assert "http" not in policy
    assert "*" not in policy


def test_the_viewer_stands_in_a_frame_of_its_own(root: Element) -> None:
    frame = root.one("iframe")
    inside = frame.attributes["srcdoc"]
    before, after = VIEWER.split("<!-- elastomorph scene -->")
    assert inside.startswith(before)
    assert inside.endswith(after)
    assert inside.count("application/zlib") == 6  # five methods and the recording
    assert "allow-same-origin" not in frame.attributes["sandbox"]
    assert frame.attributes["loading"] == "lazy"
    assert frame.attributes["title"]
    assert "JavaScript" in root.one("noscript").text


def test_the_recipe_makes_the_comparison_again(root: Element, evaluation: Evaluation) -> None:
    facts = {each.one("dt").text: each.one("dd").text for each in root.all("div")
             if each.attributes.get("class") == "fact"}  # fmt: skip
    assert facts["Made by"] == "elastomorph <this>"
    assert facts["Face"] == "266 vertices, 288 polygons (240 quads and 48 triangles)"
    assert facts["Size"].startswith("D = 2.00 cm")
    assert facts["Motion"] == "5 frames at t = 0, 0.25, 0.5, 0.75, 1"
    digest = hashlib.sha256(evaluation.truth.frames.astype("<f8").tobytes()).hexdigest()
    assert facts["SHA-256"].startswith(digest)
    for package in ("elastomorph", "Python", "NumPy", "SciPy"):
        assert package in facts["Versions"]
    table = next(each for each in root.all("table") if each.attributes.get("class") == "settings")
    settings = {row.one("th").text: row.all("td")[1].text for row in table.one("tbody").all("tr")}
    assert settings["beam R=2 unforced"].startswith(
        "p(t) = t², m = 1, c = 1, k = 1, closure unforced, all modes"
    )
    assert settings["linear"] == "none"


def test_settings_given_are_settings_shown(evaluation: Evaluation) -> None:
    method = Method.parse("beam:2").with_material(Material(2, 3, 0.5))
    about = About(methods={"beam R=2": method})
    assert "m = 2, c = 3, k = 0.5" in report_page(evaluation, about, draw=False)


def test_in_betweens_are_told_where_they_were_looked_for(root: Element) -> None:
    assert "What would help" in root.one("main").text
    assert "What in-betweens are worth" in [each.text for each in root.all("h3")]


def test_markers_have_graphs_and_a_sentence_instead_of_a_viewer(markers: Evaluation) -> None:
    found = suggest_inbetweens(markers.truth, 1, curves=markers.curves)
    root = parsed(report_page(markers, About("jaw"), suggestions=found))
    assert not root.all("img", "iframe", "noscript")
    assert len(root.all("svg")) == 3
    assert "faces" not in [each.attributes.get("id") for each in root.all("h2")]
    assert "markers have no surface" in root.one("main").text
    assert "12 markers, without polygons" in root.one("main").text
    policy = root.all("meta")[2].attributes["content"]
    digest = base64.b64encode(hashlib.sha256(SCRIPT.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}';" in policy


@pytest.mark.usefixtures("small_viewer")
def test_a_face_too_large_for_a_mail_is_thinned_and_then_left_out(
    evaluation: Evaluation, monkeypatch: pytest.MonkeyPatch
) -> None:
    from elastomorph.report import comparison

    def viewer(informed: Sequence[str]) -> Element:
        return shown(live_viewer(evaluation, "ball", informed=informed))

    size = len(viewer(["ease R=2"]).one("iframe").attributes["srcdoc"])
    monkeypatch.setattr(comparison, "LARGEST", 20_000)
    thinned = viewer(["ease R=2"])
    assert len(thinned.one("iframe").attributes["srcdoc"]) < size
    judged = [result for result in evaluation.results if result.label != "ease R=2"]
    best = min(judged, key=lambda result: result.lme).label
    kept = {"linear", "beam R=2", best}
    left_out = [result.label for result in evaluation.results if result.label not in kept]
    assert f"it does not hold {', '.join(left_out)}." in thinned.text
    monkeypatch.setattr(comparison, "_MOST", 1000)
    none = viewer([])
    assert not none.all("iframe")
    assert "does not fit" in none.text


def test_a_missing_viewer_does_not_cost_the_report(
    evaluation: Evaluation, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And no folder of this machine gets into it."""

    def missing() -> str:
        raise FileError("/home/somebody/page/index.html", "the viewer's page is not here")

    monkeypatch.setattr("elastomorph.viewer.page.shipped_page", missing)
    section = shown(live_viewer(evaluation, "ball"))
    assert not section.all("iframe")
    (said,) = section.all("p")
    assert said.text == "It is left out: this installation came without the viewer's page."


def test_without_times_the_timed_errors_decide_nothing(evaluation: Evaluation) -> None:
    root = parsed(report_page(evaluation, About(timing_known=False), draw=False))
    said = root.one("main").text
    assert "the times are made up" in said
    assert "At the recorded times" not in said
    assert "At constant speed, assumed" in said
    assert "is compared with the known way." in said
    assert "recorded" not in root.one("main").text.replace("known way", "")


@pytest.mark.usefixtures("small_viewer")
def test_the_viewer_holds_what_a_rig_gets_unless_asked_otherwise(
    evaluation: Evaluation, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However small it must be; and calls nothing recorded that was not."""
    from elastomorph.report import comparison

    methods = ["linear", "cosine", "ease:2", "rotation", "auto"]
    many = evaluate(evaluation.truth, methods, evaluation.curves)
    monkeypatch.setattr(comparison, "LARGEST", 1)
    viewer = shown(live_viewer(many, "ball", truth="known way"))
    left_out = viewer.text.split("it does not hold ")[1].split(".")[0]
    assert "rotation" in left_out
    assert "auto" not in left_out
    frame = viewer.one("iframe").attributes
    assert '"known way"' in frame["srcdoc"]
    assert '"recorded"' not in frame["srcdoc"]


def test_without_drawing_there_are_only_words(evaluation: Evaluation) -> None:
    root = parsed(report_page(evaluation, draw=False))
    assert not root.all("img", "svg", "iframe")
    names = [each.attributes["aria-labelledby"] for each in root.all("section")]
    assert names == ["outcome", "compared", "errors", "recipe"]


def test_names_of_any_kind_are_shown_and_not_obeyed(evaluation: Evaluation) -> None:
    name = "</title><script>alert(1)</script>\"'& ü"
    results = {f"{name} {i}": result.morph for i, result in enumerate(evaluation.results)}
    odd = evaluate(evaluation.truth, results, evaluation.curves)
    about = About(name, source=name, unit=name, call=name, curves=name, remarks=(name,))
    root = parsed(report_page(odd, about, draw=False))
    assert [each.text for each in root.all("script")] == [SCRIPT]
    assert root.one("h1").text == name
    assert f"{name} 3" in [each.text for each in root.all("th")]


def test_a_report_is_written_whole(evaluation: Evaluation, tmp_path: Path, page: str) -> None:
    write_report(evaluation, tmp_path / "report.html", draw=False)
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>\n")
    assert text.endswith("</html>\n")
    assert len(page) < 1_000_000


def test_half_a_report_is_none(
    evaluation: Evaluation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a picture fails the old report stays, and nothing else is left behind."""
    file = tmp_path / "report.html"
    file.write_text("the old one")

    def fails(*_: object, **__: object) -> list[Picture]:
        raise RuntimeError("no memory for the picture")

    monkeypatch.setattr("elastomorph.report.comparison.evaluation_pictures", fails)
    with pytest.raises(RuntimeError, match="no memory"):
        write_report(evaluation, file)
    assert file.read_text() == "the old one"
    assert list(tmp_path.iterdir()) == [file]


def test_a_path_that_cannot_be_written_is_refused_before_anything_is_drawn(
    evaluation: Evaluation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("elastomorph.report.comparison.report_page", lambda *_, **__: 1 / 0)
    with pytest.raises(FormatError, match=r"suffix \.html"):
        write_report(evaluation, tmp_path / "report.pdf")
    with pytest.raises(FileError, match="does not exist"):
        write_report(evaluation, tmp_path / "nowhere" / "report.html")


def test_a_picture_is_embedded_as_it_is() -> None:
    rng = np.random.default_rng(0)
    smooth = np.repeat(np.repeat(rng.integers(0, 255, (4, 5, 3)), 20, 0), 20, 1).astype(np.uint8)
    picture = Picture("A", smooth, "Alt", "Caption")
    image = shown(Section("faces", "Faces", {"pictures": [picture]})).one("img")
    again = np.asarray(_decoded(image).convert("RGB")).astype(int)
    assert again.shape == smooth.shape
    assert np.abs(again - smooth).mean() < 12


def _decoded(image: Element) -> Image.Image:
    content = image.attributes["src"].removeprefix("data:image/webp;base64,")
    return Image.open(io.BytesIO(base64.b64decode(content)))
