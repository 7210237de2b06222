"""Takes that are opened on a rig: the page makes of every file what Python makes of it."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from faces import Faces, glb
from projecting import as_turned, spots
from takes import ASKS, NO_ROOM, Take, alone, latest, named_rig, open_files, told
from visiting import SMALL, Visit, empty_page, state, update, wait

import elastomorph as em
from elastomorph.io.performance import write_performance_csv
from elastomorph.rig import Rig
from elastomorph.rig.naming import ARKIT
from elastomorph.rig.performance import Performance, slider_weights
from foreign_files import chunks_of
from foreign_files import glb as container
from small_head import shapes

HALF_SECOND = "\n".join(f"{i / 20!r},{i / 10},{1 - i / 10}" for i in range(11))
MILLISECONDS = "\n".join(f"{40 * i};{10 * i},5;0" for i in range(11))
LIVE = "Timecode,BlendShapeCount,JawOpen,EyeBlinkLeft,EyeBlinkRight,HeadYaw"
FILES = {
    "arkit.csv": f"time,jawOpen,browInnerUp\n{HALF_SECOND}\n",
    "quoted.csv": f'"time","jawOpen","brow ""InnerUp"\r\n\r\n{HALF_SECOND}\r\n',
    "percent.csv": f"time;EyeBlinkLeft;jawOpen\n{MILLISECONDS}\n",
    "sides.csv": f"seconds\teyeBlink_L\tEYEBLINKRIGHT\n{HALF_SECOND.replace(',', chr(9))}\n",
    "gap.csv": f"{LIVE}\n10:59:59:28.5,4,.1,0,1,2\n10:59:59:29.5,4,.2,0,1,2\n"
    "10:59:59:29.5,4,.3,0,1,2\n"
    "11:00:00:00.5,4,.4,0,1,2\n11:00:00:05.5,0,,,,\n11:00:00:06.5,4,.5,1e-1,1,2\n",
    "drop.csv": f"{LIVE}\n23:59:59;28,4,.1,0,1,2\n23:59:59;29,4,.2,0,1,2\n00:00:00;00,4,.4,0,1,2\n",
    "vrm.csv": f"time,Blink,LookLeft\n{HALF_SECOND}\n",
}
GUESSES = {
    "percent.csv": [
        "percent.csv: its times are taken for milliseconds and its weights are taken for percent."
    ]
}
MIXED = ("jawOpen", "browInnerUp_L", "browInnerUp_R", "Blink", "a.eyeLookIn_R", "b.eyeLookIn_R")
MIXED += ('brow "InnerUp', "eyeBlinkLeft")


def assert_as_python(found: Take, path: Path, rig: Rig) -> None:
    """Every slider has the weight that Python gives it, in every frame, to single precision."""
    take = em.read_performance(path)
    np.testing.assert_allclose(found.times, take.times, rtol=1e-6, atol=1e-6)
    wanted = slider_weights(rig, take)
    driven = {name for name in rig.names if name in found.tracks}
    assert driven
    for name, column in zip(rig.names, wanted.T, strict=True):
        track = found.tracks.get(name, np.zeros(len(take)))
        np.testing.assert_allclose(track, column, rtol=1e-6, atol=1e-7, err_msg=name)


@pytest.mark.realdata
@pytest.mark.parametrize("kind", ["production rig", "small head"])
def test_a_real_take_is_as_python_reads_it(visit: Visit, data_dir: Path, kind: str) -> None:
    """4,030 frames of a phone; weights are a matter of names, so a small mesh has the rig's."""
    if kind == "small head":
        names = tuple(shapes())
    else:
        files = (data_dir / "ict-facekit").glob("*.obj")
        names = tuple(sorted(f.stem for f in files if not f.stem.startswith("generic")))
    rig = named_rig(names)
    page = visit(alone(glb(rig)), size=SMALL)
    path = data_dir / "livelink" / "rom_3.csv"
    open_files(page, path)
    assert told(page) == []
    found = latest(page)
    assert found.name == "rom_3"
    assert len(found.times) == 4030
    page.get_by_text("4,030 frames, 30 fps, 3 missing").wait_for()
    assert_as_python(found, path, rig)
    now = page.evaluate("elastomorph.state().clip")
    assert now == "rom_3"


def test_all_kinds_of_columns_are_as_python_reads_them(visit: Visit, tmp_path: Path) -> None:
    rig = named_rig(MIXED)
    page = visit(alone(glb(rig)), size=SMALL)
    for name, text in FILES.items():
        path = tmp_path / name
        path.write_text(text, encoding="utf-8", newline="")
        open_files(page, path)
        assert told(page) == GUESSES.get(name, []), name
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", em.ElastomorphWarning)  # semicolons, percent
            assert_as_python(latest(page), path, rig)


def test_every_spelling_drives_what_it_drives_in_python(visit: Visit, tmp_path: Path) -> None:
    """All shapes of ARKit as Live Link Face writes them, on a rig with sides as letters."""
    rig = named_rig(tuple(f"n.{name[0].upper()}{name[1:]}" for name in ARKIT))
    table = np.random.default_rng(1).uniform(0, 1, (4, len(ARKIT)))
    names = [name.replace("Left", "_L").replace("Right", "_R").upper() for name in ARKIT]
    names = [
        n if name not in ("jawLeft", "jawRight", "mouthLeft", "mouthRight") else name
        for n, name in zip(names, ARKIT, strict=True)
    ]
    path = tmp_path / "all.csv"
    rows = [",".join(map(str, [i / 30, *row])) for i, row in enumerate(table)]
    path.write_text("\n".join(["time," + ",".join(names), *rows]), encoding="utf-8")
    page = visit(alone(glb(rig)), size=SMALL)
    open_files(page, path)
    found = latest(page)
    assert set(found.tracks) == set(rig.names)
    assert_as_python(found, path, rig)


def test_the_head_turns_with_a_take(visit: Visit, tmp_path: Path) -> None:
    """Between its frames too; a take without angles leaves it as it is."""
    rig = named_rig(MIXED)
    rows = "0,.1,.2,0,0\n1,.1,.4,.2,-.2\n"
    (tmp_path / "turning.csv").write_text(f"time,jawOpen,HeadYaw,HeadPitch,headRoll\n{rows}")
    (tmp_path / "still.csv").write_text(FILES["arkit.csv"])
    page = visit(alone(glb(rig)), size=SMALL)
    points = rig.neutral.vertices
    open_files(page, tmp_path / "turning.csv")
    update(page, clipTime=0.5)
    turned = spots(page, points)
    update(page, headTurns=False)
    straight = spots(page, points)
    wanted = spots(page, as_turned(points, rig, (0.3, 0.1, -0.1)))
    np.testing.assert_allclose(turned, wanted, atol=0.01)
    assert np.abs(turned - straight).max() > 1  # of a small picture
    update(page, headTurns=True)
    open_files(page, tmp_path / "still.csv")
    np.testing.assert_allclose(spots(page, points), straight, atol=1e-6)


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_archives_of_numpy_are_takes(
    visit: Visit, tmp_path: Path, save: Callable[..., None]
) -> None:
    table = np.random.default_rng(2).uniform(0, 1, (5, 2)).astype(np.float32)
    times = np.arange(5) / 24
    save(tmp_path / "own.npz", names=["jawOpen", "Blink"], times=times, weights=table)
    page = visit(alone(glb(named_rig(MIXED))), size=SMALL)
    open_files(page, tmp_path / "own.npz")
    assert told(page) == []
    found = latest(page)
    np.testing.assert_array_equal(found.tracks["jawOpen"], table[:, 0])
    np.testing.assert_array_equal(found.tracks["Blink"], table[:, 1])
    assert page.evaluate("elastomorph.state().takes[0].recorded.rate") == 24
    columns = np.array([[0, 0.5, -1, 2, 6e-8], [1, 0, 0.25, 0, 1]]).astype(">f2")
    days = np.arange(5, dtype="i2")
    save(tmp_path / "own.npz", names=["jawOpen", "Blink"], times=days, weights=columns.T, rate=2)
    open_files(page, tmp_path / "own.npz")
    assert told(page) == []
    assert_as_python(latest(page), tmp_path / "own.npz", named_rig(MIXED))
    assert page.evaluate("elastomorph.state().takes[0].recorded.rate") == 2


def test_a_file_with_a_performance_opens_on_it(visit: Visit, faces: Faces) -> None:
    page = visit(faces.performed, size=SMALL)
    assert state(page)["clip"] == "a take"
    assert not state(page)["playing"]


def test_performances_of_another_rig_play_on_this_one(
    visit: Visit, faces: Faces, tmp_path: Path
) -> None:
    """Chosen in the timeline, files of faces are takes; the face that is shown stays.

    However a file plays, straight between keys, in steps, along splines or by a pointer, the
    weights at all times are those of Python.
    """
    rig = named_rig(("eyeBlinkLeft", "JawOpen"))
    page = visit(alone(glb(rig)), size=SMALL)
    path = tmp_path / "first.csv"
    path.write_text(FILES["arkit.csv"])
    open_files(page, path)
    own = glb(faces.rigs["rotation"], faces.take)
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Open a take…").click()
    for kind in ("LINEAR", "STEP", "CUBICSPLINE", "pointer"):
        (tmp_path / f"{kind}.glb").write_bytes(own)
        _play(tmp_path / f"{kind}.glb", kind)
    chooser.value.set_files([str(file) for file in tmp_path.glob("*.glb")])
    wait(page, "elastomorph.state().takes.length === 5")
    assert told(page) == []
    for number in range(1, 5):
        found = latest(page, number)
        take = em.read_performance(tmp_path / f"{found.name}.glb", clip="a take")
        assert set(found.tracks) == set(rig.names)
        np.testing.assert_allclose(found.times, take.times, rtol=1e-6)
        wanted = slider_weights(rig, take)
        for name, column in zip(rig.names, wanted.T, strict=True):
            np.testing.assert_allclose(found.tracks[name], column, atol=2e-6)
    assert page.evaluate("elastomorph.models().length") == 1


def _play(path: Path, kind: str) -> None:
    """Makes a file play its first animation otherwise; as a spline, with uneven tangents."""
    document, binary = chunks_of(path)
    animation = document["animations"][0]
    if kind == "pointer":
        for channel in animation["channels"]:
            pointer = f"/nodes/{channel['target']['node']}/weights"
            extensions = {"KHR_animation_pointer": {"pointer": pointer}}
            channel["target"] = {"path": "pointer", "extensions": extensions}
        document["extensionsUsed"] = ["KHR_animation_pointer"]
    else:
        for sampler in animation["samplers"]:
            sampler["interpolation"] = kind
    for sampler in animation["samplers"] if kind == "CUBICSPLINE" else ():
        keys = document["accessors"][sampler["input"]]["count"]
        output = document["accessors"][sampler["output"]]
        view = document["bufferViews"][output["bufferView"]]
        start = view.get("byteOffset", 0) + output.get("byteOffset", 0)
        values = np.frombuffer(binary, "<f4", output["count"], start).reshape(keys, 1, -1)
        rises = values * np.linspace(-3, 3, keys).reshape(-1, 1, 1)
        spline = np.concatenate([rises, values, -rises], axis=1).astype("<f4").tobytes()
        document["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(binary), "byteLength": len(spline)}
        )
        binary += spline
        output.update(bufferView=len(document["bufferViews"]) - 1, count=3 * output["count"])
        output.pop("byteOffset", None)
    document["buffers"][0]["byteLength"] = len(binary)
    path.write_bytes(container(document, binary))


def test_a_take_goes_on_with_another_face_and_edits_are_not_lost(
    visit: Visit, faces: Faces, tmp_path: Path
) -> None:
    """Also where the new face understands none of it: then it waits for one that does."""
    path = tmp_path / "one.csv"
    path.write_text(FILES["arkit.csv"])
    (tmp_path / "head.glb").write_bytes(glb(faces.rigs["linear"]))
    (tmp_path / "other.glb").write_bytes(glb(named_rig(("foo",))))
    page = visit(alone(glb(named_rig(MIXED))), size=SMALL)
    open_files(page, path)
    assert not page.evaluate(ASKS)
    page.evaluate(NO_ROOM)
    page.evaluate(
        """() => {
            const [take] = elastomorph.state().takes;
            const jaw = take.tracks.get('jawOpen').map((weight, i) => (i === 4 ? 0.875 : weight));
            const tracks = new Map(take.tracks).set('jawOpen', jaw);
            elastomorph.update({takes: [{...take, tracks}], clipTime: 0.2, playing: true});
        }"""
    )
    assert page.evaluate(ASKS)
    known = {"jawOpen", "browInnerUp"}
    for file, sliders in (("head", known), ("other", set()), ("head", known)):
        update(page, clip="one", clipTime=0.2, playing=True)
        open_files(page, tmp_path / f"{file}.glb")
        found = latest(page)
        assert all("is full" in words for words in told(page))
        assert set(found.tracks) == sliders
        if sliders:
            assert found.tracks["jawOpen"][4] == 0.875
            assert state(page)["clip"] == "one", "before the view that was kept"
            assert state(page)["playing"]
    assert page.evaluate(ASKS), "what is not saved is still not"
    page.evaluate("elastomorph.update({takes: []})")


def test_a_take_of_the_name_of_another_takes_its_place(visit: Visit, tmp_path: Path) -> None:
    page = visit(alone(glb(named_rig(MIXED))), size=SMALL)
    path = tmp_path / "one.csv"
    for top in (0.25, 0.75):
        path.write_text(f"time,jawOpen\n0,0\n1,{top}\n")
        open_files(page, path)
    assert page.evaluate("elastomorph.state().takes.length") == 1
    assert latest(page).tracks["jawOpen"][-1] == 0.75


BAD = {
    "half.csv": (f"{LIVE}\n10:00:00:00,4,.1,0,1,2\n10:00:00:01,4,.1,0", "line 3", "6 columns"),
    "word.csv": ("time,jawOpen\n0,0\n1,open\n", "line 3", 'jawOpen is "open"'),
    "back.csv": ("time,jawOpen\n0,0\n2,0\n1,0\n", "line 4", "Times must rise"),
    "twice.csv": ("time,jawOpen,jawOpen\n0,0,0\n", "line 1", "twice"),
    "other.csv": ("time,smile,frown\n0,0,0\n", "no weight drives a slider", "smile, frown"),
    "both.csv": ("time,jawOpen,JawOpen\n0,0,0\n", "both jawOpen", "rename"),
    "empty.csv": ("", "empty", "header"),
    "count.csv": (f"{LIVE}\n10:00:00:00,61,.1,0,1,2\n", "line 2", "announces 61"),
    "clock.csv": (f"{LIVE}\nnoon,4,.1,0,1,2\n", "line 2", "HH:MM:SS:FF"),
    "untimed.csv": ("jawOpen,Blink\n1,0\n", "line 1", '"time"'),
    "wide.csv": ("time,jawOpen\n0,5\n", "line 1", "percent or not"),
    "zero.csv": ("time,jawOpen\n0,\x000\n", "line 2", "zero byte"),
    "cut.npz": ("PK\x03\x04 and no more", "damaged or cut off", "Copy it again"),
}


def test_bad_takes_are_one_sentence_and_nothing_is_lost(visit: Visit, tmp_path: Path) -> None:
    page = visit(alone(glb(named_rig(MIXED))), size=SMALL)
    good = tmp_path / "good.csv"
    good.write_text(FILES["arkit.csv"])
    open_files(page, good)
    update(page, clipTime=0.2)
    before = latest(page)
    for name, (text, *parts) in BAD.items():
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        open_files(page, path)
        words = told(page)
        assert len(words) == 1, (name, words)
        assert words[0].startswith(name), words
        for part in parts:
            assert part in words[0], (name, words)
    after = latest(page)
    assert after.name == before.name == "good"
    np.testing.assert_array_equal(after.tracks["jawOpen"], before.tracks["jawOpen"])
    assert page.evaluate("elastomorph.state().clipTime") == pytest.approx(0.2)


def test_archives_that_hold_something_else_are_refused(visit: Visit, tmp_path: Path) -> None:
    page = visit(alone(glb(named_rig(MIXED))), size=SMALL)
    table = np.zeros((3, 1))
    times = np.arange(3.0)
    bad = {
        "unnamed": ({"times": times, "weights": table}, 'no array "names"'),
        "short": (
            {"names": ["jawOpen"], "times": times[:2], "weights": table},
            "found (1), (2), (3, 1)",
        ),
        "still": ({"names": ["jawOpen"], "times": 0 * times, "weights": table}, "rise"),
        "nan": ({"names": ["jawOpen"], "times": times, "weights": table * np.nan}, "finite"),
        "odd": ({"names": ["jawOpen"], "times": times, "weights": table > 0}, "neither numbers"),
        "slow": ({"names": ["jawOpen"], "times": times, "weights": table, "rate": 0}, "above 0"),
    }
    for name, (arrays, part) in bad.items():
        np.savez(tmp_path / f"{name}.npz", **arrays)
        open_files(page, tmp_path / f"{name}.npz")
        words = told(page)
        assert len(words) == 1, (name, words)
        assert part in words[0], words
    whole = (tmp_path / "nan.npz").read_bytes()
    for end in range(0, len(whole), 97):
        (tmp_path / "cut.npz").write_bytes(whole[:end])
        open_files(page, tmp_path / "cut.npz")
        assert len(told(page)) == 1, end


def test_a_take_without_a_rig_asks_for_one(visit: Visit, tmp_path: Path) -> None:
    path = tmp_path / "take.csv"
    path.write_text(FILES["arkit.csv"])
    page = visit(empty_page(), size=SMALL)
    open_files(page, path)
    assert "open a rig" in told(page)[0]


def test_a_rig_and_its_take_are_dropped_together(
    visit: Visit, faces: Faces, tmp_path: Path
) -> None:
    (tmp_path / "head.glb").write_bytes(glb(faces.rigs["linear"]))
    take = Performance(("jawOpen",), [0, 0.5, 1], [[0], [0.5], [1]], 2.0)
    write_performance_csv(tmp_path / "a.csv", take)
    page = visit(empty_page(), size=SMALL)
    open_files(page, tmp_path / "a.csv", tmp_path / "head.glb")
    assert told(page) == []
    assert state(page)["clip"] == "a"
    update(page, clipTime=0.25)
    assert state(page)["weights"] == {"jawOpen": pytest.approx(0.25)}
