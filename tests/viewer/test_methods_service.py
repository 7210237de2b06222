"""Methods chosen in a page: paths made, measured and kept in the settings of the folder."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from asking import ask, get, post
from pages import read_back, scene_in

import elastomorph as em
from elastomorph.cli import main
from elastomorph.cli.options import NamedRig
from elastomorph.cli.view import _services
from elastomorph.rig import Rig
from elastomorph.viewer import ViewerServer, rig_scene, serve
from elastomorph.viewer.listening import Offer
from small_head import head, shapes, straight

COMMENTED = """\
# as on set
[methods]
eyeBlink_L = "linear"  # for now
"""


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A jaw, a lid and a lid half closed, of the small head."""
    folder = tmp_path_factory.mktemp("Ada")
    own, lid = shapes(), shapes()["eyeBlink_L"]
    half = em.interpolate(head(), lid, "rotation").at(0.5)
    for name, mesh in (
        ("neutral", head()),
        ("jawOpen", own["jawOpen"]),
        ("eyeBlink_L", lid),
        ("half", head().with_vertices(half)),
    ):
        em.write(folder / f"{name}.obj", mesh)
    return folder


@pytest.fixture
def folder(meshes: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(meshes, tmp_path / "Ada"))


def serving(file: Path, settings: Path | None = None) -> ViewerServer:
    """As the command line serves a rig, with a scene that costs nothing."""
    shelf: dict[str, Offer] = {}
    services = _services([str(file)], [], "", settings, None, shelf)
    return serve(rig_scene(Rig(head(), {})), 0, services, shelf)


@pytest.fixture(autouse=True)
def _stand_in(stand_in: str) -> None:
    """A page of a few lines: nobody opens it."""


def test_every_target_is_listed_with_its_cost_and_distance(folder: Path) -> None:
    (folder / "elastomorph.toml").write_text(COMMENTED)
    with serving(folder) as server:
        done = ask(server, "methods")["done"]
    rows = {row["name"]: row for row in done["rows"]}
    assert rows.keys() == {"jawOpen", "eyeBlink_L", "half"}
    assert rows["eyeBlink_L"]["said"] == "linear"
    assert [rows["eyeBlink_L"][key] for key in ("extra", "bytes", "largest", "mean")] == [0] * 4
    assert rows["jawOpen"]["said"] == ""
    assert rows["jawOpen"]["between"] is None
    assert rows["jawOpen"]["method"].startswith("auto: turned")
    jaw = NamedRig.of(str(folder)).full(print)["jawOpen"]
    times = np.linspace(0, 1, 11)
    straight = np.array([(1 - t) * jaw.at(0) + t * jaw.at(1) for t in times])
    moved = jaw.delta.any(axis=1) | jaw.bends.any(axis=(0, 2))
    off = np.linalg.norm(jaw.at(times) - straight, axis=2)
    assert rows["jawOpen"]["extra"] == len(jaw.bends)
    assert rows["jawOpen"]["largest"] == pytest.approx(off.max(), rel=1e-9)
    assert rows["jawOpen"]["mean"] == pytest.approx(off[:, moved].mean(), rel=1e-6)
    assert {"linear", "auto", "rotation", "beam:2"} <= set(done["methods"])


def test_what_is_shown_is_what_is_saved(folder: Path, tmp_path: Path) -> None:
    """The path in the page, that of the page after saving, and that of every other verb."""
    (folder / "elastomorph.toml").write_text(COMMENTED)
    with serving(folder) as server:
        shown = ask(server, "methods", target="eyeBlink_L", method="rotation")["done"]
        assert shown["row"]["method"] == "rotation"
        path = read_back(get(server, shown["glb"])[1], tmp_path)["eyeBlink_L"]
        choices = {"eyeBlink_L": "rotation"}
        saved = ask(server, "save", choices=choices, known={"eyeBlink_L": "linear"})["done"]
        after = read_back(get(server, saved["glb"])[1], tmp_path)
    assert [row["name"] for row in saved["rows"]] == ["eyeBlink_L"]
    assert saved["rows"][0]["said"] == "rotation"
    text = (folder / "elastomorph.toml").read_text()
    assert text == COMMENTED.replace('"linear"', '"rotation"')
    anew = NamedRig.of(str(folder)).full(print)
    for time in (0.3, 0.5, 0.8):
        expected = anew["eyeBlink_L"].at(time)
        scale = head().diameter
        assert np.abs(path.at(time) - expected).max() < 1e-6 * scale
        assert np.abs(after["eyeBlink_L"].at(time) - expected).max() < 1e-6 * scale
        assert np.abs(after["jawOpen"].at(time) - anew["jawOpen"].at(time)).max() < 1e-6 * scale


def test_every_verb_makes_the_path_that_was_shown(tmp_path: Path) -> None:
    """Export, bend and view, of a folder whose settings name a rig file."""
    folder = tmp_path / "Ada"
    folder.mkdir()
    rig = straight("jawOpen", "eyeBlink_L")
    em.write(folder / "head.glb", rig)
    (folder / "elastomorph.toml").write_text('[character]\nrig = "head.glb"  # final\n')
    choices = {"jawOpen": "rotation", "eyeBlink_L": "ease:2"}
    shown = {}
    with serving(folder) as server:
        for name, method in choices.items():
            glb = ask(server, "methods", target=name, method=method)["done"]["glb"]
            shown[name] = read_back(get(server, glb)[1], tmp_path)[name]
        assert ask(server, "save", choices=choices, known={})["done"]
    out, bent, page = tmp_path / "out.glb", tmp_path / "bent.glb", tmp_path / "page.html"
    run("export", folder, "-o", out)
    run("bend", folder / "elastomorph.toml", "-o", bent)
    run("view", folder, "-o", page)
    viewed = read_back(scene_in(page.read_text())[1][0], tmp_path)
    for made in (em.read_rig(out), em.read_rig(bent), viewed):
        for name, path in shown.items():
            error = np.abs(made[name].at(0.4) - path.at(0.4)).max()
            assert error < 2e-5 * rig.neutral.diameter, name


PAIR = "jawOpen_mouthClose"


def pair_of(rig: Rig) -> np.ndarray:
    """What the pair bend of a rig moves where both sliders are half way; nothing without one."""
    if PAIR not in rig:
        return np.zeros_like(rig.neutral.vertices)
    assert rig.sliders.correctives[PAIR] == em.Corrective(("jawOpen", "mouthClose"), "min")
    return rig[PAIR].at(0.5) - rig.neutral.vertices


@pytest.mark.parametrize("source", ["meshes", "rig"])
def test_a_pair_bend_is_made_anew_with_its_paths(tmp_path: Path, source: str) -> None:
    """It is no target; it goes where one of its paths is straight, and comes back as that bends."""
    folder, own, scale = tmp_path / "Ada", shapes(), head().diameter
    folder.mkdir()
    targets = {name: own[name] for name in ("jawOpen", "mouthClose", "eyeBlink_L")}
    if source == "rig":
        em.write(folder / "head.glb", Rig(head(), targets))
        (folder / "elastomorph.toml").write_text('[character]\nrig = "head.glb"\n')
    else:
        for name, mesh in {"neutral": head(), **targets}.items():
            em.write(folder / f"{name}.obj", mesh)
    first = NamedRig.of(str(folder)).full(print)
    assert np.linalg.norm(pair_of(first), axis=1).max() > 0.005 * scale
    shown: dict[str, Rig] = {}
    with serving(folder) as server:
        assert {row["name"] for row in ask(server, "methods")["done"]["rows"]} == {*targets}
        assert "no slider" in ask(server, "methods", target=PAIR, method="arc")["problem"]
        assert "no slider" in ask(server, "save", choices={PAIR: "arc"}, known={})["problem"]
        known: dict[str, str] = {}
        for method in ("linear", "rotation", "arc"):
            done = ask(server, "save", choices={"mouthClose": method}, known=known)["done"]
            known = {"mouthClose": method}
            shown[method] = read_back(get(server, done["glb"])[1], tmp_path)
            anew = pair_of(NamedRig.of(str(folder)).full(print))
            np.testing.assert_allclose(pair_of(shown[method]), anew, atol=1e-5 * scale)
        done = ask(server, "save", choices={"eyeBlink_L": "linear"}, known={})["done"]
        kept = read_back(get(server, done["glb"])[1], tmp_path)
    assert PAIR not in shown["linear"]
    assert PAIR not in shown["linear"].sliders.correctives
    for method in ("rotation", "arc"):
        found = shown[method]
        both = found.pose({"jawOpen": 0.5, "mouthClose": 0.5})
        target = head().with_vertices(
            head().vertices + found["jawOpen"].delta + found["mouthClose"].delta
        )
        expected = em.interpolate(head(), target, "auto").at(0.5)
        assert np.abs(both - expected).max() < 2e-4 * scale
    np.testing.assert_allclose(pair_of(kept), pair_of(shown["arc"]), atol=1e-6 * scale)


def run(*words: object) -> None:
    """A call of the program."""
    with pytest.raises(SystemExit) as stopped:
        main([str(word) for word in words])
    assert not stopped.value.code


def test_a_choice_may_be_taken_back(folder: Path) -> None:
    """Without a word of its own a target follows the default; a folder gets its settings so."""
    with serving(folder) as server:
        ask(server, "save", choices={"jawOpen": "arc"}, known={})
        assert NamedRig.of(str(folder)).full(print)["jawOpen"].method == "arc"
        done = ask(server, "save", choices={"jawOpen": ""}, known={"jawOpen": "arc"})["done"]
    assert done["rows"][0]["method"].startswith("auto")
    assert (folder / "elastomorph.toml").read_text().strip() == "[methods]"


def test_targets_with_inbetweens(folder: Path) -> None:
    """Their path passes through the shapes; the law between them may be chosen, no method."""
    settings = folder / "elastomorph.toml"
    settings.write_text('[inbetweens.eyeBlink_L]\n"0.5" = "half.obj"  # scan 12\n')
    with serving(folder) as server:
        rows = {row["name"]: row for row in ask(server, "methods")["done"]["rows"]}
        assert rows["eyeBlink_L"]["said"] == "smooth"
        assert rows["eyeBlink_L"]["between"][0] < 1e-9
        assert rows["eyeBlink_L"]["laws"] == ["smooth", "spline", "piecewise"]
        refused = ask(server, "methods", target="eyeBlink_L", method="rotation")
        assert "choose smooth, spline, piecewise" in refused["problem"]
        done = ask(
            server, "save", choices={"eyeBlink_L": "piecewise"}, known={"eyeBlink_L": "smooth"}
        )["done"]
    assert done["rows"][0]["said"] == "piecewise"
    assert '"0.5" = "half.obj"  # scan 12\n' in settings.read_text()


def test_shapes_on_the_way_by_their_names(folder: Path) -> None:
    """A scan called eyeBlink_L_50 is what the path to eyeBlink_L should be near at 0.5."""
    (folder / "half.obj").rename(folder / "eyeBlink_L_50.obj")
    with serving(folder) as server:
        found = {
            method: ask(server, "methods", target="eyeBlink_L", method=method)["done"]["row"]
            for method in ("linear", "rotation")
        }
    scale = head().diameter
    assert found["rotation"]["between"][0] < 1e-4 * scale
    lid = em.read_rig(folder)["eyeBlink_L"].target.vertices
    off = np.linalg.norm(
        (head().vertices + lid) / 2 - em.read(folder / "eyeBlink_L_50.obj").vertices, axis=1
    )
    assert found["linear"]["between"][0] == pytest.approx(off.max(), rel=1e-6)


def test_what_has_no_effect_is_told(folder: Path) -> None:
    (folder / "elastomorph.toml").write_text('[method]\ndefault = "beam:2"\nclosure = "rest"\n')
    with serving(folder) as server:
        quiet = ask(server, "methods", target="jawOpen", method="rotation")["done"]
        assert quiet["warnings"] == []
        (folder / "elastomorph.toml").write_text('[method]\nclosure = "rest"\n')
        told = ask(server, "methods", target="jawOpen", method="rotation")["done"]["warnings"]
    assert "'closure' has no effect" in told[0]


def test_two_tabs_on_one_file(folder: Path) -> None:
    """The second is told where it knows no better, and loses nothing of the first."""
    with serving(folder) as server:
        ask(server, "save", choices={"jawOpen": "arc"}, known={"jawOpen": ""})
        refused = ask(server, "save", choices={"jawOpen": "linear"}, known={"jawOpen": ""})
        assert "now says 'arc'" in refused["problem"]
        assert ask(server, "save", choices={"half": "linear"}, known={"half": ""})["done"]
    assert sorted((folder / "elastomorph.toml").read_text().splitlines()) == [
        "[methods]",
        'half = "linear"',
        'jawOpen = "arc"',
    ]


def test_what_was_written_by_hand_meanwhile_counts(folder: Path) -> None:
    with serving(folder) as server:
        ask(server, "methods")
        (folder / "elastomorph.toml").write_text(COMMENTED)
        done = ask(server, "save", choices={"half": "arc"}, known={"half": ""})["done"]
    methods = {row["name"]: row["method"] for row in done["rows"]}
    assert methods == {"half": "arc", "eyeBlink_L": "linear"}


def test_a_file_that_was_damaged_meanwhile(folder: Path) -> None:
    """The page hears it, tries nothing, and goes on when it is mended."""
    file = folder / "elastomorph.toml"
    with serving(folder) as server:
        ask(server, "methods")
        for damaged in (b"[methods\n", b"\xff"):
            file.write_bytes(damaged)
            tried = ask(server, "methods", target="jawOpen", method="arc")
            assert "not TOML" in tried["problem"]
            saved = ask(server, "save", choices={"half": "arc"}, known={"half": ""})
            assert "not TOML" in saved["problem"]
            assert file.read_bytes() == damaged
        file.write_text(COMMENTED)
        assert ask(server, "methods", target="jawOpen", method="arc")["done"]


def test_a_file_by_itself_keeps_no_choice(meshes: Path, tmp_path: Path) -> None:
    """Its paths can be compared; there is nowhere to write."""
    file = tmp_path / "Ada.glb"
    em.write(file, em.read_rig(meshes, method="linear"))
    with serving(file) as server:
        asked = ask(server, "methods", target="jawOpen", method="arc")
        assert asked["done"]["row"]["extra"] > 0, asked
        assert ask(server, "methods", target="jawOpen", method="")["done"]["row"]["extra"] == 0
        assert post(server, "save", b"{}")[0] == 405


@pytest.mark.parametrize(
    ("question", "problem"),
    [
        ({"target": "jawOpn", "method": "arc"}, "jawOpn"),
        ({"target": "jawOpen", "method": "bend"}, "must be one of"),
        ({"target": "jawOpen", "method": "beam:2:x"}, "beam:2:x"),
        ({"target": "jawOpen"}, "no text 'method'"),
        ({"target": 3, "method": "arc"}, "no text 'target'"),
    ],
)
def test_questions_that_make_no_sense(
    meshes: Path, question: dict[str, object], problem: str
) -> None:
    with serving(meshes) as server:
        assert problem in ask(server, "methods", **question)["problem"]


def test_saving_needs_choices(meshes: Path) -> None:
    with serving(meshes) as server:
        assert "no texts 'choices'" in ask(server, "save", choices=[])["problem"]
        assert "no JSON object" in ask_raw(server, b"[1]")
        assert "no JSON object" in ask_raw(server, b"{")
        assert "jawOpn" in ask(server, "save", choices={"jawOpn": "arc"}, known={})["problem"]
    assert not (meshes / "elastomorph.toml").exists()


def ask_raw(server: ViewerServer, body: bytes) -> str:
    return post(server, "save", body)[1].decode()
