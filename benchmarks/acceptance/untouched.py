"""What a bent document may differ in from the one it came from; everything else is a difference."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import numpy as np

from acceptance.gltf_file import GltfFile

_OWN = "elastomorph"
_RULED = ("accessors", "bufferViews", "buffers", "meshes", "nodes", "animations", "extras")


def differences(
    original: GltfFile, bent: GltfFile, arrays: tuple[GltfFile, GltfFile] | None = None
) -> list[str]:
    """Sentences about everything that bending may not have changed, or left out; none if sound.

    Args:
        original: The document that was bent.
        bent: What came of it.
        arrays: The same two with arrays that can be read, where they are compressed.
    """
    return [*_all(original, bent), *_animations(*(arrays or (original, bent)))]


def _all(original: GltfFile, bent: GltfFile) -> Iterator[str]:
    before, after = original.document, bent.document
    kept = [key for key in after if key in before]
    if kept != list(before):
        yield f"the root has {list(after)} for {list(before)}"
    for key in after:
        if key not in _RULED and (key not in before or not same(before[key], after[key])):
            yield f"'{key}' has changed"
    if not same(before.get("extras", {}), _without(after.get("extras", {}), _OWN)):
        yield "the extras of the root have changed"
    accessors, views = _of_weights_alone(original)
    yield from _prefix("accessors", original.accessors, bent.accessors, accessors)
    yield from _prefix("bufferViews", original.bufferViews, bent.bufferViews, views)
    yield from _buffers(original, bent)
    yield from _meshes(original, bent)
    yield from _nodes(original, bent)
    yield from broken_indices(bent)


def same(one: Any, other: Any) -> bool:
    """Whether two pieces of JSON are equal, in the order of their keys and the kind of numbers."""
    if type(one) is not type(other):
        return False
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


def _without(holder: dict[str, Any], *keys: str) -> dict[str, Any]:
    return {key: value for key, value in holder.items() if key not in keys}


def _prefix(of: str, before: list[Any], after: list[Any], free: set[int]) -> Iterator[str]:
    for number, entry in enumerate(before):
        if number >= len(after) or not (number in free or same(entry, after[number])):
            yield f"{of}[{number}] has changed"


def _of_weights_alone(file: GltfFile) -> tuple[set[int], set[int]]:
    """Accessors, and views, that hold nothing but keys of weights: others may take their place."""
    document = {key: value for key, value in file.document.items() if key != "animations"}
    others, weights = set(_numbers(document, "accessor")), set[int]()
    for animation in file.animations:
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            (weights if _weights(channel) else others).update(
                sampler[key] for key in ("input", "output")
            )
    free = weights - others
    kept = {**document, "accessors": [a for n, a in enumerate(file.accessors) if n not in free]}
    views = {file.accessors[number].get("bufferView") for number in free}
    return free, {view for view in views if view is not None} - set(_numbers(kept, "bufferView"))


def _numbers(value: Any, kind: str) -> Iterator[int]:
    """Where JSON names accessors (as attributes, targets, indices, matrices), or buffer views."""
    if isinstance(value, list):
        for each in value:
            yield from _numbers(each, kind)
    elif isinstance(value, dict):
        for key, own in value.items():
            named = ("bufferView",) if kind == "bufferView" else ("indices", "inverseBindMatrices")
            if key in named and isinstance(own, int):
                yield own
            elif kind == "accessor" and key in ("attributes", "targets"):
                for group in own if isinstance(own, list) else [own]:
                    yield from (n for n in dict(group).values() if isinstance(n, int))
            else:
                yield from _numbers(own, kind)


def _buffers(original: GltfFile, bent: GltfFile) -> Iterator[str]:
    for number, entry in enumerate(original.buffers):
        own = bent.buffers[number] if number < len(bent.buffers) else {}
        if not same(_without(entry, "byteLength", "uri"), _without(own, "byteLength", "uri")):
            yield f"buffers[{number}] has changed"
        elif ("uri" in entry) != ("uri" in own) or own["byteLength"] < entry["byteLength"]:
            yield f"buffers[{number}] is kept elsewhere, or shorter"
        elif not bent.contents[number].startswith(original.contents[number]):
            yield f"the bytes of buffers[{number}] have changed"
    for number, entry in enumerate(bent.buffers):
        content = bent.contents[number]
        if content and len(content) != entry["byteLength"]:
            yield f"buffers[{number}] has {len(content)} bytes of {entry['byteLength']}"


def _meshes(original: GltfFile, bent: GltfFile) -> Iterator[str]:
    if len(original.meshes) != len(bent.meshes):
        yield f"{len(bent.meshes)} meshes for {len(original.meshes)}"
    for number, (before, after) in enumerate(zip(original.meshes, bent.meshes, strict=False)):
        counts = {len(own.get("targets", [])) for own in after["primitives"]}
        had = max(len(own.get("targets", [])) for own in before["primitives"])
        if len(counts) > 1 and len({len(p.get("targets", [])) for p in before["primitives"]}) == 1:
            yield f"the primitives of meshes[{number}] have {sorted(counts)} targets"
        grown = max(counts) > had
        if not same(before, _shortened(after, before)):
            yield f"meshes[{number}] has changed"
        if not grown and not same(before, after):
            extras = _without(after.get("extras", {}), _OWN)
            if not same(before.get("extras", {}), extras):
                yield f"meshes[{number}] has no new target, and has changed"
        weights = after.get("weights")
        if weights is not None and len(weights) != max(counts):
            yield f"meshes[{number}] has {len(weights)} weights for {max(counts)} targets"


def _shortened(after: dict[str, Any], before: dict[str, Any]) -> dict[str, Any]:
    """A mesh with no more targets than it had, and without what describes their bends."""
    found = copy.deepcopy(after)
    _shorten(found, before, "weights")
    _bare_extras(found, before)
    for own, was in zip(found["primitives"], before["primitives"], strict=False):
        _shorten(own, was, "targets")
        _bare_extras(own, was)
    return found


def _shorten(holder: dict[str, Any], was: dict[str, Any], key: str) -> None:
    if isinstance(holder.get(key), list) and isinstance(was.get(key), list):
        holder[key] = holder[key][: len(was[key])]
    elif key == "weights" and key not in was:
        holder.pop(key, None)


def _bare_extras(holder: dict[str, Any], was: dict[str, Any]) -> None:
    extras = holder.get("extras")
    if not isinstance(extras, dict):
        return
    extras.pop(_OWN, None)
    had = was.get("extras")
    if isinstance(had, dict):
        _shorten(extras, had, "targetNames")
        if "targetNames" not in had:
            extras.pop("targetNames", None)
    else:
        extras.pop("targetNames", None)
        if not extras:
            del holder["extras"]


def _nodes(original: GltfFile, bent: GltfFile) -> Iterator[str]:
    if len(original.nodes) != len(bent.nodes):
        yield f"{len(bent.nodes)} nodes for {len(original.nodes)}"
    for number, (before, after) in enumerate(zip(original.nodes, bent.nodes, strict=False)):
        shortened = dict(after)
        _shorten(shortened, before, "weights")
        if not same(before, shortened):
            yield f"nodes[{number}] has changed"
        if "weights" in after and "mesh" in after:
            primitives = bent.meshes[after["mesh"]]["primitives"]
            count = max(len(own.get("targets", [])) for own in primitives)
            if len(after["weights"]) != count:
                yield f"nodes[{number}] has {len(after['weights'])} weights for {count} targets"


def _animations(original: GltfFile, bent: GltfFile) -> Iterator[str]:
    if len(original.animations) != len(bent.animations):
        yield f"{len(bent.animations)} animations for {len(original.animations)}"
    for number, (was, now) in enumerate(zip(original.animations, bent.animations, strict=False)):
        of = f"animations[{number}]"
        if not same(_without(was, "channels", "samplers"), _without(now, "channels", "samplers")):
            yield f"{of} has changed"
        for k, channel in enumerate(was["channels"]):
            own = now["channels"][k] if k < len(now["channels"]) else {}
            if not same(_without(channel, "sampler"), _without(own, "sampler")):
                yield f"{of}.channels[{k}] has changed"
                continue
            before = was["samplers"][channel["sampler"]]
            after = now["samplers"][own["sampler"]]
            if not _weights(channel):
                if channel["sampler"] != own["sampler"] or not same(before, after):
                    yield f"{of}.channels[{k}] is sampled otherwise"
            else:
                yield from _grown(f"{of}.channels[{k}]", original, before, bent, after)


def _weights(channel: dict[str, Any]) -> bool:
    target = channel["target"]
    pointer = target.get("extensions", {}).get("KHR_animation_pointer", {}).get("pointer", "")
    return target["path"] == "weights" or "/weights" in pointer


def _grown(
    of: str, original: GltfFile, before: dict[str, Any], bent: GltfFile, after: dict[str, Any]
) -> Iterator[str]:
    """Every key of before is there, at the same time and with the same weights of its targets."""
    rest = ("input", "output")
    if not same(_without(before, *rest), _without(after, *rest)):
        yield f"{of} is interpolated otherwise"
        return
    was, now = (file.array(own["input"])[:, 0] for file, own in ((original, before), (bent, after)))
    at = np.searchsorted(now, was)
    if (at >= len(now)).any() or not np.array_equal(now[at], was):
        yield f"{of} has lost keys"
        return
    values, grown = (
        file.array(own["output"]).reshape(len(times), parts, -1)
        for file, own, times, parts in (
            (original, before, was, 3 if before.get("interpolation") == "CUBICSPLINE" else 1),
            (bent, after, now, 3 if after.get("interpolation") == "CUBICSPLINE" else 1),
        )
    )
    middle = values.shape[1] // 2
    shared = grown[at, middle, : values.shape[2]]
    if not np.allclose(shared, values[:, middle], rtol=0, atol=1e-7):  # of whole numbers too
        yield f"{of} has other weights at its keys"


_PLACES = (
    ("accessors", "bufferView", "bufferViews"),
    ("bufferViews", "buffer", "buffers"),
    ("nodes", "mesh", "meshes"),
    ("nodes", "skin", "skins"),
)


def broken_indices(file: GltfFile) -> Iterator[str]:
    """References of a document that lead nowhere, and counts that do not agree."""
    for kind, key, to in _PLACES:
        for number, entry in enumerate(getattr(file, kind)):
            if key in entry and not 0 <= entry[key] < len(getattr(file, to)):
                yield f"{kind}[{number}].{key} leads nowhere"
    for number, mesh in enumerate(file.meshes):
        for primitive in mesh["primitives"]:
            positions = file.accessors[primitive["attributes"]["POSITION"]]["count"]
            for target in primitive.get("targets", []):
                used = [own for own in target.values() if isinstance(own, int)]
                if any(file.accessors[own]["count"] != positions for own in used):
                    yield f"a target of meshes[{number}] has another count than its positions"
    for number, animation in enumerate(file.animations):
        for channel in animation["channels"]:
            if not 0 <= channel["sampler"] < len(animation["samplers"]):
                yield f"a channel of animations[{number}] has no sampler"
