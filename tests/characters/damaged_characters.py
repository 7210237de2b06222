"""Characters that are damaged, contradict themselves or were made to harm: a table of changes.

Each change takes the document and the bytes of a small sound character and spoils one thing.
``REFUSED`` must be refused; ``EITHER`` may also be bent, if everything that is promised holds.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import numpy as np

Document = dict[str, Any]
Change = Callable[[Document, bytearray], None]

REFUSED: dict[str, Change] = {}
EITHER: dict[str, Change] = {}


def _refused(change: Change) -> Change:
    REFUSED[change.__name__.strip("_").replace("_", " ")] = change
    return change


def _either(change: Change) -> Change:
    EITHER[change.__name__.strip("_").replace("_", " ")] = change
    return change


def _face(document: Document) -> Document:
    """The first primitive with targets."""
    primitives = (own for mesh in document["meshes"] for own in mesh["primitives"])
    return next(own for own in primitives if own.get("targets"))


def _shown(document: Document) -> Document:
    """The node of the first mesh."""
    return next(own for own in document["nodes"] if own.get("mesh") == 0)


def _weights(document: Document) -> tuple[Document, Document]:
    """An animation and its first channel of weights."""
    for animation in document["animations"]:
        for channel in animation["channels"]:
            if channel["target"]["path"] == "weights":
                return animation, channel
    raise AssertionError


def _overwrite(document: Document, blob: bytearray, accessor: int, value: float) -> None:
    """A float in the middle of an accessor."""
    entry = document["accessors"][accessor]
    stored = entry.get("sparse", entry)
    place = stored["values"] if "sparse" in entry else entry
    view = document["bufferViews"][place["bufferView"]]
    at = view.get("byteOffset", 0) + place.get("byteOffset", 0) + 12 * (stored["count"] // 2)
    struct.pack_into("<f", blob, at, value)


@_refused
def _a_joint_that_is_no_node(document: Document, blob: bytearray) -> None:
    document["skins"][0]["joints"][1] = 4096


@_refused
def _a_joint_below_zero(document: Document, blob: bytearray) -> None:
    document["skins"][0]["joints"][0] = -1


@_refused
def _a_skin_that_is_not_there(document: Document, blob: bytearray) -> None:
    _shown(document)["skin"] = 7


@_refused
def _fewer_bind_matrices_than_joints(document: Document, blob: bytearray) -> None:
    number = document["skins"][0]["inverseBindMatrices"]
    document["accessors"][number]["count"] = 2


@_either
def _vertices_on_joints_that_the_skin_lacks(document: Document, blob: bytearray) -> None:
    document["skins"][0]["joints"] = document["skins"][0]["joints"][:2]


@_either
def _joints_of_fewer_vertices(document: Document, blob: bytearray) -> None:
    attributes = _face(document)["attributes"]
    document["accessors"][attributes["JOINTS_0"]]["count"] = 3


@_refused
def _a_node_below_itself(document: Document, blob: bytearray) -> None:
    document["nodes"][0]["children"] = [0]


@_refused
def _nodes_in_a_circle(document: Document, blob: bytearray) -> None:
    document["nodes"][3].setdefault("children", []).append(0)


@_refused
def _a_node_twice_in_the_scene(document: Document, blob: bytearray) -> None:
    scene = document["scenes"][document["scene"]]
    scene["nodes"].append(scene["nodes"][0])


@_refused
def _a_mesh_that_is_not_there(document: Document, blob: bytearray) -> None:
    _shown(document)["mesh"] = 99


@_refused
def _a_target_of_fewer_vertices(document: Document, blob: bytearray) -> None:
    accessor = document["accessors"][_face(document)["targets"][0]["POSITION"]]
    accessor["count"] -= 1


@_refused
def _a_target_without_an_accessor(document: Document, blob: bytearray) -> None:
    _face(document)["targets"][0]["POSITION"] = 10_000


@_refused
def _positions_that_are_no_numbers(document: Document, blob: bytearray) -> None:
    _overwrite(document, blob, _face(document)["attributes"]["POSITION"], float("nan"))


@_refused
def _a_target_that_is_no_number(document: Document, blob: bytearray) -> None:
    _overwrite(document, blob, _face(document)["targets"][0]["POSITION"], float("nan"))


@_refused
def _a_target_that_is_infinite(document: Document, blob: bytearray) -> None:
    _overwrite(document, blob, _face(document)["targets"][0]["POSITION"], float("inf"))


@_refused
def _keys_of_removed_targets(document: Document, blob: bytearray) -> None:
    for primitive in document["meshes"][0]["primitives"]:
        del primitive["targets"][-1]
    document["meshes"][0]["extras"]["targetNames"].pop()
    document["meshes"][0].pop("weights", None)


@_refused
def _an_animated_mesh_without_targets(document: Document, blob: bytearray) -> None:
    _, channel = _weights(document)
    mesh = document["nodes"][channel["target"]["node"]]["mesh"]
    for primitive in document["meshes"][mesh]["primitives"]:
        del primitive["targets"]
    document["meshes"][mesh].pop("weights", None)


@_refused
def _a_clip_without_its_sampler(document: Document, blob: bytearray) -> None:
    _weights(document)[1]["sampler"] = 50


@_refused
def _a_clip_of_a_node_that_is_gone(document: Document, blob: bytearray) -> None:
    _weights(document)[1]["target"]["node"] = 500


@_refused
def _keys_without_values(document: Document, blob: bytearray) -> None:
    animation, channel = _weights(document)
    del animation["samplers"][channel["sampler"]]["output"]


@_refused
def _an_unknown_interpolation(document: Document, blob: bytearray) -> None:
    animation, channel = _weights(document)
    animation["samplers"][channel["sampler"]]["interpolation"] = "BEZIER"


@_refused
def _key_times_that_go_back(document: Document, blob: bytearray) -> None:
    animation, channel = _weights(document)
    accessor = document["accessors"][animation["samplers"][channel["sampler"]]["input"]]
    view = document["bufferViews"][accessor["bufferView"]]
    struct.pack_into("<f", blob, view["byteOffset"] + 8, -1.0)


@_refused
def _key_times_that_are_no_numbers(document: Document, blob: bytearray) -> None:
    animation, channel = _weights(document)
    accessor = document["accessors"][animation["samplers"][channel["sampler"]]["input"]]
    view = document["bufferViews"][accessor["bufferView"]]
    struct.pack_into("<f", blob, view["byteOffset"] + 8, float("nan"))


@_refused
def _more_default_weights_than_targets(document: Document, blob: bytearray) -> None:
    document["meshes"][0]["weights"] = [0.5] * 1000


@_refused
def _default_weights_that_are_words(document: Document, blob: bytearray) -> None:
    count = len(_face(document)["targets"])
    document["meshes"][0]["weights"] = ["much"] * count


@_refused
def _node_weights_that_are_a_number(document: Document, blob: bytearray) -> None:
    _shown(document)["weights"] = 1.0


@_refused
def _a_view_beyond_its_buffer(document: Document, blob: bytearray) -> None:
    accessor = document["accessors"][_face(document)["attributes"]["POSITION"]]
    document["bufferViews"][accessor["bufferView"]]["byteLength"] = len(blob) * 2


@_refused
def _a_buffer_longer_than_the_file(document: Document, blob: bytearray) -> None:
    document["buffers"][0]["byteLength"] = 2**40


@_refused
def _thousands_of_millions_of_vertices(document: Document, blob: bytearray) -> None:
    primitive = _face(document)
    for number in (primitive["attributes"]["POSITION"], primitive["targets"][0]["POSITION"]):
        entry = document["accessors"][number]
        entry.pop("bufferView", None)
        entry["count"] = 2**32


@_refused
def _sparse_places_out_of_order(document: Document, blob: bytearray) -> None:
    sparse = _sparse(document)
    at = document["bufferViews"][sparse["indices"]["bufferView"]]["byteOffset"]
    blob[at : at + 4] = blob[at + 2 : at + 4] + blob[at : at + 2]


@_refused
def _sparse_places_beyond_the_vertices(document: Document, blob: bytearray) -> None:
    sparse = _sparse(document)
    view = document["bufferViews"][sparse["indices"]["bufferView"]]
    end = view["byteOffset"] + view["byteLength"]
    blob[end - 2 : end] = b"\xff\xff"


def _sparse(document: Document) -> Document:
    numbers = [own["POSITION"] for own in _face(document)["targets"]]
    entries = (document["accessors"][number] for number in numbers)
    found = next(own["sparse"] for own in entries if "sparse" in own)
    assert isinstance(found, dict)
    return found


@_refused
def _a_buffer_of_another_folder(document: Document, blob: bytearray) -> None:
    document["buffers"].append({"byteLength": 4, "uri": "../../../../etc/hostname"})
    accessor = document["accessors"][_face(document)["attributes"]["POSITION"]]
    document["bufferViews"][accessor["bufferView"]]["buffer"] = 1


@_refused
def _a_buffer_from_elsewhere(document: Document, blob: bytearray) -> None:
    document["buffers"].append({"byteLength": 4, "uri": "https://example.org/face.bin"})
    accessor = document["accessors"][_face(document)["attributes"]["POSITION"]]
    document["bufferViews"][accessor["bufferView"]]["buffer"] = 1


@_refused
def _ten_thousand_targets(document: Document, blob: bytearray) -> None:
    """Each a target of all vertices, in a small file."""
    mesh = document["meshes"][0]
    shape = {"componentType": 5126, "type": "VEC3"}
    for primitive in mesh["primitives"]:
        positions = document["accessors"][primitive["attributes"]["POSITION"]]
        document["accessors"].append({"count": positions["count"]} | shape)
        bare = {"POSITION": len(document["accessors"]) - 1}
        primitive["targets"] += [dict(bare) for _ in range(10_000)]
    mesh["extras"].pop("targetNames")
    mesh.pop("weights", None)
    document["animations"] = []


@_refused
def _compressed_with_nonsense(document: Document, blob: bytearray) -> None:
    _pack(document, {"mode": "ATTRIBUTES", "filter": "NONE"})


@_refused
def _compressed_to_more_than_there_is(document: Document, blob: bytearray) -> None:
    _pack(document, {"mode": "ATTRIBUTES", "count": 2**31, "byteStride": 252})


@_refused
def _compressed_with_a_stride_of_none(document: Document, blob: bytearray) -> None:
    _pack(document, {"mode": "ATTRIBUTES", "byteStride": 0})


@_refused
def _compressed_in_an_unknown_way(document: Document, blob: bytearray) -> None:
    _pack(document, {"mode": "MAGIC"})


def _pack(document: Document, more: Document) -> None:
    number = _face(document)["attributes"]["POSITION"]
    accessor = document["accessors"][number]
    view = document["bufferViews"][accessor["bufferView"]]
    packed = {
        "buffer": 0,
        "byteOffset": 0,
        "byteLength": 64,
        "byteStride": 12,
        "count": accessor["count"],
    }
    view["extensions"] = {"EXT_meshopt_compression": packed | more}
    document.setdefault("extensionsUsed", []).append("EXT_meshopt_compression")
    document["extensionsRequired"] = ["EXT_meshopt_compression"]


@_refused
def _draco_of_nonsense(document: Document, blob: bytearray) -> None:
    primitive = _face(document)
    ids = {name: k for k, name in enumerate(primitive["attributes"])}
    packed = {"bufferView": 0, "attributes": ids}
    primitive["extensions"] = {"KHR_draco_mesh_compression": packed}
    for number in (*primitive["attributes"].values(), primitive["indices"]):
        document["accessors"][number].pop("bufferView")
    document.setdefault("extensionsUsed", []).append("KHR_draco_mesh_compression")
    document["extensionsRequired"] = ["KHR_draco_mesh_compression"]


@_refused
def _an_extension_that_nobody_knows_is_required(document: Document, blob: bytearray) -> None:
    document["extensionsRequired"] = ["ACME_other_geometry"]


@_refused
def _no_targets_at_all(document: Document, blob: bytearray) -> None:
    for mesh in document["meshes"]:
        mesh.pop("weights", None)
        for primitive in mesh["primitives"]:
            primitive.pop("targets", None)
    document["animations"] = []


@_either
def _targets_in_some_primitives_only(document: Document, blob: bytearray) -> None:
    mesh = document["meshes"][0]
    other = {k: v for k, v in mesh["primitives"][0].items() if k != "targets"}
    mesh["primitives"].append(other)


@_either
def _names_that_meshes_share_but_not_their_targets(document: Document, blob: bytearray) -> None:
    """Further meshes of fewer targets, named as the first ones of others."""
    mesh = document["meshes"][0]
    first = dict(mesh["primitives"][0], targets=mesh["primitives"][0]["targets"][:1])
    names = [mesh["extras"]["targetNames"][-1]]
    document["meshes"].append({"primitives": [first], "extras": {"targetNames": names}})
    above = next(own for own in document["nodes"] if own.get("name") == "character")
    above["children"].append(len(document["nodes"]))
    document["nodes"].append({"mesh": len(document["meshes"]) - 1, "translation": [0.3, 0, 0]})


@_either
def _one_name_for_all_targets(document: Document, blob: bytearray) -> None:
    count = len(_face(document)["targets"])
    document["meshes"][0]["extras"]["targetNames"] = ["smile"] * count


@_either
def _names_that_are_numbers(document: Document, blob: bytearray) -> None:
    count = len(_face(document)["targets"])
    document["meshes"][0]["extras"]["targetNames"] = [*range(count - 1), None]


@_either
def _more_names_than_targets(document: Document, blob: bytearray) -> None:
    document["meshes"][0]["extras"]["targetNames"] += ["one more", "jawOpen.bend1"]


@_either
def _a_name_that_a_bend_would_have(document: Document, blob: bytearray) -> None:
    names = document["meshes"][0]["extras"]["targetNames"]
    names[names.index("jawLeft")] = "jawOpen.bend1"


@_either
def _notes_that_are_a_list(document: Document, blob: bytearray) -> None:
    document["meshes"][0]["extras"] = ["notes", 1]


@_either
def _notes_that_are_nothing(document: Document, blob: bytearray) -> None:
    document["meshes"][0]["extras"] = None


@_either
def _root_notes_that_are_words(document: Document, blob: bytearray) -> None:
    document["extras"] = "made by hand"


@_either
def _our_notes_at_the_root_are_nonsense(document: Document, blob: bytearray) -> None:
    document["extras"] = {"elastomorph": {"version": 1, "undo": [{"buffers": [-5]}], "x": 1e300}}


@_either
def _our_notes_of_a_mesh_are_nonsense(document: Document, blob: bytearray) -> None:
    morphs = [{"name": "jawOpen", "target": "jawOpen", "bends": [{"target": "nobody"}]}]
    document["meshes"][0]["extras"]["elastomorph"] = {"version": 1, "morphs": morphs}


@_either
def _notes_of_a_later_version(document: Document, blob: bytearray) -> None:
    document["meshes"][0]["extras"]["elastomorph"] = {"version": 99}
    document["extras"] = {"elastomorph": {"version": 99}}


@_either
def _a_pointer_to_nothing(document: Document, blob: bytearray) -> None:
    _point(document, "/nodes/999/weights")


@_either
def _a_pointer_to_a_weight_beyond(document: Document, blob: bytearray) -> None:
    _point(document, "/meshes/0/weights/999")


@_either
def _a_pointer_that_is_no_text(document: Document, blob: bytearray) -> None:
    _point(document, 12)


@_either
def _a_pointer_into_a_material(document: Document, blob: bytearray) -> None:
    _point(document, "/materials/0/pbrMetallicRoughness/metallicFactor")


@_either
def _a_pointer_with_escapes(document: Document, blob: bytearray) -> None:
    _point(document, "/extensions/a~1b/~0weights/weights")


def _point(document: Document, pointer: Any) -> None:
    target = _weights(document)[1]["target"]
    target.clear()
    extension = {"KHR_animation_pointer": {"pointer": pointer}}
    target |= {"path": "pointer", "extensions": extension}
    document["extensionsUsed"].append("KHR_animation_pointer")


@_either
def _a_channel_of_no_node(document: Document, blob: bytearray) -> None:
    del _weights(document)[1]["target"]["node"]


@_either
def _a_target_that_moves_nothing(document: Document, blob: bytearray) -> None:
    for primitive in document["meshes"][0]["primitives"]:
        for target in primitive["targets"]:
            entry = document["accessors"][target["POSITION"]]
            entry.pop("bufferView", None)
            entry.pop("sparse", None)


@_either
def _a_face_as_large_as_numbers_go(document: Document, blob: bytearray) -> None:
    _shown(document)["scale"] = [1e30, 1e30, 1e30]
    _shown(document).pop("skin", None)


@_either
def _a_face_without_any_size(document: Document, blob: bytearray) -> None:
    _shown(document)["scale"] = [0, 0, 0]
    _shown(document).pop("skin", None)


@_either
def _joints_without_any_size(document: Document, blob: bytearray) -> None:
    document["nodes"][0]["scale"] = [0, 0, 0]


@_either
def _weights_of_vertices_that_are_all_zero(document: Document, blob: bytearray) -> None:
    accessor = document["accessors"][_face(document)["attributes"]["WEIGHTS_0"]]
    view = document["bufferViews"][accessor["bufferView"]]
    start = view["byteOffset"]
    blob[start : start + view["byteLength"]] = bytes(view["byteLength"])


@_either
def _one_key_only(document: Document, blob: bytearray) -> None:
    animation, channel = _weights(document)
    sampler = animation["samplers"][channel["sampler"]]
    values = document["accessors"][sampler["output"]]
    times = document["accessors"][sampler["input"]]
    values["count"] //= times["count"]
    times |= {"count": 1, "max": [0.0]}


@_either
def _triangles_of_another_mode(document: Document, blob: bytearray) -> None:
    _face(document)["mode"] = 5


@_either
def _points_only(document: Document, blob: bytearray) -> None:
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["mode"] = 0


@_either
def _no_triangles_named(document: Document, blob: bytearray) -> None:
    del _face(document)["indices"]


@_either
def _a_document_without_scenes(document: Document, blob: bytearray) -> None:
    del document["scenes"], document["scene"]


@_either
def _weights_of_ones_and_more(document: Document, blob: bytearray) -> None:
    """Keys far outside of what sliders have: bends go straight on there."""
    animation, channel = _weights(document)
    accessor = document["accessors"][animation["samplers"][channel["sampler"]]["output"]]
    start = document["bufferViews"][accessor["bufferView"]]["byteOffset"]
    values = np.linspace(-3, 5, accessor["count"]).astype("<f4")
    blob[start : start + values.nbytes] = values.tobytes()


@_either
def _keys_that_are_no_numbers(document: Document, blob: bytearray) -> None:
    animation, channel = _weights(document)
    accessor = document["accessors"][animation["samplers"][channel["sampler"]]["output"]]
    start = document["bufferViews"][accessor["bufferView"]]["byteOffset"]
    struct.pack_into("<f", blob, start + 4, float("nan"))
