"""What `bend` writes fits the schema, and engines bend whole characters by it."""

from __future__ import annotations

import json
import subprocess
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
from foreign_files import chunks_of, glb
from needs import WEB, node
from validator import complaints

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


@pytest.mark.parametrize(("method", "fold"), [("auto", False), ("beam", True)])
def test_targets_that_share_their_name_are_bent_each_by_its_own_curves(
    method: str, fold: bool, tmp_path: Path
) -> None:
    """Their names stay what they were; sliders of people's programs have different ones."""
    source = make("skinned", tmp_path)
    document, blob = chunks_of(source)
    for mesh in document["meshes"]:
        names = mesh.get("extras", {}).get("targetNames", [])
        names[:] = ["open" if "jaw" in name or "eye" in name else name for name in names]
    source.write_bytes(glb(document, blob))
    bent = tmp_path / "bent.glb"
    report = em.bend(source, bent, method=method, fold=fold)
    assert {"open", "open_2", "open_3"} <= {own.name for own in report.bent}
    assert complaints(bent) == complaints(source)
    for mesh in GltfFile.read(bent).meshes:
        extras = mesh.get("extras", {})
        if "elastomorph" in extras:
            strict_schema().validate(extras["elastomorph"])
    values = {"open": 0.5, "open_2": 0.7, "open_3": 0.4, "mouthSmileLeft": 1.2}
    for player in ("three.js", "Babylon.js"):
        require_bent(player, bent, values, tmp_path)
    require_posed(bent, values)


def test_python_reads_the_folds_of_a_character(tmp_path: Path) -> None:
    """What it poses is what the extras ask for, mesh by mesh."""
    bent = tmp_path / "bent.glb"
    em.bend(make("skinned", tmp_path), bent, method="beam", fold=True)
    require_posed(bent, SLIDERS)


def require_posed(bent: Path, sliders: dict[str, float]) -> None:
    """Python poses a file as the extras of each of its meshes ask for."""
    scene = Scene(GltfFile.read(bent))
    asked = {}
    for number in scene.faces:
        extras = scene.file.meshes[scene.file.nodes[number]["mesh"]]["extras"]
        asked[number] = bent_weights(extras.get("elastomorph"), extras["targetNames"], sliders)
    expected = np.concatenate(list(scene.posed(Pose(asked)).values()))
    rig = read_glb(bent)
    known = {name: value for name, value in sliders.items() if name in rig.sliders.names}
    found = rig.pose(known)[: len(expected)]  # then what has no targets
    np.testing.assert_allclose(found, expected, atol=1e-6)


@pytest.mark.parametrize("name", ["vrm0", "vrm1"])
def test_a_vrm_player_shows_what_it_showed_and_bends_with_one_line(
    name: str, tmp_path: Path
) -> None:
    """Expressions set the sliders of whole files; the adapter follows, frame after frame."""
    source = make(name, tmp_path)
    bent = tmp_path / "bent.vrm"
    em.bend(source, bent)
    before, after = (played(path, "aa=0.5", "happy=0.6") for path in (source, bent))
    assert after.keys() == before.keys()
    moved = 0.0
    for number, shown in after.items():
        plain = before[number]["alone"]
        assert any(plain)
        assert shown["alone"] == [*plain, *[0] * (len(shown["alone"]) - len(plain))]
        file = GltfFile.read(bent)
        extras = file.meshes[file.nodes[number]["mesh"]]["extras"]
        names = extras["targetNames"]
        sliders = dict(zip(names, plain, strict=False))
        asked = bent_weights(extras.get("elastomorph"), names, sliders)
        np.testing.assert_allclose(shown["bent"], asked, atol=1e-12)
        moved = max(moved, *np.abs(asked[len(plain) :]), 0.0)
    assert moved > 0.1


def played(path: Path, *values: str) -> dict[int, dict[str, list[float]]]:
    """Weights that a VRM player sets by number of the node, of its last primitive."""
    command = [node("three", "@pixiv/three-vrm-core"), str(WEB / "checks" / "vrm.mjs"), str(path)]
    done = subprocess.run(
        [*command, *values], capture_output=True, text=True, check=False, timeout=100
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return {own["node"]: own for own in json.loads(done.stdout)}


def test_what_three_js_exports_keeps_its_curves(tmp_path: Path) -> None:
    """Its exporter gives the extras of meshes to their nodes, where all that read them look too."""
    bent, exported = tmp_path / "bent.glb", tmp_path / "exported.glb"
    em.bend(make("plain", tmp_path), bent)
    program = [node("three"), str(WEB / "checks" / "three_export.mjs"), str(bent), str(exported)]
    done = subprocess.run(program, capture_output=True, text=True, check=False, timeout=100)
    assert done.returncode == 0, done.stderr[-2000:]
    before, after = read_glb(bent), read_glb(exported)
    assert any(len(morph.bends) for morph in before.morphs.values())
    np.testing.assert_allclose(after.pose(known(after)), before.pose(known(before)), atol=1e-6)
    with pytest.raises(em.FormatError, match="bent already"):
        em.bend(exported, tmp_path / "again.glb")
    document, blob = chunks_of(exported)
    for own in document["nodes"]:
        own.pop("extras", None)
    exported.write_bytes(glb(document, blob))
    back = tmp_path / "back.glb"
    report = em.bend(exported, back, source=bent)
    assert len(report.bent) == sum(bool(len(morph.bends)) for morph in before.morphs.values())
    np.testing.assert_array_equal(read_glb(back).pose(known(after)), after.pose(known(after)))
    assert complaints(back) == complaints(exported)
    for player in ("three.js", "Babylon.js"):
        require_bent(player, back, SLIDERS, tmp_path)


def known(rig: em.Rig) -> dict[str, float]:
    return {name: value for name, value in SLIDERS.items() if name in rig.sliders.names}
