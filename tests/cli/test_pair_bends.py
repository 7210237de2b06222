"""What is said of a pair bend: it is no target, and settings, views and reports know it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from calls import printed_by, status_of

import elastomorph as em
from elastomorph.cli.options import NamedRig
from elastomorph.draw import expression_strip
from elastomorph.report.subject import rig_subject
from elastomorph.rig import Rig
from small_head import head, shapes

PAIR = "jawOpen_mouthClose"
TARGETS = ("jawOpen", "mouthClose", "eyeBlink_L")


@pytest.fixture(scope="module")
def meeting() -> Rig:
    """Two targets that meet, and one that does not."""
    rig = Rig(head(), {name: shapes()[name] for name in TARGETS})
    assert [*rig.pair_bends()] == [PAIR]
    return rig


@pytest.fixture(scope="module")
def file(meeting: Rig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("rigs") / "meeting.glb"
    em.write(path, meeting)
    return path


def test_targets_are_those_of_sliders(meeting: Rig) -> None:
    assert [*meeting.targets] == [*TARGETS]
    assert [*meeting.only(["jawOpen", "mouthClose"]).targets] == ["jawOpen", "mouthClose"]


def test_inspect_says_what_it_is(meeting: Rig, file: Path) -> None:
    found = json.loads(printed_by("inspect", file, "--json"))
    assert [*found["targets"]] == [*TARGETS]
    entry = found["correctives"][PAIR]
    assert (entry["drivers"], entry["law"]) == (["jawOpen", "mouthClose"], "min")
    assert entry["bends"] == len(meeting[PAIR].bends)
    lines = printed_by("inspect", file, width=400).splitlines()
    (line,) = [line for line in lines if PAIR in line]
    choice = meeting[PAIR].choice
    assert choice is not None
    assert line == f"    {PAIR}: min of jawOpen, mouthClose  ({choice.text})"
    assert "pair bend of up to" in choice.text


def test_other_correctives_are_told_with_their_law(tmp_path: Path) -> None:
    rig = em.Rig(
        head(),
        {name: em.interpolate(head(), shapes()[name], "linear") for name in TARGETS},
        correctives={"eyeBlink_L": em.Corrective(("jawOpen", "mouthClose"), "hinge", (1.0, 0.5))},
    )
    em.write(tmp_path / "hinged.glb", rig)
    found = json.loads(printed_by("inspect", tmp_path / "hinged.glb", "--json"))
    assert found["correctives"] == {"eyeBlink_L": rig.sliders.correctives["eyeBlink_L"].entry()}
    assert {*found["targets"]} == {*TARGETS}
    text = printed_by("inspect", tmp_path / "hinged.glb", width=400)
    assert "    eyeBlink_L: hinge of jawOpen, mouthClose\n" in text


def test_reports_and_the_doctor_judge_targets(meeting: Rig, file: Path) -> None:
    assert [*rig_subject(file, meeting).targets] == [*TARGETS]
    assert status_of("doctor", file, "--json") in (0, 1)
    assert PAIR not in printed_by("doctor", file, "--json")


def test_expressions_are_drawn_without_it(file: Path, tmp_path: Path) -> None:
    """The strip has a row for each expression, not one for what two of them share."""
    rig = NamedRig.of(str(file)).expressions(print, "jawOpen,mouthClose")
    assert [*rig.targets] == ["jawOpen", "mouthClose"]
    assert PAIR in rig
    words = ("--expressions", "jawOpen,mouthClose", "--levels", "2", "-o", tmp_path / "all.npy")
    assert status_of("blend", file, *words, "--grid", tmp_path / "grid.png") == 0
    expression_strip({name: rig[name] for name in TARGETS[:2]}, tmp_path / "two.png")
    assert (tmp_path / "grid.png").read_bytes() == (tmp_path / "two.png").read_bytes()


def test_it_stays_beside_correctives_of_settings(meeting: Rig, file: Path, tmp_path: Path) -> None:
    """Settings name their own correctives; of the file's, pair bends are a part of its paths."""
    settings = tmp_path / "elastomorph.toml"
    text = f"[character]\nrig = {json.dumps(str(file))}\n\n[correctives]\n"
    settings.write_text(text + 'eyeBlink_L = ["jawOpen", "eyeBlink_L"]\n')
    assert status_of("export", settings, "-o", tmp_path / "out.npz") == 0
    found = em.read_rig(tmp_path / "out.npz")
    assert found.sliders.correctives == {
        "eyeBlink_L": em.Corrective(("jawOpen", "eyeBlink_L")),
        PAIR: meeting.sliders.correctives[PAIR],
    }
    settings.write_text(text.replace("\n[corr", '\n[method]\ndefault = "linear"\n\n[corr'))
    assert status_of("export", settings, "-o", tmp_path / "out.npz", "--overwrite") == 0
    assert [*em.read_rig(tmp_path / "out.npz").morphs] == [*TARGETS]
