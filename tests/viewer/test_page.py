"""Pages: what is put in comes out, and no text of a scene can leave its place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from pages import Elements, read_back, scene_in

import elastomorph as em
from elastomorph.rig import Rig
from elastomorph.viewer import SceneModel, comparison_scene, rig_scene, viewer_page, write_viewer
from elastomorph.viewer.page import alone_policy, page_beside, shipped_page
from elastomorph.viewer.scene import Scene
from small_head import head, shapes

hostile = st.text(max_size=12) | st.lists(
    st.sampled_from(
        ["</script>", "<script>", "<!--", "-->", "]]>", '"', "'", "\\", "&lt;", "\u2028", "\ud800"]
    ),
    max_size=4,
).map("".join)


@pytest.fixture(scope="module")
def model(rig: Rig) -> SceneModel:
    return rig_scene(rig).models[0]


def test_the_page_holds_the_models(
    stand_in: str, curved: em.Morph, straight: em.Morph, tmp_path: Path
) -> None:
    page = viewer_page(comparison_scene({"line": straight, "arc": curved}))
    scene, glbs = scene_in(page)
    assert scene["version"] == 1
    assert [model["name"] for model in scene["models"]] == ["line", "arc"]
    for glb, morph in zip(glbs, (straight, curved), strict=True):
        rig = read_back(glb, tmp_path)
        assert rig.neutral.faces == morph.neutral.faces
        for t in (0.0, 0.5, 1.0):
            np.testing.assert_allclose(rig.pose({"motion": t}), morph.at(t), atol=1e-6)


def test_the_built_in_head_comes_back(stand_in: str, tmp_path: Path) -> None:
    to = em.prepare(head(), "beam:2")
    rig = Rig(head(), {name: to(shapes()[name]) for name in ("jawOpen", "eyeBlink_L")})
    _, (glb,) = scene_in(viewer_page(rig_scene(rig)))
    weights = {"jawOpen": 0.6, "eyeBlink_L": 0.3}
    np.testing.assert_allclose(
        read_back(glb, tmp_path).pose(weights), rig.pose(weights), atol=1e-6 * head().diameter
    )


def test_the_rest_of_the_page_stays(stand_in: str, model: SceneModel) -> None:
    page = viewer_page(Scene((model,), "x"))
    before, after = stand_in.split("<!-- elastomorph scene -->")
    assert page.startswith(before)
    assert page.endswith(after)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(hostile, hostile, hostile, hostile)
@example("</script><script>alert(1)</script>", "<!--<script>", "</SCRIPT >", "\\u003c")
def test_no_text_breaks_out(
    stand_in: str, model: SceneModel, title: str, name: str, unit: str, slider: str
) -> None:
    """The page has the elements it always has, and every text comes back as it was."""
    named = SceneModel(name, "rig", model.glb)
    page = viewer_page(Scene((named,), title, unit, start={"weights": {slider: 1.0}}))
    plain = viewer_page(Scene((model,), "x"))
    assert Elements(page).found == Elements(plain).found
    assert "<" not in Elements(page).texts["elastomorph-scene"]
    scene, _ = scene_in(page)
    assert (scene["title"], scene["unit"]) == (title, unit)
    assert scene["models"][0]["name"] == name
    assert scene["start"]["weights"] == {slider: 1.0}
    page.encode()


def test_a_page_beside_its_models_names_them(stand_in: str, model: SceneModel) -> None:
    page = page_beside(Scene((model,), "x"), ["model-0.glb"], {})
    elements = Elements(page)
    assert '"glb":"model-0.glb"' in elements.texts["elastomorph-scene"]
    assert "elastomorph-glb-0" not in elements.texts


def test_a_page_is_written_whole_or_not_at_all(
    stand_in: str, model: SceneModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Scene((model,), "Größe ≤ 1")
    path = tmp_path / "face.html"
    write_viewer(path, scene)
    assert path.read_bytes() == viewer_page(scene).encode()
    path.write_text("old")

    def broken(scene: Scene) -> str:
        raise MemoryError

    monkeypatch.setattr("elastomorph.viewer.page.viewer_page", broken)
    with pytest.raises(MemoryError):
        write_viewer(path, scene)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["face.glb", "face", "nowhere/face.html"])
def test_places_that_no_page_can_have(
    stand_in: str, model: SceneModel, tmp_path: Path, name: str
) -> None:
    with pytest.raises(em.FileError, match="face"):
        write_viewer(tmp_path / name, Scene((model,), "x"))
    assert not list(tmp_path.iterdir())


def test_a_missing_page_says_how_to_build_it(
    model: SceneModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("elastomorph.viewer.page.files", lambda package: tmp_path)
    with pytest.raises(em.FileError, match="make page"):
        viewer_page(Scene((model,), "x"))


@pytest.mark.parametrize("page", ["<p>", "<!-- elastomorph scene -->" * 2])
def test_a_page_of_another_build_is_refused(
    model: SceneModel, monkeypatch: pytest.MonkeyPatch, page: str
) -> None:
    monkeypatch.setattr("elastomorph.viewer.page.shipped_page", lambda: page)
    with pytest.raises(em.FileError, match="must have one line"):
        viewer_page(Scene((model,), "x"))


def test_the_shipped_page_is_whole_and_small(model: SceneModel) -> None:
    """It has a place for the scene, is at most 900 kB, and loads nothing from elsewhere."""
    page = shipped_page()
    assert len(page.encode()) <= 900_000
    for tag, attributes in Elements(page).found:
        for name in ("src", "href"):
            address = attributes.get(name)
            assert address is None or address.startswith("data:"), (tag, address)
    scene, glbs = scene_in(viewer_page(Scene((model,), "x")))
    assert scene["title"] == "x"
    assert glbs == [model.glb]


def test_a_page_alone_is_kept_from_the_network(stand_in: str, model: SceneModel) -> None:
    """Before any script comes a policy that lets this page's script run and fetches nothing."""
    found = Elements(viewer_page(Scene((model,), "x"))).found
    tags = [tag for tag, _ in found]
    (number,) = (i for i, (_, given) in enumerate(found) if given.get("http-equiv") is not None)
    assert number < tags.index("script")
    assert found[number][1]["content"] == alone_policy(stand_in)
    assert "http" not in alone_policy(stand_in)
