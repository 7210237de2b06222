"""three.js, Babylon.js and Blender show characters as the specification of glTF says.

Needs Node.js and the packages of ``web``; Blender is skipped where it is not installed, see
``make test-blender``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from acceptance.clips import key_times, played
from acceptance.gltf_file import GltfFile
from acceptance.judging import Pair
from acceptance.players import PLAYERS, Request, as_shown, command, plain, shown
from acceptance.playing import play
from acceptance.posing import Pose, Scene
from character_makers import make
from needs import NO_NODE

pytestmark = [pytest.mark.slow, pytest.mark.players]  # programs start, three for each test

# What single precision leaves of a head 0.2 m high, 1.6 m above the ground: in metres, and as a
# fraction of the 0.16 m between the vertices that move.
ROUNDED = 1e-6
ROUNDED_OF_D = 5e-6


@pytest.fixture(params=PLAYERS)
def player(request: pytest.FixtureRequest) -> str:
    """The name of an installed program."""
    name = str(request.param)
    if command(name) is None:
        pytest.skip(
            "needs Blender as a module: 'make test-blender'" if name == "Blender" else NO_NODE
        )
    return name


@pytest.mark.parametrize(
    "name",
    ["placed-files", "mirrored-embedded", "posed", "separate", "shared-vertices", "quantized"],
)
def test_it_shows_morph_targets_nodes_and_skins(name: str, player: str, tmp_path: Path) -> None:
    scene = Scene(GltfFile.read(make(name, tmp_path)))
    random = np.random.default_rng(1)
    weights = {node: random.random(scene.count(node)) for node in scene.faces}
    file = plain(scene.file, tmp_path / "plain.glb")
    (found,) = shown(player, file, [Request(weights)], tmp_path)
    expected = as_shown(scene, player, Pose(weights))
    assert list(found) == list(expected)
    for node, rows in expected.items():
        assert np.abs(found[node] - rows).max() <= ROUNDED


def test_it_plays_clips_at_keys_and_between(player: str, tmp_path: Path) -> None:
    scene = Scene(GltfFile.read(make("skinned", tmp_path)))
    names = ["step", "linear", "cubic", "shared"]
    if player == "Blender":  # it drops the tangents
        names.remove("cubic")
    clips = [own["name"] for own in scene.file.animations]
    rest = {node: scene.weights(node, Pose()) for node in scene.faces}
    asked = []
    for clip in map(clips.index, names):
        keys = key_times(scene.file, clip)
        moments = [*keys, *((keys[:-1] + 2 * keys[1:]) / 3)]
        asked += [Request(rest, clip, t) for t in moments]
    file = plain(scene.file, tmp_path / "plain.glb")
    for request, found in zip(asked, shown(player, file, asked, tmp_path), strict=True):
        assert request.clip is not None
        pose = played(scene, request.clip, request.time)
        pose.weights = rest | pose.weights
        for node, rows in as_shown(scene, player, pose).items():
            where = (clips[request.clip], request.time, node)
            assert np.abs(found[node] - rows).max() <= ROUNDED, where


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("bent")


@pytest.fixture(scope="module")
def pair(folder: Path) -> Pair:
    """A skinned character with clips of every interpolation, and what bending makes of it."""
    source = make("skinned", folder)
    em.bend(source, folder / "bent.glb", keys_tolerance=1e-4)
    return Pair(source, folder / "bent.glb", folder)


def test_a_bent_character_plays_bent(pair: Pair, player: str, folder: Path) -> None:
    found = play(pair, player, folder)
    assert found.poses >= 30
    assert found.posed <= ROUNDED_OF_D
    assert found.ends <= 1e-6
    # The path of ``auto``, which is a hundred times farther from the straight line.
    assert found.between <= 1e-5 + ROUNDED_OF_D
    assert found.straight >= 1e-2
    assert found.unplayed == (["cubic"] if player == "Blender" else [])
    assert found.moments >= 30
    assert found.keys <= ROUNDED_OF_D
    assert found.clips <= 1e-4 + ROUNDED_OF_D


def test_a_folded_character_plays_at_its_pace(player: str, tmp_path: Path) -> None:
    """No target is added: the clip's keys hold what the curve makes of each weight."""
    source, bent = make("scaled", tmp_path), tmp_path / "folded.glb"
    report = em.bend(source, bent, method="ease:2", fold=True, keys_tolerance=1e-4)
    assert report.targets == report.targets_before
    pair = Pair(source, bent, tmp_path)
    found = play(pair, player, tmp_path)
    assert found.moments >= 10
    assert found.ends <= 1e-6
    assert max(found.posed, found.keys) <= ROUNDED_OF_D
    assert found.clips <= 1e-4 + ROUNDED_OF_D
    # Not where the straight clip was: t² of the way is up to a quarter of a target short of t.
    assert found.off_straight >= 1e-3


def test_clips_by_pointers_play_bent(tmp_path: Path) -> None:
    """In Babylon.js, which knows pointers to the weights of a node, though not of a mesh."""
    if command("Babylon.js") is None:
        pytest.skip(NO_NODE)
    source, bent = make("pointer", tmp_path), tmp_path / "bent.glb"
    em.bend(source, bent, keys_tolerance=1e-4)
    found = play(Pair(source, bent, tmp_path), "Babylon.js", tmp_path)
    assert found.moments >= 10
    assert found.keys <= ROUNDED_OF_D
    assert found.clips <= 1e-4 + ROUNDED_OF_D
    assert found.off_straight >= 1e-3
