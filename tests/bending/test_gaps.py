"""What bends added takes the places of what nothing uses any more, and of nothing else."""

from __future__ import annotations

import copy
from typing import Any

from elastomorph.bending.gaps import fill_gaps


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
