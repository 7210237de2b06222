"""Every verb against every kind of source: it works, or it refuses in one sentence."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run
from small_files import sheet

import elastomorph as em
from elastomorph.io import rig_folder

RIGS = {
    "face": "default",
    "character": "settings",
    "character/elastomorph.toml": "settings",
    "foreign.glb": "default",
    "foreign.vrm": "default",
    "foreign.usda": "default",
    "ours.glb": "own",
    "ours.npz": "own",
    "ours.usda": "own",
}
"""A rig of each kind, and where its paths come from where no method is named."""

USD = ("foreign.usda", "ours.usda")
"""Read by a process of its own, which takes seconds to start."""

ANY = [pytest.param(rig, marks=[pytest.mark.slow] if rig in USD else []) for rig in RIGS]

DOORS = {
    "inspect": ["inspect", "{}", "--json"],
    "export to GLB": ["export", "{}", "-o", "out.glb"],
    "export to NPZ": ["export", "{}", "-o", "out.npz"],
    "export to USD": ["export", "{}", "-o", "out.usdc"],
    "export a part": ["export", "{}", "-o", "out.npz", "--only", "smile"],
    "blend one": ["blend", "{}", "-w", "jawOpen=1", "-t", "0.5", "-o", "out.obj"],
    "blend all": ["blend", "{}", "--levels", "2", "-t", "0.5", "-o", "out.npz"],
    "animate a rig": ["animate", "{}", "take.csv", "-o", "out.glb"],
    "animate a cache": ["animate", "{}", "take.csv", "-o", "out.pc2"],
    "animate poses": ["animate", "{}", "poses.csv", "-o", "out.npz"],
    "film poses": ["animate", "{}", "poses.csv", "--rate", "2", "--size", "32x32", "-o", "out.gif"],
    "track": ["track", "{}", "scan.####.obj", "-o", "out.csv"],
    "view": ["view", "{}", "-o", "out.html"],
    "doctor": ["doctor", "{}", "--json"],
    "render": ["render", "{}", "-p", "jawOpen=0.5", "--size", "32x32", "-o", "out.png"],
    "render a pose": ["render", "{}", "-p", "poses.csv#Wide", "--size", "32x32", "-o", "out.png"],
}
"""The verbs that take a rig."""

ONE_METHOD = ("inspect", "doctor")
"""The verbs that have no --method: they look at what is there."""

SLOW = {
    *("render", "render a pose", "view", "doctor"),
    *("animate a cache", "animate poses", "film poses", "export to USD"),
}
"""Doors that take a second each: tried with a few sources."""


def paths_of(rig: em.Rig) -> dict[str, str]:
    """How each path came about: by the default, or the method that was named."""
    return {name: "auto" if m.choice else m.method for name, m in rig.morphs.items()}


EXPECTED = {
    "default": {"jawOpen": "auto", "smile": "auto"},
    "settings": {"jawOpen": "arc", "smile": "auto"},
    "own": {"jawOpen": "ease R=3", "smile": "ease R=3"},
}


def cases() -> list[object]:
    few = {"face", "foreign.glb", "ours.glb"}
    return [
        pytest.param(door, rig, id=f"{door}-{rig}")
        for door in DOORS
        for rig in RIGS
        if rig in few or (door not in SLOW and rig not in USD) or door == "export to NPZ"
    ]


@pytest.mark.parametrize(("door", "rig"), cases())
def test_it_works(here: Path, door: str, rig: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = [word.format(rig) for word in DOORS[door]]
    assert run(*words) == 0, capsys.readouterr().err
    said = capsys.readouterr()
    assert "Traceback" not in said.err
    outputs = [word for word in words if word.startswith("out.")]
    assert all((here / name).stat().st_size for name in outputs)


@pytest.mark.parametrize("rig", ANY)
def test_the_default_is_the_same_at_every_door(
    here: Path, rig: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is exported, what inspect says of it and of the source, and what Python reads."""
    expected = EXPECTED[RIGS[rig]]
    assert run("export", rig, "-o", "out.npz") == 0
    assert paths_of(em.read_rig("out.npz")) == expected
    assert run("export", rig, "-o", "out.glb") == 0
    assert paths_of(em.read_rig("out.glb")) == expected
    if RIGS[rig] != "settings":
        assert paths_of(em.read_rig(rig)) == expected
    capsys.readouterr()
    for source in (rig, "out.npz"):
        assert run("inspect", source, "--json") == 0
        targets = json.loads(capsys.readouterr().out)["targets"]
        told = {n: "auto" if own["choice"] else own["method"] for n, own in targets.items()}
        assert told == expected
        for own in targets.values():
            if own["choice"]:
                assert own["choice"]["straight"] == (own["bends"] == 0)
        assert run("inspect", source) == 0
        text = capsys.readouterr().out
        assert ("auto: straight, turning differs by" in text) == ("auto" in expected.values())


@pytest.mark.parametrize("rig", ANY)
def test_a_method_named_by_hand_counts_for_every_source(here: Path, rig: str) -> None:
    assert run("export", rig, "--method", "cosine", "-o", "out.npz") == 0
    assert set(paths_of(em.read_rig("out.npz")).values()) == {"cosine"}
    if RIGS[rig] != "settings":
        assert set(paths_of(em.read_rig(rig, method="cosine")).values()) == {"cosine"}


@pytest.mark.parametrize("door", [d for d in DOORS if d not in ONE_METHOD])
def test_a_method_changes_what_comes_out_of_every_door(here: Path, door: str) -> None:
    """The case that was missed: a GLB of another program."""
    words = [word.format("foreign.glb") for word in DOORS[door]]
    (name,) = (word for word in words if word.startswith("out."))
    found = []
    for method in ("linear", "ease:4"):
        assert run(*words, "--method", method) == 0
        found.append((here / name).read_bytes())
        (here / name).unlink()
    assert found[0] != found[1]


def test_straight_within_is_part_of_the_method(here: Path) -> None:
    for words in (["--method", "auto:0.9"], ["--settings", "loose.toml"]):
        Path("loose.toml").write_text("[method]\nstraight_within = 0.9\n")
        assert run("export", "face", "-o", "out.npz", *words) == 0
        rig = em.read_rig("out.npz")
        assert not any(len(morph.bends) for morph in rig.morphs.values())
        assert {m.choice.allowed for m in rig.morphs.values() if m.choice} == {0.9}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["export", "points.npz", "--method", "rotation", "-o", "out.npz"], "polygon"),
        (["export", "heads.glb", "--mesh", "middle", "-o", "out.npz"], "'left'"),
        (["export", "face", "--mesh", "left", "-o", "out.npz"], "mesh"),
        (["inspect", "neutral.obj", "--mesh", "left"], "--mesh"),
        (["inspect", "ours.glb", "jawOpen.obj"], "by itself"),
        (["export", "", "-o", "out.npz"], "is empty"),
        (["export", "face", "-o", ""], "is empty"),
        (
            ["export", "face", "-o", "out"],
            "expected one of .glb, .usd, .usda, .usdc, .usdz, .npz\n",
        ),
        (["export", "face", "-o", "out.fbx"], "only read; write one of .glb"),
        (["export", "neutral.obj", "-o", "out.glb"], "neutral.obj"),
        (["export", "motion.npz", "-o", "out.glb"], "motion.npz"),
        (["export", "take.csv", "-o", "out.glb"], "take.csv"),
        (["animate", "neutral.obj", "take.csv", "-o", "out.glb"], "neutral.obj"),
        (["blend", "motion.npz", "-o", "out.npz"], "motion.npz"),
        (["curves", "ours.glb", "-o", "out.json"], "ours.glb"),
        (["evaluate", "ours.glb"], "ours.glb"),
        (["interpolate", "ours.glb", "jawOpen.obj", "-o", "out.obj"], "ours.glb"),
        (["view", "neutral.obj", "-o", "out.html"], "neutral.obj"),
        (
            ["interpolate", "neutral.obj", "smile.obj", "-o", "a.obj", "--rest", "neutral"],
            "--region",
        ),
        (["interpolate", "neutral.obj", "smile.obj", "-o", "a.obj", "--falloff", "2"], "--region"),
        (["render", "neutral.obj", "--mesh", "left", "-o", "out.png"], "--mesh"),
        (["render", "face", "-o", "out.png", "--unit", "cm"], "--against"),
        (["render", "face", "-o", "out.png", "-t", "0.5"], "--pose"),
        (["render", "face", "-o", "out.png", "--method", "linear"], "--pose"),
        (["render", "neutral.obj", "-o", "out.png", "--method", "linear"], "--pose"),
        (["render", "face", "-p", "smile=1", "--strip", "0,1", "-t", "1", "-o", "a.png"], "--time"),
        (["blend", "face", "-w", "smile=1", "-o", "out.obj", "--levels", "3"], "--weight"),
        (["blend", "face", "-w", "smile=1", "-o", "a.obj", "--expressions", "smile"], "--weight"),
        (["blend", "face", "-w", "smile=1", "-o", "out.obj", "--no-normalize"], "--weight"),
        (["blend", "face", "-w", "smile=1", "-o", "out.obj", "--sheet", "a.png"], "--weight"),
        (["evaluate", "scan.####.obj", "--edge", "0.2"], "--movements"),
        (["evaluate", "scan.####.obj", "--unit", "cm"], "--report"),
        (["evaluate", "scan.####.obj", "--method", "linear", "--mass", "2"], "--method beam"),
        (["evaluate", "scan.####.obj", "--method", "through:1", "--rigidity", "2"], "beam"),
        (["animate", "face", "take.csv", "--timecode-rate", "30", "-o", "a.glb"], "no timecodes"),
        (["animate", "face", "take.csv", "--rate", "9", "--picture", "a.png"], "--output"),
        (["animate", "face", "take.csv", "-o", "face/"], "folder of the rig"),
        (["animate", "character/elastomorph.toml", "take.csv", "-o", "character"], "of the rig"),
        (["export", "nowhere", "-o", "out.glb"], "nowhere: there is no such file or folder"),
        (["evaluate", "motion.npz", "--method", "linear", "-o", "smile.obj"], "this is a file"),
        (["inspect", "nowhere"], "nowhere: there is no such file or folder"),
    ],
)
def test_it_refuses_in_one_sentence(
    here: Path, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    em.write("points.npz", em.Rig(em.Mesh(sheet().vertices), {"a": em.interpolate(
        em.Mesh(sheet().vertices), em.Mesh(sheet().vertices + 1.0), "linear")}))  # fmt: skip
    before = sorted(here.rglob("*"))
    assert run(*words) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert said.count("\n") == 1
    assert message in said
    assert sorted(here.rglob("*")) == before


def test_the_built_in_head_is_a_rig_like_any_other(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where no rig is named. Two targets of it, for paths to all take their time."""
    stored = rig_folder.rig_as_stored
    few = stored("built-in").only(["jawOpen", "jawForward"])
    monkeypatch.setattr(
        rig_folder,
        "rig_as_stored",
        lambda path, **options: few if path == "built-in" else stored(path, **options),
    )
    monkeypatch.setenv("XDG_CACHE_HOME", str(here / "cache"))
    words = ["export", "built-in", "--only", "jawOpen,jawForward", "-o", "out.npz"]
    assert run(*words) == 0
    part, whole = em.read_rig("out.npz"), em.read_rig("built-in")
    assert {n: m.choice for n, m in part.morphs.items()} == {
        n: whole.morphs[n].choice for n in part.names
    }
    assert run("inspect", "built-in") == 0
    assert "auto: turned, the straight line is" in capsys.readouterr().out
    assert run("curves", "built-in", "-o", "curves.json", "--json") == 0
    assert json.loads(capsys.readouterr().out)["vertices"] == len(whole.neutral.vertices)
    for words in (["-w", "jawOpen=1", "-o", "a.obj"], ["--levels", "2", "-o", "a.npz"]):
        assert run("blend", "built-in", *words) == 0
        assert run("blend", *words) == 0
    for rig in (["built-in"], []):
        assert run("render", *rig, "-p", "jawOpen=0.5", "--size", "32x32", "-o", "a.png") == 0


@pytest.mark.realdata
@pytest.mark.slow
def test_an_fbx_of_another_program(data_dir: Path, tmp_path: Path) -> None:
    fbx = data_dir / "facecap" / "FaceCapHeadGeneric.fbx"
    out = tmp_path / "out.npz"
    assert run("export", fbx, "--only", "jawOpen,mouthSmile_L", "-o", out) == 0
    assert set(paths_of(em.read_rig(out)).values()) == {"auto"}
    assert run("export", fbx, "--only", "jawOpen", "--method", "beam:2", "-o", out) == 0
    assert set(paths_of(em.read_rig(out)).values()) == {"beam R=2"}


def test_a_region_and_settings_go_together(here: Path) -> None:
    """Inside, the method of the settings, their own regions included; outside, the rest."""
    Path("own.toml").write_text(
        '[method]\ndefault = "ease:2"\n[regions.corner]\nvertices = [0]\nmethod = "cosine"\n'
        "falloff = 0\n"
    )
    words = ["--settings", "own.toml", "-t", "0.25", "-o", "out.obj", "--region", "0-9"]
    words += ["--falloff", "0", "--rest", "neutral"]
    assert run("interpolate", "neutral.obj", "jawOpen.obj", *words) == 0
    start, end = sheet().vertices, em.read("jawOpen.obj").vertices
    found = em.read("out.obj").vertices
    np.testing.assert_allclose(found[1:10], (start + 0.0625 * (end - start))[1:10], atol=1e-9)
    share = (1 - np.cos(np.pi / 4)) / 2
    np.testing.assert_allclose(found[0], (start + share * (end - start))[0], atol=1e-9)
    np.testing.assert_array_equal(found[10:], start[10:])
