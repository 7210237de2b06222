"""Correctives are added to a character in its own file: bent or not, and again."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from small_characters import flap_character
from test_bend_clips import TIMES, clip, pointing, sampler

import elastomorph as em
from elastomorph.bending.gltf import hold_gltf
from elastomorph.io.gltf.accessors import read_floats
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


def both(law: em.Corrective) -> Callable[[em.Rig], em.Rig]:
    """Return what adds a corrective that lifts all of a face by 1."""

    def held(rig: em.Rig) -> em.Rig:
        target = rig.neutral.with_vertices(rig.neutral.vertices + [0.0, 0.0, 1.0])
        shape = em.interpolate(rig.neutral, target, "linear")
        return em.Rig(rig.neutral, {**rig.morphs, "both": shape}, correctives={"both": law})

    return held


@pytest.mark.parametrize("law", ["min", "product"])
@pytest.mark.parametrize("second", ["LINEAR", "STEP"])
def test_weights_that_pointers_move_one_by_one_play_together(
    tmp_path: Path, law: str, second: str
) -> None:
    """Also where their keys are at other times; what nothing moves is at its default."""
    file = flap_character(teeth=False)
    ramp, jump = np.array([0.0, 1.0, 0.25]), np.array([0.25, 0.75, 0.5])
    channels = [(k, pointing(f"/nodes/0/weights/{k}")) for k in range(2)]
    samplers = [sampler(file, ramp), sampler(file, jump, second)]
    later = [0.0, 1.0, 2.0]
    samplers[1]["input"] = file.array(later, min=[0.0], max=[2.0])
    clip(file, channels, samplers)
    clip(file, channels[:1], samplers[:1])
    file.json["meshes"][0]["weights"] = [0.0, 0.5]
    path = file.write(tmp_path / "character.glb")
    hold_gltf(path, tmp_path / "held.glb", both(em.Corrective(("open", "slide"), law)))
    held = open_gltf(tmp_path / "held.glb")

    def played(number: int, when: np.ndarray) -> np.ndarray:
        animation = held.document["animations"][number]
        channel = animation["channels"][-1]
        pointer = channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"]
        assert pointer == "/nodes/0/weights/2"
        own = animation["samplers"][channel["sampler"]]
        keys = [read_floats(held, own[k], 1, "a test")[:, 0] for k in ("input", "output")]
        return np.interp(when, *keys)

    when = np.linspace(0, 2, 81)
    when = when[np.abs(when - 1) > 0.01]  # a jump takes a moment
    opened = np.interp(when, TIMES, ramp)
    slid = jump[np.searchsorted(later, when, side="right") - 1]
    if second == "LINEAR":
        slid = np.interp(when, later, jump)
    slid[-1] = jump[-1]
    join = np.minimum if law == "min" else np.multiply
    away = np.abs(played(0, when) - join(opened, slid))
    assert away[when < 1.99].max() <= 2e-4
    np.testing.assert_allclose(played(1, when), join(opened, 0.5), atol=2e-4)


def test_a_mesh_without_a_driver_is_named(tmp_path: Path) -> None:
    path = flap_character().write(tmp_path / "character.glb")
    law = em.Corrective(("open", "slide"), "min")
    with pytest.warns(em.ElastomorphWarning, match="'teeth' has no target 'slide'"):
        hold_gltf(path, tmp_path / "held.glb", both(law))
