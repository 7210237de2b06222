"""``elastomorph hold``: an eye whose lids pass each other, held in files of every kind."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from elastomorph.bending.gltf import KEYS_TOLERANCE
from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import open_gltf
from elastomorph.rig.laws import Corrective
from fbx_samples import Model, Shape, as_binary, scene
from foreign_files import chunks_of, glb, write_foreign_glb
from needs import extra
from small_eye import MOVES, eye

HINGES = ["hold_eyeBlinkLeft_1", "hold_eyeBlinkLeft_2"]
TIMES = np.array([0.0, 1.0, 2.5])
WEIGHTS = np.array([[0, 0, 0], [1, 1, 0], [0.7, 0.2, 0.9]])


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The eye as other programs write it, with a clip; the program runs in its folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    document, blob = chunks_of(write_foreign_glb(tmp_path / "eye.glb", eye(**MOVES)))
    samplers = {}
    for name, values in (("input", TIMES), ("output", WEIGHTS.ravel())):
        content = values.astype("<f4").tobytes()
        document["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(blob), "byteLength": len(content)}
        )
        accessor = {"bufferView": len(document["bufferViews"]) - 1, "componentType": 5126,
                    "count": values.size, "type": "SCALAR"}  # fmt: skip
        if name == "input":
            accessor |= {"min": [0.0], "max": [float(TIMES[-1])]}
        samplers[name] = len(document["accessors"])
        document["accessors"].append(accessor)
        blob += content
    document["buffers"][0]["byteLength"] = len(blob)
    node = next(number for number, own in enumerate(document["nodes"]) if "mesh" in own)
    channel = {"sampler": 0, "target": {"node": node, "path": "weights"}}
    document["animations"] = [{"channels": [channel], "samplers": [samplers]}]
    (tmp_path / "eye.glb").write_bytes(glb(document, blob))
    return tmp_path / "eye.glb"


def test_a_dry_run_says_what_would_be_added(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("hold", "eye.glb", "--dry-run") == 0
    said = capsys.readouterr().out
    for words in (*HINGES, "hinge", "2 morph targets are added", "nothing was written"):
        assert words in said
    assert run("hold", "eye.glb", "--dry-run", "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert [own["name"] for own in facts["corrections"]] == HINGES
    assert facts["written"] is None
    assert facts["targets"] == facts["targets_before"] + 2 == 5
    assert list(file.parent.iterdir()) == [file]


def test_a_file_is_held_in_place_and_given_back(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = file.read_bytes()
    assert run("hold", "eye.glb", "-o", "held.glb") == 0
    assert "written: held.glb" in capsys.readouterr().out
    written = em.read_rig("held.glb")
    expected = em.hold(em.read_rig("eye.glb", method="linear")).rig
    assert written.names == expected.names
    for face in ({"eyeBlinkLeft": 1.0}, {"eyeBlinkLeft": 0.9, "eyeSquintLeft": 0.8}):
        np.testing.assert_allclose(written.pose(face), expected.pose(face), atol=1e-5)
    assert run("unbend", "held.glb", "-o", "back.glb") == 0
    assert chunks_of(Path("back.glb")) == chunks_of(file)
    assert file.read_bytes() == before
    capsys.readouterr()
    assert run("hold", "held.glb", "-o", "again.glb") == 0
    said = capsys.readouterr().out
    assert "eyeBlinkLeft is held already, and kept" in said
    assert "nothing is added" in said
    assert not Path("again.glb").exists()


def test_clips_drive_correctives_by_their_law(file: Path) -> None:
    """No vertex is farther from where the law leads it than the tolerance of keys says."""
    assert run("hold", "eye.glb", "-o", "held.glb") == 0
    held, rig = open_gltf("held.glb"), em.read_rig("held.glb")
    (animation,) = held.document["animations"]
    (sampler,) = animation["samplers"]
    times = read_floats(held, sampler["input"], 1, "a test")[:, 0]
    values = read_floats(held, sampler["output"], 1, "a test").reshape(len(times), 5)
    moments = np.linspace(0, TIMES[-1], 1001)
    sliders = np.stack([np.interp(moments, TIMES, own) for own in WEIGHTS.T], axis=1)
    played = np.stack([np.interp(moments, times, own) for own in values.T], axis=1)
    np.testing.assert_allclose(played[:, :3], sliders, atol=1e-6)
    off = np.zeros(len(moments))
    for column, name in enumerate(HINGES, start=3):
        law = rig.sliders.correctives[name]
        gains = [dict(zip(law.drivers, law.numbers, strict=True)).get(n, 0.0) for n in rig.names]
        hinge = np.maximum(sliders @ gains - 1, 0)
        assert hinge.max() > 0.1
        off += np.linalg.norm(rig[name].delta, axis=1).max() * np.abs(played[:, column] - hinge)
    assert off.max() <= 1.1 * KEYS_TOLERANCE * rig.neutral.diameter


def test_a_folder_is_held_as_an_export(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = em.read_rig(file)
    Path("faces").mkdir()
    em.write("faces/neutral.obj", rig.neutral)
    for name in rig.names:
        em.write(f"faces/{name}.obj", rig[name].target)
    assert run("hold", "faces", "-o", "held.glb", "--json") == 0
    assert json.loads(capsys.readouterr().out)["written"] == "held.glb"
    assert list(em.read_rig("held.glb").sliders.correctives) == HINGES
    assert run("hold", "eye.glb", "-o", "held.npz") == 0
    assert list(em.read_rig("held.npz").sliders.correctives) == HINGES


def test_a_usd_file_is_held_by_a_layer(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    extra("pxr", "usd")
    em.write("eye.usda", em.read_rig(file, method="linear"))
    before = Path("eye.usda").read_bytes()
    assert run("hold", "eye.usda", "--dry-run", "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert [own["name"] for own in facts["corrections"]] == HINGES
    assert facts["written"] is None
    assert run("hold", "eye.usda", "-o", "held.usda") == 0
    assert "@./eye.usda@" in Path("held.usda").read_text()
    written, expected = em.read_rig("held.usda"), em.hold(em.read_rig("eye.usda")).rig
    assert written.sliders == expected.sliders
    for face in ({"eyeBlinkLeft": 1.0}, {"eyeBlinkLeft": 0.9, "eyeSquintLeft": 0.8}):
        np.testing.assert_allclose(written.pose(face), expected.pose(face), atol=1e-5)
    capsys.readouterr()
    assert run("hold", "held.usda", "-o", "again.usda") == 0
    assert "nothing is added" in capsys.readouterr().out
    assert not Path("again.usda").exists()
    assert run("unbend", "held.usda", "-o", "back.usda") == 0
    assert Path("back.usda").read_bytes() == Path("eye.usda").read_bytes() == before


@pytest.mark.parametrize(
    ("rig", "output", "problem"),
    [
        ("eye.glb", "held.vrm", ""),
        ("eye.glb", "held.gltf", "name an output with the suffix .glb or .vrm"),
        ("eye.glb", "held.usda", ""),
        ("eye.vrm", "held.vrm", ""),
        ("eye.usda", "held.usdc", ""),
        ("eye.usda", "held.usdz", "make a package of that with usdzip"),
        ("eye.usda", "held.npz", ""),
        ("eye.usdz", "held.usda", ""),
        ("eye.fbx", "held.glb", ""),
        ("eye.fbx", "held.fbx", "this format is only read"),
        ("eye.npz", "held.usdz", ""),
        ("eye.npz", "held.vrm", "this format is only read"),
        ("eye.toml", "held.npz", ""),
        ("eye.toml", "held.obj", "unknown suffix '.obj'"),
        ("faces", "held", "the name has no suffix"),
        ("built-in", "held.gltf", "this format is only read"),
    ],
)
def test_every_door_holds_or_says_why_not(
    file: Path, capsys: pytest.CaptureFixture[str], rig: str, output: str, problem: str
) -> None:
    extra("pxr", "usd")
    held = em.read_rig(file, method="linear")
    _write(Path(rig), held)
    assert (run("hold", rig, "-o", output) == 0) == (not problem)
    said = " ".join(capsys.readouterr().err.split())
    assert problem in said
    assert "Traceback" not in said
    assert Path(output).exists() == (not problem)
    if not problem:
        assert set(HINGES) <= set(em.read_rig(output).sliders.correctives)


def _write(path: Path, rig: em.Rig) -> None:
    """Write a rig as a file or folder of this name; that of the eye is there as eye.glb."""
    if path.suffix == ".vrm":
        path.write_bytes(Path("eye.glb").read_bytes())
    elif path.suffix == ".toml":
        path.write_text('[character]\nrig = "eye.glb"\n')
    elif path.suffix == ".fbx":
        channels = {}
        for name, target in rig.targets.items():
            offsets = target.vertices - rig.neutral.vertices
            moved = np.flatnonzero(offsets.any(axis=1))
            channels[name] = [Shape(moved.tolist(), offsets[moved].tolist())]
        faces = [list(face) for face in rig.neutral.faces]
        model = Model("eye", rig.neutral.vertices.tolist(), faces, channels)
        path.write_bytes(as_binary(scene(model)))
    elif path.name == "faces":
        path.mkdir()
        em.write(path / "neutral.obj", rig.neutral)
        for name, target in rig.targets.items():
            em.write(path / f"{name}.obj", target)
    elif path.suffix not in ("", ".glb"):
        em.write(path, rig)


def test_a_take_says_in_how_many_frames(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("take.csv").write_text(
        "Timecode,BlendShapeCount,EyeBlinkLeft,EyeSquintLeft\n"
        "00:00:00:00.000,2,1,1\n00:00:00:01.000,2,1,0\n00:00:00:02.000,2,0,1\n"
    )
    assert run("hold", "eye.glb", "--take", "take.csv", "--dry-run", "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert [own["frames"] for own in facts["corrections"]] == [1, 1]


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ((), "say where to write the rig that is held"),
        (("--dry-run", "--only", "nonsense"), "--only is lids, lips or folds, found 'nonsense'"),
        (("--dry-run", "--only", "folds"), "say how many correctives at most"),
        (("--dry-run", "--only", "lips"), "say how many correctives at most, as --lips 15"),
        (("--dry-run", "--only", "lids", "--folds", 3), "--folds has no effect"),
        (("--dry-run", "--only", "folds", "--folds", 3, "--lips", 3), "--lips has no effect"),
        (("--dry-run", "--folds", 3), "folds are found in takes: give one"),
        (("--dry-run", "--lips", 3), "lips are found in takes: give one"),
        (("-o", "held.glb", "--take", "none.csv"), "none.csv"),
    ],
)
def test_what_is_asked_for_must_make_sense(
    file: Path, capsys: pytest.CaptureFixture[str], words: tuple[object, ...], problem: str
) -> None:
    assert run("hold", "eye.glb", *words) != 0
    said = " ".join(capsys.readouterr().err.split())
    assert problem in said
    assert "Traceback" not in said
    assert list(file.parent.iterdir()) == [file]


def test_a_rig_without_a_blink_is_refused(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_foreign_glb(file, eye(eyeSquintLeft=(0.0, 0.1)))
    assert run("hold", "eye.glb", "-o", "held.glb") != 0
    assert "no slider that shuts an eye" in " ".join(capsys.readouterr().err.split())
    assert list(file.parent.iterdir()) == [file]


def test_correctives_that_are_there_are_kept(file: Path) -> None:
    rig = em.read_rig(file, method="linear")
    product = Corrective(("eyeBlinkLeft", "eyeSquintLeft"))
    morphs = {**rig.morphs, "both": rig["eyeWideLeft"]}
    em.write("both.glb", em.Rig(rig.neutral, morphs, correctives={"both": product}))
    assert run("hold", "both.glb", "-o", "held.glb") == 0
    assert em.read_rig("held.glb").sliders.correctives["both"] == product
