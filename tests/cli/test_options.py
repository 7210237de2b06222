"""No option is passed over: each changes the result."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from calls import status_of as run

INTERPOLATE = ["interpolate", "neutral.obj", "jawOpen.obj", "-t", "0.3"]
RENDER = ["render", "face", "--size", "32x32", "-p", "jawOpen=1"]
TRACK = ["track", "waves", "wave.####.obj"]
AGAINST = ["render", "face", "--size", "240x240", "-p", "jawOpen=1", "-t", "0.5"]
OPTIONS = [
    (INTERPOLATE, ["--method", "beam:2"], "out.obj"),
    (INTERPOLATE, ["--settings", "own.toml"], "out.obj"),
    (INTERPOLATE, ["--timing", "blink"], "out.obj"),
    (INTERPOLATE, ["--region", "part.json"], "out.obj"),
    ([*INTERPOLATE, "--region", "part.json"], ["--falloff", "0"], "out.obj"),
    ([*INTERPOLATE, "--region", "part.json"], ["--rest", "neutral"], "out.obj"),
    ([*INTERPOLATE, "--method", "beam"], ["--order", "3"], "out.obj"),
    ([*INTERPOLATE, "--method", "ease"], ["--load", "0.2,0.8"], "out.obj"),
    ([*INTERPOLATE, "--method", "beam:3"], ["--closure", "rest"], "out.obj"),
    ([*INTERPOLATE, "--method", "rotation"], ["--tolerance", "0.1"], "out.obj"),
    ([*INTERPOLATE, "--method", "auto"], ["--straight-within", "9"], "out.obj"),
    ([*INTERPOLATE, "--method", "beam:3"], ["--mass", "90"], "out.obj"),
    ([*INTERPOLATE, "--method", "beam:3"], ["--damping", "90"], "out.obj"),
    ([*INTERPOLATE, "--method", "beam:3"], ["--rigidity", "0.1"], "out.obj"),
    ([*INTERPOLATE, "--method", "beam:3", "--rigidity", "0.1"], ["--harmonics", "1"], "out.obj"),
    ([*INTERPOLATE, "--method", "beam:3", "--rigidity", "0.1"], ["--basis", "fourier"], "out.obj"),
    (
        [*INTERPOLATE, "--method", "beam:3", "--rigidity", "0.1"],
        ["--stiffness", "length"],
        "out.obj",
    ),
    (
        [*INTERPOLATE, "--method", "beam:3", "--rigidity", "0.1"],
        ["--curves", "curves.json"],
        "out.obj",
    ),
    (["export", "face"], ["--only", "smile"], "out.npz"),
    (["export", "face"], ["--method", "linear"], "out.npz"),
    (["export", "face"], ["--settings", "own.toml"], "out.npz"),
    (["export", "heads.glb"], ["--mesh", "left"], "out.npz"),
    (["export", "face"], ["--normals", "none"], "out.glb"),
    (["export", "face"], ["--tolerance", "0.5"], "out.glb"),
    (["export", "face"], ["--timing", "minimum-jerk"], "out.glb"),
    (["blend", "face", "-w", "jawOpen=1"], ["-t", "0.5"], "out.obj"),
    (["blend", "face"], ["--levels", "3"], "out.npz"),
    (["blend", "face"], ["--expressions", "smile"], "out.npz"),
    (["blend", "face", "-t", "0.5"], ["--method", "linear"], "out.npz"),
    (["blend", "face"], ["--no-normalize"], "out.npz"),
    (["animate", "face", "take.csv"], ["--rate", "12"], "out.npz"),
    (["animate", "face", "take.csv"], ["--start", "0.1"], "out.npz"),
    (["animate", "face", "take.csv"], ["--stop", "0.1"], "out.npz"),
    (["animate", "face", "take.csv"], ["--method", "ease:2"], "out.npz"),
    (TRACK, ["--rate", "12"], "out.csv"),
    (TRACK, ["--rest", "2"], "out.csv"),
    (TRACK, ["--prior", "0.1"], "out.csv"),
    (TRACK, ["--smooth", "9"], "out.csv"),
    (TRACK, ["--method", "ease:2"], "out.csv"),
    (TRACK, ["--settings", "own.toml"], "out.csv"),
    (TRACK, ["--landmarks", "places.json"], "out.csv"),
    ([*TRACK, "--landmarks", "places.json"], ["--mesh-landmarks", "moved.json"], "out.csv"),
    (["curves", "neutral.obj"], ["--curves", "curves.json"], "out.json"),
    (["view", "face"], ["--method", "linear"], "out.html"),
    (["view", "face"], ["--unit", "cm"], "out.html"),
    (["view", "face"], ["--settings", "own.toml"], "out.html"),
    (["view", "heads.glb"], ["--mesh", "left"], "out.html"),
    (RENDER, ["--pose", "smile=1"], "out.png"),
    (RENDER, ["-t", "0.5"], "out.png"),
    ([*RENDER, "-t", "0.5"], ["--method", "linear"], "out.png"),
    ([*RENDER, "-t", "0.5"], ["--settings", "own.toml"], "out.png"),
    (RENDER, ["--view", "side"], "out.png"),
    (RENDER, ["--size", "48x48"], "out.png"),
    (RENDER, ["--strip", "0,1"], "out.png"),
    (RENDER, ["--wireframe"], "out.png"),
    (RENDER, ["--edge-loops"], "out.png"),
    (RENDER, ["--background", "#204060"], "out.png"),
    (AGAINST, ["--against", "linear"], "out.png"),
    ([*AGAINST, "--against", "linear"], ["--highest", "9"], "out.png"),
    ([*AGAINST, "--against", "linear"], ["--unit", "cm"], "out.png"),
    ([*RENDER, "--turntable", "--frames", "2"], ["--degrees", "90"], "out.gif"),
    ([*RENDER, "--turntable", "--frames", "2"], ["--frames", "3"], "out.gif"),
    ([*RENDER, "--turntable", "--frames", "2"], ["--fps", "5"], "out.gif"),
    ([*RENDER, "--turntable", "--frames", "3"], ["--animate"], "out.gif"),
    ([*RENDER, "--animate", "--frames", "5"], ["--timing", "blink"], "out.gif"),
]
"""Calls, an option more, and the file that it changes."""


@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
@pytest.mark.parametrize(
    ("words", "option", "output"), OPTIONS, ids=[f"{w[0]} {' '.join(o)}" for w, o, _ in OPTIONS]
)
def test_an_option_changes_the_result(
    here: Path, words: list[str], option: list[str], output: str
) -> None:
    found = []
    for more in ([], [], option):
        assert run(*words, *more, "-o", output) == 0
        found.append((here / output).read_bytes())
        (here / output).unlink()
    assert found[0] == found[1] != found[2]


@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
@pytest.mark.parametrize(
    "option",
    [
        ["--method", "ease:2"],
        ["--all"],
        ["--rigid", "0-9"],
        ["--mass", "90"],
        ["--damping", "90"],
        ["--rigidity", "0.1"],
        ["--curves", "curves.json"],
        ["--settings", "own.toml"],
    ],
    ids=" ".join,
)
def test_an_option_changes_an_evaluation(
    here: Path, option: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    found = []
    for more in ([], option):
        assert run("evaluate", "scan.####.obj", "--method", "beam:3", "--json", *more) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert found[0] != found[1]
    assert ("rigid" in found[1]) == ("--rigid" in option)
