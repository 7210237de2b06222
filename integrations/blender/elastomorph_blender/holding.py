"""Correctives that hold a face together, as shape keys that follow laws of others."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import bpy
import numpy as np

from elastomorph import Morph, Rig
from elastomorph.errors import ElastomorphWarning
from elastomorph.holding import Held, hold

from .bending import add_key, adopt
from .face import Face, positions, read_face
from .record import Follower, followers, imported, keep


def hold_face(things: Sequence[bpy.types.Object]) -> Held:
    """Add the correctives of `elastomorph.hold` to these objects, each where it moves them.

    Everything is read and computed before anything is changed.
    """
    face = read_face(things)
    rig = _with_bends(face)
    held = hold(rig)
    added = {n: c for n, c in held.rig.sliders.correctives.items() if n not in rig}
    for part, span in zip(face.parts, face.spans, strict=True):
        adopt(part.thing)
        for name, law in added.items():
            offsets = part.own(held.rig[name].delta[span])
            lacks = {*law.drivers} - part.offsets.keys()
            if offsets.any() and lacks:
                warnings.warn(
                    f"{name} is left out of {part.thing.name}, which has no key {min(lacks)}",
                    ElastomorphWarning,
                    stacklevel=2,
                )
            elif offsets.any():
                block, _ = add_key(part, law, name, offsets)
                own = Follower(block.name, block.name, law, method="hold")
                keep(part.keys, [*followers(part.keys), own])
        part.thing.data.update()
    return held


def _with_bends(face: Face) -> Rig:
    """The face with the paths that its keys have."""
    neutral, laws = face.rig.neutral, dict(face.rig.sliders.correctives)
    bends: dict[str, list[tuple[np.ndarray, Follower]]] = {}
    for part, span in zip(face.parts, face.spans, strict=True):
        for own in (*imported(part.keys), *followers(part.keys)):
            if own.curve is not None:
                field = np.zeros_like(neutral.vertices)
                offsets = positions(part.keys.key_blocks[own.name]) - part.basis
                field[span] = part.turned(offsets)
                bends.setdefault(own.target, []).append((field, own))
                laws |= {own.target: own.law} if own.of_pair else {}
    ends = {name: morph.target for name, morph in face.rig.morphs.items()}
    morphs = {
        name: Morph(
            neutral,
            ends.get(name, neutral),
            np.array([field for field, _ in bends.get(name, ())]).reshape(
                -1, len(neutral.vertices), 3
            ),
            tuple(own.curve for _, own in bends.get(name, ())),
        )
        for name in (*ends, *(name for name in bends if name not in ends))
    }
    return Rig(neutral, morphs, correctives=laws)
