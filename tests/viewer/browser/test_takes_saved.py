"""Takes that are saved: what the page writes, Python and other programs read."""

from __future__ import annotations

import json
import struct
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from faces import Faces, glb
from takes import ASKS, NO_ROOM, alone, named_rig, open_files, told
from visiting import Visit, update

import elastomorph as em
from elastomorph.io.performance import write_performance_csv
from elastomorph.rig.performance import Performance, slider_weights
from needs import WEB, node

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

SIZE = (700, 640)
LIVE = "Timecode,BlendShapeCount,JawOpen,BrowInnerUp,TongueOut,HeadYaw"


def save(page: Page, words: str, folder: Path) -> Path:
    with page.expect_download() as download:
        page.get_by_role("button", name=words).click()
    path = folder / f"saved-{download.value.suggested_filename}"
    download.value.save_as(path)
    return path


def number(page: Page, name: str) -> Locator:
    """A field of the timeline."""
    return page.get_by_role("spinbutton", name=name, exact=True)


def test_a_table_comes_back_to_the_last_digit(visit: Visit, tmp_path: Path) -> None:
    table = np.random.default_rng(3).uniform(-0.1, 1.2, (20, 2))
    table[0] = 0.0947265625, 1 / 3  # one of single precision, one of more digits
    table[1] = 93.7044972557755, 0
    times = 36_000 + np.arange(20) / 32  # of the day, which single precision has as well
    take = Performance(("jawOpen", "MouthFunnel"), times, table, 32.0)
    write_performance_csv(tmp_path / "own.csv", take)
    page = visit(alone(glb(named_rig(("jawOpen", "mouthFunnel")))), size=SIZE)
    open_files(page, tmp_path / "own.csv")
    back = em.read_performance(save(page, "Save CSV", tmp_path))
    assert back.names == take.names
    np.testing.assert_array_equal(back.times, take.times)
    np.testing.assert_array_equal(back.weights, take.weights)


def test_a_take_of_a_phone_stays_one(visit: Visit, tmp_path: Path) -> None:
    """Edited weights change, all else stays; what its columns cannot say gets its own."""
    rows = [f"10:00:00:{i:02d}.500,4,{i / 10},{i / 20},0.5,-0.25" for i in range(10)]
    path = tmp_path / "phone.csv"
    path.write_text("\n".join([LIVE, *rows]) + "\n")
    names = ("jawOpen", "browInnerUp_L", "browInnerUp_R", "cheekPuff")
    page = visit(alone(glb(named_rig(names))), size=SIZE)
    open_files(page, path)
    same = save(page, "Save CSV", tmp_path)
    assert em.read_performance(same).timecodes == em.read_performance(path).timecodes
    np.testing.assert_array_equal(
        em.read_performance(same).weights, em.read_performance(path).weights
    )
    curve = page.get_by_role("combobox", name="Curve")
    for name, value in (("jawOpen", "0.9"), ("browInnerUp_L", "1")):
        curve.select_option(name)
        number(page, "Falloff").fill("0")
        update(page, clipTime=3 / 60)
        number(page, "Value").fill(value)
        number(page, "Value").press("Enter")
    edited = save(page, "Save CSV", tmp_path)
    back = em.read_performance(edited)
    assert back.timecodes == em.read_performance(path).timecodes
    assert back.names[:4] == ("JawOpen", "BrowInnerUp", "TongueOut", "HeadYaw")
    assert set(back.names[4:]) == {"browInnerUp_L", "browInnerUp_R"}
    np.testing.assert_array_equal(back.weights[:, 2:4], em.read_performance(path).weights[:, 2:])
    driven = slider_weights(named_rig(names), back)
    wanted = slider_weights(named_rig(names), em.read_performance(path))
    wanted[3, :2] = 0.9, 1
    np.testing.assert_allclose(driven, wanted, atol=1e-6)


def test_a_saved_file_plays_the_take(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """Bends, correctives and all: three.js shows the rig's poses, and Python reads the take."""
    rig, take = faces.rigs["beam:2"], faces.take
    write_performance_csv(tmp_path / "a take.csv", take)
    page = visit(alone(glb(rig), "head"), size=SIZE)
    open_files(page, tmp_path / "a take.csv")
    path = save(page, "Save GLB", tmp_path)
    assert told(page) == []
    back = em.read_performance(path, clip="a take")
    np.testing.assert_allclose(back.times, take.times, atol=1e-6)
    np.testing.assert_allclose(slider_weights(rig, back), slider_weights(rig, take), atol=1e-5)
    program = node("three")
    played = [path, tmp_path / "out", "--clip", "a take", "--time", take.times[7]]
    for script, words in (("validate.mjs", [path]), ("pose.mjs", played)):
        words = [program, WEB / "checks" / script, *words]
        done = subprocess.run([str(word) for word in words], capture_output=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
    shown = np.fromfile(tmp_path / "out", "<f4").reshape(-1, 3)[: len(rig.neutral.vertices)]
    pose = rig.pose(dict(zip(take.names, take.weights[7], strict=True)))
    assert np.linalg.norm(shown - pose, axis=1).max() < 1e-4 * rig.neutral.diameter


def test_all_else_of_a_file_is_as_it_was(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """The take comes first; meshes, other clips and every byte before it stay."""
    before = glb(faces.rigs["rotation"], clips=True)
    write_performance_csv(tmp_path / "a take.csv", faces.take)
    page = visit(alone(before, "head"), size=SIZE)
    open_files(page, tmp_path / "a take.csv")
    after = save(page, "Save GLB", tmp_path).read_bytes()
    (old, held), (new, grown) = _chunks(before), _chunks(after)
    assert [clip["name"] for clip in new["animations"]] == [
        "a take",
        *(clip["name"] for clip in old["animations"]),
    ]
    assert grown.startswith(held)
    for key in set(old) - {"animations", "buffers", "bufferViews", "accessors"}:
        assert new[key] == old[key], key
    for key in ("bufferViews", "accessors"):
        assert new[key][: len(old[key])] == old[key]


def _chunks(content: bytes) -> tuple[dict[str, Any], bytes]:
    length = struct.unpack_from("<I", content, 12)[0]
    return json.loads(content[20 : 20 + length]), content[28 + length :]


def test_edits_are_saved_and_undone(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """What is edited is what the file has; undone, it is the take as it was opened."""
    write_performance_csv(tmp_path / "a take.csv", faces.take)
    page = visit(alone(glb(faces.rigs["linear"])), size=SIZE)
    open_files(page, tmp_path / "a take.csv")
    page.evaluate(NO_ROOM)
    page.get_by_role("combobox", name="Edit", exact=True).select_option("Offset")
    number(page, "Amount").fill("0.25")
    page.get_by_role("button", name="Apply").click()
    assert page.evaluate(ASKS), "whoever leaves now loses it"
    edited = em.read_performance(save(page, "Save CSV", tmp_path))
    np.testing.assert_allclose(edited.weights, faces.take.weights + 0.25, atol=1e-6)
    assert not page.evaluate(ASKS)
    page.locator(".picture").focus()
    page.keyboard.press("Control+z")
    back = em.read_performance(save(page, "Save CSV", tmp_path))
    np.testing.assert_array_equal(back.weights, faces.take.weights)
