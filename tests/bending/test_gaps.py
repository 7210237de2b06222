"""What bends added takes the places of what nothing uses any more, and of nothing else."""

from __future__ import annotations

import copy
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from elastomorph.bending.gltf import fill_gaps
from elastomorph.io.gltf.container import open_gltf
from gltf_builder import ARRAY, ELEMENT, GltfBuilder
from validator import complaints


def document() -> dict[str, Any]:
    """A clip of weights: times in view 1, weights in view 2; positions in view 0, an image in 3."""
    return {
        "accessors": [{"bufferView": 0}, {"bufferView": 1}, {"bufferView": 2}],
        "animations": [
            {
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
                "samplers": [{"input": 1, "output": 2}],
            }
        ],
        "bufferViews": [{"name": name} for name in ("positions", "times", "weights", "image")],
        "images": [{"bufferView": 3}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "targets": []}]}],
    }


def bent(times: int) -> dict[str, Any]:
    """With a bend, and a sampler of more weights at some times."""
    found = document()
    found["accessors"] += [{"bufferView": 4, "sparse": {"values": {"bufferView": 4}}}]
    found["accessors"] += [{"bufferView": 5}, {"bufferView": 6}]
    found["bufferViews"] += [{"name": "bend"}, {"name": "more times"}, {"name": "more weights"}]
    found["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 3}]
    found["animations"][0]["samplers"].append({"input": times, "output": 5})
    found["animations"][0]["channels"][0]["sampler"] = 1
    return found


def test_new_keys_take_the_place_of_the_old() -> None:
    after = bent(times=4)
    fill_gaps(document(), after)
    clip = after["animations"][0]
    assert [own["sampler"] for own in clip["channels"]] == [0]
    assert clip["samplers"] == [{"input": 2, "output": 1}]
    assert after["meshes"][0]["primitives"][0]["targets"] == [{"POSITION": 3}]
    assert len(after["accessors"]) == 4
    # What each accessor is of, wherever it now stands.
    views = [after["bufferViews"][own["bufferView"]]["name"] for own in after["accessors"]]
    assert views == ["positions", "more weights", "more times", "bend"]
    assert sorted(own["name"] for own in after["bufferViews"]) == sorted(
        ["positions", "image", "bend", "more times", "more weights"]
    )
    assert after["bufferViews"][after["images"][0]["bufferView"]]["name"] == "image"
    sparse = after["accessors"][3]["sparse"]["values"]["bufferView"]
    assert after["bufferViews"][sparse]["name"] == "bend"


def test_times_that_are_still_used_stay() -> None:
    after = bent(times=1)
    del after["accessors"][4]
    after["accessors"][4] = {"bufferView": 5}
    after["animations"][0]["samplers"][1]["output"] = 4
    del after["bufferViews"][6]
    fill_gaps(document(), after)
    assert after["animations"][0]["samplers"] == [{"input": 1, "output": 2}]
    assert after["accessors"][:2] == document()["accessors"][:2]
    assert [own["name"] for own in after["bufferViews"][:2]] == ["positions", "times"]


def test_what_an_extension_uses_stays() -> None:
    """Instances of a node are attributes of an extension; here they are the old keys."""
    before = document()
    attributes = {"TRANSLATION": 2}
    before["nodes"] = [{"extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}]
    after = bent(times=4)
    after["nodes"] = copy.deepcopy(before["nodes"])
    fill_gaps(before, after)
    assert after["nodes"] == before["nodes"]
    assert after["accessors"][2] == {"bufferView": 2}
    assert after["bufferViews"][2] == {"name": "weights"}


def test_what_was_of_no_use_before_stays() -> None:
    before = document()
    before["accessors"].insert(0, {"bufferView": 0, "name": "unused"})
    after = copy.deepcopy(before)
    after["accessors"].append({"bufferView": 0, "name": "added"})
    fill_gaps(before, after)
    assert after["accessors"][0]["name"] == "unused"
    assert after["accessors"][-1]["name"] == "added"


def test_more_gaps_than_additions_leave_the_rest() -> None:
    after = document()
    after["animations"][0]["channels"] = []
    after["animations"][0]["samplers"].append({"input": 1, "output": 2})
    after["animations"][0]["samplers"][0]["input"] = 0
    after["animations"][0]["channels"] = [{"sampler": 1}]
    before = document()
    before["animations"][0]["samplers"].append({"input": 1, "output": 2})
    before["animations"][0]["channels"].append({"sampler": 1})
    expected = copy.deepcopy(after)
    fill_gaps(before, after)
    assert after == expected


def test_numbers_in_extras_are_not_touched() -> None:
    before, after = document(), bent(times=4)
    for each in (before, after):
        each["extras"] = {"bufferView": 2}
    fill_gaps(before, after)
    assert after["extras"] == {"bufferView": 2}
    assert "weights" not in [own["name"] for own in after["bufferViews"]]


def test_a_buffer_of_which_nothing_is_left_gives_way_too() -> None:
    """Bends are in buffer 2; the old keys were all that buffer 1 held."""
    before, after = document(), bent(times=4)
    for each, count in ((before, 2), (after, 3)):
        each["buffers"] = [{"byteLength": 10 + number} for number in range(count)]
        for number, view in enumerate(each["bufferViews"]):
            view["buffer"] = 0 if number in (0, 3) else 1 if number < 3 else 2
    fill_gaps(before, after)
    assert after["buffers"] == [{"byteLength": 10}, {"byteLength": 12}]
    assert {own["name"]: own["buffer"] for own in after["bufferViews"]} == {
        "positions": 0,
        "image": 0,
        "bend": 1,
        "more times": 1,
        "more weights": 1,
    }


def triangle(path: Path, *, embedded: bool) -> Path:
    """A triangle of two targets and a clip of their weights, which has a buffer of its own."""
    file = GltfBuilder(2)
    corners = file.accessor(np.arange(3, dtype="<u2"), target=ELEMENT)
    places = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0.5, 0]], "<f4")
    moves = [places * 0 + np.array(top, "<f4") * [[0], [0], [1]] for top in ([-1, 1, 0], [1, 1, 0])]
    primitive = {
        "attributes": {"POSITION": file.accessor(places, target=ARRAY, bounds=True)},
        "targets": [{"POSITION": file.target(own.astype("<f4"), "dense")} for own in moves],
        "indices": corners,
    }
    keys = np.array([0, 0, 0, 1, 1, 1, 1, 0, 0, 0], "<f4")
    times = file.accessor(np.arange(5, dtype="<f4"), buffer=1, bounds=True)
    sampler = {"input": times, "output": file.accessor(keys, buffer=1)}
    channel = {"sampler": 0, "target": {"node": 0, "path": "weights"}}
    file.add("meshes", {"primitives": [primitive], "weights": [0.5, 0.5]})
    file.add("nodes", {"mesh": 0})
    file.json |= {"scene": 0, "scenes": [{"nodes": [0]}]}
    file.add("animations", {"samplers": [sampler], "channels": [channel]})
    return file.write(path, embedded=embedded)


@pytest.mark.parametrize("embedded", [False, True])
def test_the_validator_finds_nothing_unused(tmp_path: Path, embedded: bool) -> None:
    path, out = triangle(tmp_path / "a.gltf", embedded=embedded), tmp_path / "bent.gltf"
    assert em.bend(path, out).clips == 1
    em.unbend(out, tmp_path / "back.gltf")
    original, back = open_gltf(path), open_gltf(tmp_path / "back.gltf")
    assert back.document == original.document
    assert [back.buffer(n) for n in (0, 1)] == [original.buffer(n) for n in (0, 1)]
    assert complaints(path) == complaints(out) == Counter()


def test_unbend_needs_the_files_that_only_the_original_refers_to(tmp_path: Path) -> None:
    path, out = triangle(tmp_path / "a.gltf", embedded=False), tmp_path / "bent.gltf"
    em.bend(path, out)
    (tmp_path / "a 1.bin").unlink()
    em.read_rig(out)
    with pytest.raises(em.FileError, match=r"a 1\.bin"):
        em.unbend(out, tmp_path / "back.gltf")
    assert not (tmp_path / "back.gltf").exists()
