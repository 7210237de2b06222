"""Correctives are added to a character in its own file: bent or not, and again."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.bending.gltf import hold_gltf
from elastomorph.io.gltf.container import open_gltf
from small_head import head, shapes

ENDS = {name: shapes()[name] for name in ("jawOpen", "mouthClose", "browDown_L")}
HINGE = em.Corrective(("jawOpen", "browDown_L"), "hinge", (1.0, 0.75))
LEAST = em.Corrective(("mouthClose", "browDown_L"), "min")
FACES = [
    {"jawOpen": 0.75},
    {"jawOpen": 0.75, "mouthClose": 0.5, "browDown_L": 0.625},
    {"jawOpen": 0.5, "mouthClose": 0.5, "browDown_L": 1.0},
]


def adding(name: str, law: em.Corrective) -> Callable[[em.Rig], em.Rig]:
    """Return what adds a corrective that moves what browDown_R does, to any rig of the head."""

    def held(rig: em.Rig) -> em.Rig:
        near = np.linalg.norm(rig.neutral.vertices[:, None] - _moved()[None], axis=2).min(axis=1)
        moves = np.where(near[:, None] < 1e-4, [0.0, 0.25, 0.0], 0.0)
        target = rig.neutral.with_vertices(rig.neutral.vertices + moves)
        shape = em.interpolate(rig.neutral, target, "linear")
        correctives = {**rig.sliders.correctives, name: law}
        return em.Rig(rig.neutral, {**rig.morphs, name: shape}, correctives=correctives)

    return held


def _moved() -> np.ndarray:
    away = np.linalg.norm(shapes()["browDown_R"].vertices - head().vertices, axis=1)
    return head().vertices[away > 0.5]


def assert_plays(path: Path, *added: tuple[str, em.Corrective], bent: bool = True) -> em.Rig:
    """Check that a file plays the paths of the head and what was added."""
    rig = em.Rig(head(), ENDS, method=None if bent else "linear")
    for own in added:
        rig = adding(*own)(rig)
    found = em.read_rig(path, method=None if bent else "linear")
    assert found.names == rig.names
    assert {n: found.sliders.correctives[n] for n, _ in added} == dict(added)
    assert found.pair_bends() == rig.pair_bends()
    for face in FACES:
        away = np.abs(found.pose(face) - rig.pose(face)).max()
        assert away <= 2e-4 * head().diameter
    return found


@pytest.fixture
def exported(tmp_path: Path) -> Path:
    """A file that `export` wrote, which has bends and nothing that undoes them."""
    em.write(tmp_path / "exported.glb", em.Rig(head(), ENDS))
    return tmp_path / "exported.glb"


@pytest.fixture
def straight(tmp_path: Path) -> Path:
    """A file without bends."""
    em.write(tmp_path / "straight.glb", em.Rig(head(), ENDS, method="linear"))
    return tmp_path / "straight.glb"


def test_an_exported_rig_keeps_its_bends(exported: Path, tmp_path: Path) -> None:
    hold_gltf(exported, tmp_path / "held.glb", adding("extra", HINGE))
    assert_plays(tmp_path / "held.glb", ("extra", HINGE))
    files = (open_gltf(exported), open_gltf(tmp_path / "held.glb"))
    before, after = (file.document["meshes"][0]["extras"]["elastomorph"] for file in files)
    assert after["morphs"][:-1] == before["morphs"]
    assert after["correctives"][:-1] == before["correctives"]
    em.unbend(tmp_path / "held.glb", tmp_path / "back.glb")
    assert (tmp_path / "back.glb").read_bytes() == exported.read_bytes()


def test_its_clips_play_what_is_added(tmp_path: Path) -> None:
    em.write(tmp_path / "clips.glb", em.Rig(head(), ENDS), clips=True)
    hold_gltf(tmp_path / "clips.glb", tmp_path / "held.glb", adding("extra", LEAST))
    document = open_gltf(tmp_path / "held.glb").document
    count = len(document["meshes"][0]["extras"]["targetNames"])
    for animation in document["animations"]:
        (sampler,) = (animation["samplers"][own["sampler"]] for own in animation["channels"])
        keys, weights = (document["accessors"][sampler[k]]["count"] for k in ("input", "output"))
        assert weights == count * keys


@pytest.mark.parametrize("kind", ["exported", "straight", "bent"])
def test_what_is_held_can_be_held_again(
    kind: str, exported: Path, straight: Path, tmp_path: Path
) -> None:
    """What was there stays beside what is added; where nothing is, nothing is written."""
    source = {"exported": exported, "straight": straight}.get(kind, tmp_path / "bent.glb")
    if kind == "bent":
        em.bend(straight, source)
    first, second, third = (tmp_path / f"{number}.glb" for number in range(3))
    hold_gltf(source, first, adding("extra", HINGE))
    report = hold_gltf(first, second, adding("more", LEAST))
    assert_plays(second, ("extra", HINGE), ("more", LEAST), bent=kind != "straight")
    assert report.output == second
    assert hold_gltf(second, third, lambda rig: rig).output is None
    assert not third.exists()


@pytest.mark.parametrize("most", [None, 7])
def test_what_is_held_can_be_bent(straight: Path, tmp_path: Path, most: int | None) -> None:
    """Its correctives stay, whichever bends there is room for."""
    hold_gltf(straight, tmp_path / "held.glb", adding("extra", HINGE))
    em.bend(tmp_path / "held.glb", tmp_path / "bent.glb", max_targets=most)
    if most is None:
        assert_plays(tmp_path / "bent.glb", ("extra", HINGE))
    found = em.read_rig(tmp_path / "bent.glb")
    assert found.sliders.correctives["extra"] == HINGE
    names = open_gltf(tmp_path / "bent.glb").document["meshes"][0]["extras"]["targetNames"]
    assert most is None or len(names) <= most
    em.unbend(tmp_path / "bent.glb", tmp_path / "back.glb")
    assert (tmp_path / "back.glb").read_bytes() == straight.read_bytes()


def test_a_bend_of_named_targets_keeps_correctives(straight: Path, tmp_path: Path) -> None:
    hold_gltf(straight, tmp_path / "held.glb", adding("extra", HINGE))
    em.bend(tmp_path / "held.glb", tmp_path / "bent.glb", only=["jawOpen"])
    found = em.read_rig(tmp_path / "bent.glb")
    assert json.dumps(found.sliders.correctives["extra"].entry()) == json.dumps(HINGE.entry())
    assert not found.pair_bends()
