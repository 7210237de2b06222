"""What bends made useless in a document gives its place to what they added.

A clip that plays bent has other keys, and nothing uses those it had: a sampler, accessors of its
keys, views of these, and a buffer that held nothing else. Left where they are, every validator
would remark on them. Their bytes stay, and the record that undoes a bend gives them their places
back.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

Places = Iterator[tuple[dict[str, Any], str]]
"""Each object and key whose value is a number of one kind."""


def fill_gaps(before: dict[str, Any], after: dict[str, Any]) -> None:
    """Move the last of what was added to where only something was that nothing uses any more."""
    clips = zip(_objects(before, "animations"), _objects(after, "animations"), strict=True)
    for was, now in clips:
        _fill(was, now, "samplers", _samplers(was), _samplers(now))
    _fill(before, after, "accessors", _accessors(before), _accessors(after))
    for key, place in (("bufferViews", "bufferView"), ("buffers", "buffer")):
        _fill(before, after, key, _places(before, place), _places(after, place))


def _fill(
    before: dict[str, Any], after: dict[str, Any], key: str, had: Places, has: Places
) -> None:
    was, now = before.get(key), after.get(key)
    if not isinstance(was, list) or not isinstance(now, list):
        return
    users: dict[int, list[tuple[dict[str, Any], str]]] = {}
    for holder, place in has:
        users.setdefault(holder[place], []).append((holder, place))
    gaps = {holder[place] for holder, place in had} - users.keys()
    for gap in sorted(gaps.intersection(range(len(was)))):
        if len(now) == len(was):
            return
        now[gap] = now.pop()
        for holder, place in users.pop(len(now), []):
            holder[place] = gap


def _samplers(animation: dict[str, Any]) -> Places:
    for channel in _objects(animation, "channels"):
        yield from _numbers(channel, "sampler")


def _accessors(document: dict[str, Any]) -> Places:
    """Where accessors are named; as attributes by extensions too."""
    for animation in _objects(document, "animations"):
        for sampler in _objects(animation, "samplers"):
            yield from _numbers(sampler, "input", "output")
    for skin in _objects(document, "skins"):
        yield from _numbers(skin, "inverseBindMatrices")
    for mesh in _objects(document, "meshes"):
        for primitive in _objects(mesh, "primitives"):
            yield from _numbers(primitive, "indices")
            for target in _objects(primitive, "targets"):
                yield from _numbers(target, *target)
    for holder in _everywhere(document):
        if isinstance(attributes := holder.get("attributes"), dict):
            yield from _numbers(attributes, *attributes)


def _places(document: dict[str, Any], key: str) -> Places:
    """Where buffer views or buffers are named, by extensions too."""
    for holder in _everywhere(document):
        yield from _numbers(holder, key)


def _numbers(holder: dict[str, Any], *keys: str) -> Places:
    return ((holder, key) for key in keys if type(holder.get(key)) is int)


def _objects(holder: dict[str, Any], key: str) -> list[dict[str, Any]]:
    own = holder.get(key)
    return [each for each in own if isinstance(each, dict)] if isinstance(own, list) else []


def _everywhere(value: Any) -> Iterator[dict[str, Any]]:
    """All objects of a document, but those in extras."""
    if isinstance(value, dict):
        yield value
        for key, own in value.items():
            if key != "extras":
                yield from _everywhere(own)
    elif isinstance(value, list):
        for own in value:
            yield from _everywhere(own)
