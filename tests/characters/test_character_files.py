"""The characters that other tests bend: sound files, posed here as three.js poses them."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from acceptance.clips import key_times, played, sampled
from acceptance.gltf_file import GltfFile
from acceptance.posing import Pose, Scene
from acceptance.tools import unpacked
from character_makers import RECIPES, TARGETS, make
from character_skins import JOINTS
from character_variants import VARIANTS, variant
from face_parts import face_parts
from needs import WEB, node


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("characters")


@pytest.fixture(scope="module")
def files(folder: Path) -> dict[str, Path]:
    return {name: make(name, folder) for name in RECIPES}


def test_a_character_is_made_the_same_each_time(files: dict[str, Path], tmp_path: Path) -> None:
    for name, file in files.items():
        again = make(name, tmp_path)
        assert again.read_bytes() == file.read_bytes(), name


def test_the_parts_move_together_and_split_vertices_do_not_part() -> None:
    jaw = {name: part.moves["jawOpen"] for name, part in face_parts().items()}
    assert all(jaw[name].any() for name in ("head", "teeth"))
    head = face_parts()["head"]
    places, first = np.unique(head.positions, axis=0, return_inverse=True)
    assert len(places) < len(head.positions) - 50  # seams split vertices of the middle of the face
    for moved in head.moves.values():
        together = np.zeros_like(places)
        together[first] = moved
        assert np.array_equal(together[first], moved)


def test_the_validator_finds_no_errors(files: dict[str, Path]) -> None:
    names = [name for name in RECIPES if name != "old-names"]  # targets had no extras to begin with
    words = [node("gltf-validator"), str(WEB / "checks" / "validate.mjs")]
    done = subprocess.run(
        [*words, *(str(files[name]) for name in names)], capture_output=True, text=True, timeout=120
    )
    sums = [line for line in done.stdout.splitlines() if line.endswith("hints")]
    assert len(sums) == len(names), done.stderr
    assert all(": 0 errors" in line for line in sums), done.stdout


def test_all_stand_where_the_plain_one_stands(files: dict[str, Path]) -> None:
    """Storage, buffers, skins at rest and quantisation change nothing that is seen."""
    plain = _points(Scene(GltfFile.read(files["plain"])))
    same = ("skinned", "separate", "scaled", "pointer", "vrm1", "twice", "quantized")
    for name in same:
        found = _points(Scene(GltfFile.read(files[name])))[: len(plain)]
        # "separate" and the others of 32 bits round once; 16-bit fractions of 0.11 m round more.
        allowed = 3e-6 if name == "quantized" else 5e-7
        assert np.abs(found - plain).max() < allowed, name


def test_a_posed_skeleton_turns_the_head_rigidly(files: dict[str, Path]) -> None:
    """Where only the head joint holds, the pose is that of the joint, worked out by hand."""
    plain = _points(Scene(GltfFile.read(files["plain"])))
    posed = _points(Scene(GltfFile.read(files["posed"])))
    above = plain[:, 1] > 1.55
    a, b = np.radians(-8), np.radians(25)
    lean = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    look = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    hips, joint = np.array(JOINTS[0][2]), np.array(JOINTS[3][2])
    expected = hips + 1.1 * ((joint - hips + (plain[above] - joint) @ look.T) @ lean.T)
    assert np.abs(posed[above] - expected).max() < 1e-6


def test_clips_are_what_their_keys_say(files: dict[str, Path]) -> None:
    file = GltfFile.read(files["skinned"])
    scene = Scene(file)
    for clip, animation in enumerate(file.animations):
        kind = animation["name"]
        times = key_times(file, clip)
        assert times.tolist() == [0, 0.25, 0.5, 1, 1.25, 2]
        head = next(node for node in scene.faces if file.nodes[node]["name"] == "head node")
        at_keys = np.array([scene.weights(head, played(scene, clip, t)) for t in times])
        assert at_keys[3].tolist() == [1, 0, 0, 0, 0, 0, 0], kind
        before, after = at_keys[1], at_keys[2]
        half = scene.weights(head, played(scene, clip, 0.375))
        if kind == "step":
            assert np.array_equal(half, before)
        elif kind != "cubic":
            assert np.allclose(half, (before + after) / 2, atol=1e-12)
        else:  # a Hermite spline half way: the mean and an eighth of the difference of its slopes
            channel = animation["channels"][1]
            sampler = animation["samplers"][channel["sampler"]]
            keys = file.array(sampler["output"]).reshape(len(times), 3, -1)
            slopes = keys[1, 2] - keys[2, 0]
            assert np.allclose(half, (before + after) / 2 + 0.25 * slopes / 8, atol=1e-12)
            assert np.array_equal(sampled(file, sampler, 7, False, -1.0), keys[0, 1])


def test_three_js_poses_the_same_vertices(files: dict[str, Path], tmp_path: Path) -> None:
    """Morphed and skinned; positions before the transform of the node, as that program has them."""
    script = tmp_path / "pose.mjs"
    script.write_text(_POSE.replace("MODULES", (WEB / "node_modules").as_uri()))
    for name in ("posed", "scaled", "skinned"):
        file = GltfFile.read(files[name])
        scene = Scene(file)
        head = scene.faces[0]
        weights = np.linspace(0, 0.6, scene.count(head))
        ours = scene.posed(Pose(weights={head: weights}))[head, 0]
        words = [node("three"), str(script), str(files[name]), *map(str, weights)]
        done = subprocess.run(words, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        theirs = np.array(json.loads(done.stdout)).reshape(-1, 3)
        assert np.abs(theirs - ours).max() < 2e-6, name  # theirs are single precision


@pytest.mark.parametrize("name", VARIANTS)
def test_what_gltf_transform_makes_stands_in_the_same_place(
    files: dict[str, Path], folder: Path, name: str
) -> None:
    made = variant(files["skinned"], name, folder)
    read = unpacked(made, folder)
    found, whole = _points(Scene(read)), _points(Scene(GltfFile.read(files["skinned"])))
    assert np.abs(found.min(axis=0) - whole.min(axis=0)).max() < 2e-4
    assert np.abs(found.max(axis=0) - whole.max(axis=0)).max() < 2e-4
    assert set(TARGETS) == set(Scene(read).names(read.nodes[Scene(read).faces[0]]["mesh"]))


def _points(scene: Scene) -> np.ndarray:
    return np.concatenate(list(scene.posed(_at_rest(scene)).values()))


def _at_rest(scene: Scene) -> Pose:
    return Pose(weights={node: np.zeros(scene.count(node)) for node in scene.faces})


_POSE = """
import { readFile } from 'node:fs/promises';
import { Vector3, TextureLoader, Texture } from 'MODULES/three/build/three.module.js';
import { GLTFLoader } from 'MODULES/three/examples/jsm/loaders/GLTFLoader.js';
const [path, ...weights] = process.argv.slice(2);
const bytes = await readFile(path);
const content = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
const loader = new GLTFLoader();
loader.register(() => ({ name: 'no pictures', loadTexture: async () => new Texture() }));
const { scene } = await loader.parseAsync(content, '');
scene.updateMatrixWorld(true);
let mesh = null;
scene.traverse((object) => { if (!mesh && object.morphTargetInfluences) mesh = object; });
mesh.morphTargetInfluences = weights.map(Number);
const found = [];
const vertex = new Vector3();
for (let i = 0; i < mesh.geometry.attributes.position.count; i += 1) {
  mesh.getVertexPosition(i, vertex);
  found.push(...vertex.applyMatrix4(mesh.matrixWorld).toArray());
}
console.log(JSON.stringify(found));
"""
