"""What `bend` writes fits the schema, and engines bend whole characters by it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from engines import require_bent
from kit import strict_schema

import elastomorph as em
from acceptance.gltf_file import GltfFile
from acceptance.posing import Pose, Scene
from acceptance.runtime import bent_weights
from character_makers import make
from elastomorph.io.gltf import read_glb

SLIDERS = {
    "jawOpen": 0.5,
    "mouthSmileLeft": 1.2,
    "eyeBlinkLeft": 0.6,
    "eyeLookDownLeft": 0.5,
    "jawLeft": -0.2,
    "more": 1.0,
}


# Of a beam, much is a multiple of the target.
@pytest.mark.parametrize(("method", "fold"), [("auto", False), ("beam", True)])
@pytest.mark.parametrize("name", ["skinned", "mirrored-embedded", "vrm1"])
def test_characters_are_bent_by_what_their_extras_say(
    name: str, method: str, fold: bool, tmp_path: Path
) -> None:
    """Several meshes and primitives, placed by nodes and skins; one set of sliders for all."""
    source = make(name, tmp_path)
    bent = tmp_path / f"bent{source.suffix}"
    em.bend(source, bent, method=method, fold=fold)
    meshes = GltfFile.read(bent).meshes
    stored = [mesh.get("extras", {}).get("elastomorph") for mesh in meshes]
    described = [own for own in stored if own]
    assert {own["version"] for own in described} == {2 if fold else 1}
    for own in described:
        strict_schema().validate(own)
    for player in ("three.js", "Babylon.js"):
        require_bent(player, bent, SLIDERS, tmp_path)


def test_python_reads_the_folds_of_a_character(tmp_path: Path) -> None:
    """What it poses is what the extras ask for, mesh by mesh."""
    bent = tmp_path / "bent.glb"
    em.bend(make("skinned", tmp_path), bent, method="beam", fold=True)
    scene = Scene(GltfFile.read(bent))
    asked = {}
    for number in scene.faces:
        extras = scene.file.meshes[scene.file.nodes[number]["mesh"]]["extras"]
        asked[number] = bent_weights(extras.get("elastomorph"), extras["targetNames"], SLIDERS)
    expected = np.concatenate(list(scene.posed(Pose(asked)).values()))
    rig = read_glb(bent)
    known = {name: value for name, value in SLIDERS.items() if name in rig.sliders.names}
    found = rig.pose(known)[: len(expected)]  # then what has no targets
    np.testing.assert_allclose(found, expected, atol=1e-6)
