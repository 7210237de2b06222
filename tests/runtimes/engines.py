"""What three.js and Babylon.js show of a file that the package for JavaScript bends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from acceptance.gltf_file import GltfFile
from acceptance.players import Request, as_shown, command, plain, shown
from acceptance.posing import Pose, Scene
from acceptance.runtime import bent_weights, place
from needs import NO_NODE


def require_bent(player: str, path: Path, sliders: dict[str, float], folder: Path) -> None:
    """An engine whose sliders stand in the weights shows what `elastomorph` in the extras asks."""
    if command(player) is None:
        pytest.skip(NO_NODE)
    scene = Scene(GltfFile.read(path))
    set_by_player, asked = {}, {}
    for number in scene.faces:
        extras = scene.file.meshes[scene.file.nodes[number]["mesh"]]["extras"]
        names, stored = extras["targetNames"], extras.get("elastomorph")
        slider_of = list(names)
        for morph in stored["morphs"] if stored else []:
            if "target" in morph:
                slider_of[place(morph, names)] = morph["name"]
        set_by_player[number] = np.array([sliders.get(name, 0.0) for name in slider_of])
        asked[number] = bent_weights(stored, names, sliders)
    (found,) = shown(
        player, plain(scene.file, folder / "plain.glb"), [Request(set_by_player, bend=True)], folder
    )
    expected = as_shown(scene, player, Pose(asked))
    straight = as_shown(scene, player, Pose(set_by_player))
    assert found.keys() == expected.keys()
    for number, rows in expected.items():
        np.testing.assert_allclose(found[number], rows, atol=3e-6)
    assert max(np.abs(straight[n] - rows).max() for n, rows in expected.items()) > 1e-4
