"""The graphics card poses faces as `Rig.pose` does, to 1e-4 of D."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from faces import METHODS, Faces, distances, glb, twice
from visiting import COARSE, SMALL, Visit, positions, update

import elastomorph as em
from character_makers import make
from elastomorph.io import read_rig
from elastomorph.io.gltf import read_glb
from elastomorph.rig import Rig
from elastomorph.viewer import Scene, SceneModel, comparison_scene
from needs import extra

WITHIN = 1e-4  # of D

POSES: dict[str, tuple[Mapping[str, float], float]] = {
    "rest": ({}, 1.0),
    "one": ({"jawOpen": 0.37}, 1.0),
    "several": ({"jawOpen": 0.8, "eyeBlink_L": 0.31, "mouthSmile_R": 0.55, "browInnerUp": 1}, 1.0),
    "half way": ({"jawOpen": 1, "mouthSmile_L": 0.7, "eyeBlink_R": 0.9}, 0.46),
    "beyond": ({"jawOpen": 1.4, "eyeBlink_L": -0.3, "mouthFunnel": 1.5}, 1.0),
    "beyond half way": ({"jawOpen": 1.5, "eyeBlink_L": -0.5}, 0.8),
    "driven": ({"jawOpen": 0.9, "mouthSmile_L": 0.6}, 0.7),
    "driven with its own": ({"jawOpen": 0.9, "pursed": 0.8}, 0.9),
    "its own alone": ({"pursed": 1}, 1.0),
    "at the start": ({"jawOpen": 1, "mouthSmile_L": 1}, 0.0),
}


def posed(rig: Rig, weights: Mapping[str, float], t: float) -> np.ndarray:
    """What the sliders mean: a path at t times the weight."""
    return rig.pose({name: t * weight for name, weight in weights.items()})


@pytest.mark.parametrize("method", METHODS)
def test_poses_of_every_method(visit: Visit, faces: Faces, method: str) -> None:
    rig = faces.rigs[method]
    page = visit(faces.together, size=SMALL)
    number = list(faces.rigs).index(method)
    update(page, arrangement="single", shown=[number])
    least = []
    for name, (weights, t) in POSES.items():
        update(page, weights=weights, t=t)
        found = positions(page, number, len(rig.neutral.vertices))
        wrong = distances(found, posed(rig, weights, t)).max() / faces.diameter
        assert wrong < WITHIN, f"{name}: {wrong:.1e} of D off"
        least.append(distances(found, rig.neutral.vertices).max())
    assert np.median(least) > 100 * WITHIN * faces.diameter, "the poses hardly move anything"


def test_methods_differ_where_they_should(visit: Visit, faces: Faces) -> None:
    """Beside the straight line the picture shows the curved path, not another straight one."""
    page = visit(faces.together, size=SMALL)
    update(page, weights={"jawOpen": 1}, t=0.5)
    count = len(faces.neutral.vertices)
    straight, curved = (positions(page, number, count) for number in (0, 1))
    apart = distances(straight, curved).max()
    assert apart > 0.005 * faces.diameter
    update(page, t=1)
    straight, curved = (positions(page, number, count) for number in (0, 1))
    assert distances(straight, curved).max() < WITHIN * faces.diameter


def test_a_driven_corrective_has_no_slider(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    assert page.get_by_role("slider", name="jawOpen", exact=True).count() == 1
    assert page.get_by_role("slider", name="pursed", exact=True).count() == 1
    assert page.get_by_role("slider", name="squash", exact=True).count() == 0


def test_an_ordinary_file(visit: Visit, faces: Faces) -> None:
    """Morph targets without anything of elastomorph's: V₀ + Σ t w Δ, and every target a slider."""
    rig = faces.rigs["linear"]
    page = visit(Scene((SceneModel("plain", "rig", ordinary(glb(rig))),), "Plain"), size=SMALL)
    check_straight(visit, page, rig, {"jawOpen": 0.8, "squash": 0.5, "eyeBlink_L": 1.2})


def test_targets_that_share_a_name(visit: Visit, tmp_path: Path) -> None:
    """Each bends by its own curves, in all meshes of a character."""

    def rename(document: dict[str, Any]) -> None:
        for mesh in document["meshes"]:
            names = mesh.get("extras", {}).get("targetNames", [])
            names[:] = ["open" if "jaw" in name or "eye" in name else name for name in names]

    (tmp_path / "a.glb").write_bytes(rewritten(make("plain", tmp_path).read_bytes(), rename))
    em.bend(tmp_path / "a.glb", tmp_path / "b.glb", method="beam", fold=True)
    content = (tmp_path / "b.glb").read_bytes()
    rig = read_glb(tmp_path / "b.glb")
    page = visit(Scene((SceneModel("same", "rig", content),), "Same names"), size=SMALL)
    for name in ("open", "open_2", "open_3"):
        update(page, weights={name: 0.5}, t=1)
        found = positions(page, 0, len(rig.neutral.vertices))
        assert distances(found, posed(rig, {name: 0.5}, 1)).max() < WITHIN * rig.neutral.diameter
        straight = (rig.neutral.vertices + rig.pose({name: 1})) / 2
        assert distances(found, straight).max() > 1e-3 * rig.neutral.diameter


def test_a_fold_of_the_weight(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """A bend that is a multiple of its target, kept as a curve of the weight of the target."""

    def fold(document: dict[str, Any]) -> None:
        stored = document["meshes"][0]["extras"]["elastomorph"]
        stored["version"] = 2
        for morph in stored["morphs"]:
            if morph["name"] == "jawOpen":
                morph["fold"] = {"breaks": [0, 1], "coefficients": [[0, 0.4, -0.4]]}

    content = rewritten(glb(faces.rigs["linear"]), fold)
    (tmp_path / "folded.glb").write_bytes(content)
    rig = read_glb(tmp_path / "folded.glb")
    page = visit(Scene((SceneModel("folded", "rig", content),), "Folded"), size=SMALL)
    for value in (0.5, 1.3):
        update(page, weights={"jawOpen": value}, t=1)
        found = positions(page, 0, len(rig.neutral.vertices))
        expected = posed(rig, {"jawOpen": value}, 1)
        assert distances(found, expected).max() < WITHIN * faces.diameter
        straight = posed(faces.rigs["linear"], {"jawOpen": value}, 1)
        assert distances(found, straight).max() > 0.005 * faces.diameter


def test_a_face_of_two_meshes_bends_as_one(visit: Visit, faces: Faces) -> None:
    """Each mesh describes its own targets; one slider moves both along their paths."""
    rig = faces.rigs["beam:2"]

    content = rewritten(glb(rig), twice)
    page = visit(Scene((SceneModel("two", "rig", content),), "Two"), size=SMALL)
    pose = {"jawOpen": 0.5, "pursed": 0.5}
    update(page, weights=pose, t=1)
    expected = posed(rig, pose, 1)
    count = page.evaluate("elastomorph.models()[0].vertices")
    assert count % 2 == 0
    found = positions(page, 0, count)
    for half in (found[: len(expected)], found[count // 2 :][: len(expected)]):
        assert distances(half, expected).max() < WITHIN * faces.diameter


@pytest.mark.parametrize("name", ["skinned", "posed", "scaled"])
def test_a_bent_character(visit: Visit, tmp_path: Path, name: str) -> None:
    """Its meshes where joints hold them, each with what it says of its own targets."""
    em.bend(make(name, tmp_path), tmp_path / "bent.glb")
    content = (tmp_path / "bent.glb").read_bytes()
    rig = read_glb(tmp_path / "bent.glb")
    page = visit(Scene((SceneModel("bent", "rig", content),), "Bent"), size=SMALL)
    pose = {"jawOpen": 0.5, "eyeBlinkLeft": 0.4, "eyeLookDownLeft": 0.5, "mouthSmileLeft": 1.2}
    update(page, clip=None)  # it opens on its clip
    update(page, weights=pose, t=1)
    found = positions(page, 0, len(rig.neutral.vertices))
    expected = posed(rig, pose, 1)
    deltas = {name: rig.morphs[name].delta for name in pose}
    straight = rig.neutral.vertices + sum(pose[name] * deltas[name] for name in pose)
    assert distances(found, expected).max() < WITHIN * rig.neutral.diameter
    assert distances(expected, straight).max() > 15 * WITHIN * rig.neutral.diameter


@pytest.mark.realdata
def test_an_ordinary_file_of_real_data(visit: Visit, data_dir: Path, tmp_path: Path) -> None:
    """A head with ARKit's shapes from FBX, as other programs write it."""
    extra("ufbx", "fbx")
    rig = read_rig(data_dir / "facecap" / "FaceCapHeadGeneric.fbx")
    em.write(tmp_path / "head.glb", rig)
    plain = ordinary((tmp_path / "head.glb").read_bytes())
    page = visit(Scene((SceneModel("facecap", "rig", plain),), "Face Cap"), size=SMALL)
    names = [name for name in rig.names if not rig.morphs[name].bends.any()]
    chosen = dict(
        zip(names[:: max(1, len(names) // 6)], (0.9, 0.4, 1.3, -0.2, 0.7, 1), strict=False)
    )
    check_straight(visit, page, rig, chosen)


def check_straight(visit: Visit, page, rig: Rig, weights: Mapping[str, float]) -> None:
    for t in (1.0, 0.35):
        update(page, weights=weights, t=t)
        truth = rig.neutral.vertices + sum(
            t * weight * (rig.morphs[name].target.vertices - rig.neutral.vertices)
            for name, weight in weights.items()
        )
        found = positions(page, 0, len(truth))
        assert distances(found, truth).max() < WITHIN * rig.neutral.diameter
        assert distances(found, rig.neutral.vertices).max() > 0.005 * rig.neutral.diameter


@pytest.mark.realdata
@pytest.mark.slow
def test_the_real_rig(visit: Visit, data_dir: Path) -> None:
    """26,719 vertices, a quarter of the expressions at once, curved and straight."""
    folder = data_dir / "ict-facekit"
    neutral = em.read(folder / "generic_neutral_mesh.obj")
    chosen = [file.stem for file in sorted(folder.glob("*.obj"))[::4] if "neutral" not in file.stem]
    targets = {name: em.read(folder / f"{name}.obj") for name in chosen}
    rigs = {}
    for method in ("linear", "beam:2"):
        to = em.prepare(neutral, method)
        rigs[method] = Rig(neutral, {name: to(target) for name, target in targets.items()})
    page = visit(comparison_scene(rigs, unit="cm"), size=SMALL)
    weights = {name: round(0.3 + 0.9 * i / len(chosen), 3) for i, name in enumerate(chosen)}
    for t in (1.0, 0.55):
        update(page, weights=weights, t=t)
        for number, rig in enumerate(rigs.values()):
            truth = posed(rig, weights, t)
            found = positions(page, number, len(truth))
            assert distances(found, truth).max() < WITHIN * neutral.diameter
    readout = page.evaluate("elastomorph.readout()")
    assert readout["gpu"]
    assert readout["targets"] >= 3 * len(chosen)


def ordinary(file: bytes) -> bytes:
    """A GLB file without what elastomorph wrote into its mesh, as other programs write them."""

    def forget(document: dict[str, Any]) -> None:
        for mesh in document["meshes"]:
            assert mesh["extras"].pop("elastomorph")

    return rewritten(file, forget)


def rewritten(file: bytes, change: Callable[[dict[str, Any]], object]) -> bytes:
    """A GLB file after its document was changed."""
    length = struct.unpack_from("<I", file, 12)[0]
    document = json.loads(file[20 : 20 + length])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = file[20 + length :]
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest))
    return head + struct.pack("<I4s", len(text), b"JSON") + text + rest
