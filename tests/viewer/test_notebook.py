"""How rigs, paths and evaluations show themselves in a notebook."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pages import STAND_IN, Elements, read_back, scene_in

import elastomorph as em
from elastomorph.evaluation import Evaluation
from elastomorph.rig import Rig


def frame(html: str) -> dict[str, str | None]:
    (found,) = Elements(html).found
    tag, attributes = found
    assert tag == "iframe"
    return attributes


def test_a_rig_is_a_viewer_in_a_frame(stand_in: str, rig: Rig, tmp_path: Path) -> None:
    attributes = frame(rig._repr_html_())
    assert "width: 100%" in str(attributes["style"])
    assert "height: 480px" in str(attributes["style"])
    assert attributes["title"] == repr(rig)
    page = str(attributes["srcdoc"])
    scene, (glb,) = scene_in(page)
    assert scene["title"] == repr(rig)
    back = read_back(glb, tmp_path)
    assert back.names == rig.names
    np.testing.assert_allclose(back.pose({"up": 0.5}), rig.pose({"up": 0.5}), atol=1e-6)


def test_the_page_in_the_frame_is_the_page(stand_in: str, rig: Rig) -> None:
    """Quotes and ampersands of the page survive being an attribute."""
    page = str(frame(rig._repr_html_())["srcdoc"])
    before, after = STAND_IN.split("<!-- elastomorph scene -->")
    assert page.startswith(before)
    assert page.endswith(after)


def test_the_frame_cannot_reach_the_notebook(stand_in: str, rig: Rig) -> None:
    allowed = str(frame(rig._repr_html_())["sandbox"]).split()
    assert "allow-scripts" in allowed
    assert "allow-same-origin" not in allowed


def test_a_path_begins_half_way(stand_in: str, curved: em.Morph) -> None:
    scene, _ = scene_in(str(frame(curved._repr_html_())["srcdoc"]))
    assert scene["start"] == {"weights": {"motion": 1.0}, "t": 0.5}


@pytest.mark.parametrize("limit", [100, 2000])
def test_what_is_too_large_says_how_to_view_it(
    stand_in: str, rig: Rig, monkeypatch: pytest.MonkeyPatch, limit: int
) -> None:
    """Before the page is made if the targets alone are too large, otherwise afterwards."""
    monkeypatch.setattr("elastomorph.viewer.notebook.LARGEST_PAGE", limit)
    html = rig._repr_html_()
    assert "iframe" not in html
    assert "elastomorph view" in html
    assert "2 morphs" in html


@pytest.mark.parametrize("error", [em.MissingExtraError("usd-core", "usd"), None])
def test_what_cannot_be_shown_is_said(
    stand_in: str, error: Exception | None, rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cell never fails because its rig has no picture."""
    shown = Rig(em.Mesh(np.eye(3)), {})
    if error is not None:
        shown = rig

        def refuse(*_: object, **__: object) -> None:
            raise error

        monkeypatch.setattr("elastomorph.viewer.rig_scenes.write_glb", refuse)
    html = shown._repr_html_()
    assert "iframe" not in html
    assert ("usd" if error else "no polygons") in html


def test_importing_the_package_loads_no_viewer() -> None:
    import subprocess
    import sys

    code = (
        "import sys, elastomorph.cli; "
        "print([m for m in sys.modules if 'viewer' in m or m == 'http.server'])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"


def test_an_evaluation_is_a_table(evaluation: Evaluation) -> None:
    html = evaluation._repr_html_()
    tags = [tag for tag, _ in Elements(html).found]
    assert tags.count("tr") == 1 + len(evaluation.results)
    assert tags.count("caption") == 1
    assert "iframe" not in html
