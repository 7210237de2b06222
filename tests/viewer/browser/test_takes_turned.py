"""Takes that turn the head, from file to page to file."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from faces import glb
from projecting import as_turned, spots
from takes import alone, named_rig, open_files
from test_takes_saved import save
from visiting import Visit, update

import elastomorph as em
from elastomorph.draw.head import neck_of
from elastomorph.io.gltf import write_glb
from elastomorph.rig.performance import HeadTurn, head_quaternions
from foreign_files import chunks_of
from foreign_files import glb as container
from needs import WEB, node

SIZE = (700, 640)
ANGLES = np.array([[0, 0, 0], [0.4, -0.2, 0.1], [-0.6, 0.3, 0.2]])
WEIGHTS = np.array([[0.1, 0.0], [0.2, 0.5], [0.4, 1.0]])
TIMES = np.arange(3) / 30


def take() -> em.Performance:
    names = ("jawOpen", "mouthFunnel", "HeadYaw", "HeadPitch", "HeadRoll")
    return em.Performance(names, TIMES, np.hstack([WEIGHTS, ANGLES]), 30)


def test_a_file_of_the_page_turns_the_head(visit: Visit, tmp_path: Path) -> None:
    """A bare face hangs in its neck, as one that the command writes; twice makes no second node."""
    rig = named_rig(("jawOpen", "mouthFunnel"))
    em.write_performance(tmp_path / "turning.csv", take())
    page = visit(alone(glb(rig)), size=SIZE)
    open_files(page, tmp_path / "turning.csv")
    path = save(page, "Save GLB", tmp_path)
    check = [node("gltf-validator"), str(WEB / "checks" / "validate.mjs"), str(path)]
    done = subprocess.run(check, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    found = em.read_performance(f"{path}", clip="turning")
    np.testing.assert_allclose(found.head, ANGLES, atol=1e-6)
    head = chunks_of(path)[0]["nodes"][chunks_of(path)[0]["scenes"][0]["nodes"][0]]
    neck = neck_of(rig.neutral, rig.morphs.values())
    np.testing.assert_allclose(head["translation"], neck, atol=1e-6)
    read = em.read_rig(path).neutral.vertices
    np.testing.assert_allclose(read, rig.neutral.vertices, atol=1e-6)

    again = visit(alone(path.read_bytes()), size=SIZE)
    open_files(again, tmp_path / "turning.csv")
    second = save(again, "Save GLB", tmp_path)
    assert chunks_of(second)[0]["nodes"] == chunks_of(path)[0]["nodes"]
    found = em.read_performance(f"{second}", clip="turning")
    np.testing.assert_allclose(found.head, ANGLES, atol=1e-6)


def test_a_clip_of_a_file_turns_the_head_on_the_page(visit: Visit, tmp_path: Path) -> None:
    rig = named_rig(("jawOpen", "mouthFunnel"))
    turn = HeadTurn(neck_of(rig.neutral, rig.morphs.values()), ANGLES)
    write_glb(tmp_path / "a.glb", rig, animation=(TIMES, WEIGHTS, "talk"), turn=turn)
    page = visit(alone((tmp_path / "a.glb").read_bytes()), size=SIZE)
    update(page, clip="talk", clipTime=float(TIMES[1]))
    points = rig.neutral.vertices
    turned = spots(page, points)
    update(page, headTurns=False)
    straight = spots(page, points)
    wanted = spots(page, as_turned(points, rig, ANGLES[1]))
    np.testing.assert_allclose(turned, wanted, atol=0.02)
    assert np.abs(turned - straight).max() > 1
    page.get_by_role("button", name="Timeline").click()
    back = em.read_performance(save(page, "Save CSV", tmp_path))
    assert back.names[-3:] == ("HeadYaw", "HeadPitch", "HeadRoll")
    np.testing.assert_allclose(back.head, ANGLES, atol=1e-6)


@pytest.mark.parametrize("kind", ["LINEAR", "STEP", "CUBICSPLINE", "at rest"])
def test_clips_turn_the_head_as_python_reads_them(visit: Visit, tmp_path: Path, kind: str) -> None:
    """Past half a turn and past straight down, in steps and along splines, with a face at rest."""
    rig = named_rig(("jawOpen", "mouthFunnel"))
    angles = np.array([[2.7, 1.1, 0], [3.4, 1.8, 0.2], [3.7, 2.2, 0.5]])
    weights = 0 * WEIGHTS if kind == "at rest" else WEIGHTS
    path = tmp_path / "a.glb"
    turn = HeadTurn(neck_of(rig.neutral, rig.morphs.values()), angles)
    write_glb(path, rig, animation=(TIMES, weights, "talk"), turn=turn)
    document, blob = chunks_of(path)
    sampler = document["animations"][0]["samplers"][1]
    if kind == "STEP":
        sampler["interpolation"] = kind
    if kind == "CUBICSPLINE":
        keys = np.zeros((3, 3, 4), dtype="<f4")
        keys[:, 1], keys[:, ::2] = head_quaternions(angles), [[[3, -2, 1, 0]]]
        view = {"buffer": 0, "byteOffset": len(blob), "byteLength": keys.nbytes}
        document["bufferViews"].append(view)
        number = len(document["bufferViews"]) - 1
        float32 = {"componentType": 5126, "count": 9, "type": "VEC4", "bufferView": number}
        document["accessors"].append(float32)
        sampler |= {"interpolation": kind, "output": len(document["accessors"]) - 1}
        blob += keys.tobytes()
        document["buffers"][0]["byteLength"] = len(blob)
    path.write_bytes(container(document, blob))
    page = visit(alone(path.read_bytes()), size=SIZE)
    update(page, clip="talk", clipTime=0.0)
    page.get_by_role("button", name="Timeline").click()
    back = em.read_performance(save(page, "Save CSV", tmp_path))
    wanted = em.read_performance(path)
    np.testing.assert_allclose(back.times, wanted.times, atol=1e-6)
    np.testing.assert_allclose(back.head, wanted.head, atol=1e-4)


@pytest.mark.parametrize("kind", ["VRM 1", "named"])
def test_a_bone_of_a_character_turns(visit: Visit, tmp_path: Path, kind: str) -> None:
    """Its own bone, whose rest is turned, and no node is added."""
    rig = named_rig(("jawOpen", "mouthFunnel"))
    path = tmp_path / "character.glb"
    path.write_bytes(glb(rig))
    document, blob = chunks_of(path)
    half = np.sqrt(0.5)
    document["nodes"] += [
        {"name": "neck", "rotation": [half, 0, 0, half], "children": [2]},
        {"name": "J_Bip_Head", "rotation": [0, 0, half, half], "translation": [0, 1, 0]},
    ]
    document["scenes"][0]["nodes"].append(1)
    if kind == "VRM 1":
        document["nodes"][2]["name"] = "C"
        bones = {"head": {"node": 2}}
        document["extensions"] = {"VRMC_vrm": {"humanoid": {"humanBones": bones}}}
    document["skins"] = [{"joints": [1, 2]}]
    path.write_bytes(container(document, blob))
    em.write_performance(tmp_path / "turning.csv", take())
    page = visit(alone(path.read_bytes()), size=SIZE)
    open_files(page, tmp_path / "turning.csv")
    saved = save(page, "Save GLB", tmp_path)
    assert chunks_of(saved)[0]["nodes"] == document["nodes"]
    found = em.read_performance(f"{saved}", clip="turning")
    np.testing.assert_allclose(found.head, ANGLES, atol=1e-6)
