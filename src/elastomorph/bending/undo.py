"""What undoes a bend: the few things of a document that changed, kept in the document itself.

``extras.elastomorph`` of the document is::

    {"version": 1, "undo": {…}, "chunk": 2700120, "made": "9f…"}

``undo`` is a patch that makes the document of the original: of an object, ``set`` holds members as
they were, ``cut`` names those that were added and ``in`` patches others; of a list, ``cut`` is the
length it had. ``chunk`` is the length that the binary chunk had, null where there was none.
``made`` is a digest of all the rest: it tells whether another program has changed anything since,
so that the patch no longer fits. Patch and digest are of the document with ``extras`` that have no
record, empty ones if there are no others, so that both are the same before and after the record.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any, NoReturn

from elastomorph.io.gltf.container import GltfFile

_VERSION = 1
_KEY = "elastomorph"


def record(
    original: dict[str, Any], bent: dict[str, Any], length: int | None, chunk: bytes | None
) -> dict[str, Any]:
    """The document of a bent file, with its binary chunk, and what undoes it.

    The chunk had another length before, None where there was none.
    """
    bare = _without_record(bent)
    patch = reverse_patch(original, bare) or {}
    digest = _digest(bare, chunk or b"")
    own = {"version": _VERSION, "undo": patch, "chunk": length, "made": digest}
    return {**bare, "extras": {**bare["extras"], _KEY: own}}


def _without_record(document: dict[str, Any]) -> dict[str, Any]:
    extras = {key: own for key, own in document.get("extras", {}).items() if key != _KEY}
    return {**document, "extras": extras}


def is_bent(file: GltfFile) -> bool:
    """Whether a document says that `bend` made it."""
    extras = file.document.get("extras")
    own = extras.get(_KEY) if isinstance(extras, dict) else None
    return isinstance(own, dict) and ("undo" in own or "version" in own)


def undone(file: GltfFile) -> tuple[dict[str, Any], bytes | None]:
    """The document and the binary chunk of the original of a bent file."""
    chunk = file.chunk
    own = file.document["extras"][_KEY]
    if own.get("version") != _VERSION:
        file.refuse(
            "it was bent by a newer version of elastomorph; update, or bend the original instead"
        )
    bent = _without_record(file.document)
    length = own.get("chunk")
    known = type(length) is int and chunk is not None and 0 <= length <= len(chunk)
    if not known and length is not None:
        _refuse(file)
    # Up to 0.2 there were no empty extras in the digest of a file that had none.
    earlier = {key: inner for key, inner in bent.items() if key != "extras" or inner}
    if own.get("made") == _digest(earlier, chunk or b""):
        bent = earlier
    elif own.get("made") != _digest(bent, chunk or b""):
        _refuse(file)
    try:
        document = patched(bent, own["undo"])
    except (AttributeError, LookupError, TypeError, ValueError):
        _refuse(file)
    return document, None if length is None or chunk is None else chunk[:length]


def reverse_patch(old: Any, new: Any) -> dict[str, Any] | None:
    """What makes the old JSON value of the new one; None where they are the same."""
    if isinstance(old, dict) and isinstance(new, dict):
        again = [key for key in new if key in old] + [key for key in old if key not in new]
        if again != list(old):  # another entry in its place: members come back in their order
            return {"was": old}
        inside = {key: reverse_patch(old[key], new[key]) for key in old if key in new}
        parts = {
            "set": {key: value for key, value in old.items() if key not in new},
            "cut": [key for key in new if key not in old],
            "in": {key: patch for key, patch in inside.items() if patch is not None},
        }
        return {name: part for name, part in parts.items() if part} or None
    if isinstance(old, list) and isinstance(new, list) and len(old) <= len(new):
        within = {
            str(place): patch
            for place, pair in enumerate(zip(old, new, strict=False))
            if (patch := reverse_patch(*pair)) is not None
        }
        found: dict[str, Any] = {"in": within} if within else {}
        return found | ({"cut": len(old)} if len(old) < len(new) else {}) or None
    same = type(old) is type(new) and old == new and not isinstance(old, list)
    return None if same else {"was": old}


def patched(value: Any, patch: dict[str, Any]) -> Any:
    """A JSON value with a patch of `reverse_patch` applied."""
    if "was" in patch:
        return patch["was"]
    inside = patch.get("in", {})
    if isinstance(value, list):
        own = value[: patch.get("cut", len(value))]
        for place, inner in inside.items():
            own[int(place)] = patched(own[int(place)], inner)
        return own
    kept = {key: own for key, own in value.items() if key not in patch.get("cut", ())}
    for key, inner in inside.items():
        kept[key] = patched(kept[key], inner)
    return kept | patch.get("set", {})


def _digest(document: dict[str, Any], chunk: bytes) -> str:
    buffers = document.get("buffers")
    if isinstance(buffers, list):  # files beside it may be renamed
        document = {**document, "buffers": [_unnamed(own) for own in buffers]}
    # As other programs write numbers: 1.0 and 1 are the same to JSON.
    text = json.dumps(_plain(document), sort_keys=True, separators=(",", ":"))
    found = hashlib.blake2b(chunk, digest_size=16)
    found.update(text.encode())
    return found.hexdigest()


def _unnamed(buffer: Any) -> Any:
    if not isinstance(buffer, dict):
        return buffer
    return {key: own for key, own in buffer.items() if key != "uri"}


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(own) for key, own in value.items()}
    if isinstance(value, list):
        return [_plain(own) for own in value]
    if isinstance(value, float) and value.is_integer() and abs(value) < 2**53:
        return int(value)
    return value


def _refuse(file: GltfFile) -> NoReturn:
    file.refuse(
        "another program has changed it since it was bent, so that the bends cannot be taken out; "
        "bend the original instead, or give lost curves back by 'elastomorph bend --from'"
    )
