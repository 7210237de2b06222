"""Rigs as data sets keep them: packed, known again, told apart."""

from __future__ import annotations

import base64
import hashlib
import io
import json
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from elastomorph.io.npz.members import open_npz, pack_arrays
from elastomorph.io.npz.rig import rig_arrays, rig_of_members
from elastomorph.io.temporaries import temporary_folder
from elastomorph.model.appearance import Material, Texture
from elastomorph.rig.build import extent_of
from elastomorph.rig.rig import Rig

_LOOKS = "appearance"
_ROUNDING = 1e-6  # Of D: paths made on another processor may differ by so little


def rig_hash(rig: Rig) -> str:
    """A number that tells rigs apart which make different faces."""
    arrays = rig_arrays(rig)
    matter = ("neutral", "face_", "morph_names", "bend_counts", "field_", "curve", "corrective_")
    own = hashlib.blake2b(digest_size=16)
    for name, array in arrays.items():
        if name.startswith(matter):
            own.update(f"{name} {array.shape} {array.dtype.str}".encode())
            own.update(np.ascontiguousarray(array).tobytes())
    return own.hexdigest()


def packed(rig: Rig) -> bytes:
    """The bytes of the rig's archive (.npz), and how it looks."""
    arrays, looks = rig_arrays(rig), rig.neutral.appearance
    if looks is not None:
        arrays[_LOOKS] = np.array(
            [
                json.dumps(
                    {n: asdict(replace(m, finish=None)) for n, m in looks.items()}, default=_coded
                )
            ]
        )
    file = io.BytesIO()
    pack_arrays(file, arrays)
    return file.getvalue()


def unpacked(content: bytes) -> Rig:
    """The rig of an archive's bytes."""
    with temporary_folder() as folder:
        path = folder / "rig.npz"
        path.write_bytes(content)
        with open_npz(path) as members:
            rig = rig_of_members(members)
            if _LOOKS in members.names:
                looks = json.loads(members.texts(_LOOKS, 1)[0])
                # A mesh is not changed once others have it; nobody has this one yet.
                vars(rig.neutral).update(appearance={n: _material(m) for n, m in looks.items()})
            return rig


def _coded(value: object) -> str:
    """The bytes of an image as text."""
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    raise TypeError(f"{type(value).__name__} in a material")


def _material(found: dict[str, Any]) -> Material:
    texture = found["texture"]
    if texture is not None:
        lists = {name: tuple(own) for name, own in texture.items() if isinstance(own, list)}
        image = base64.b64decode(texture["image"])
        texture = Texture(**{**texture, **lists, "image": image})
    return Material(**{**found, "colour": tuple(found["colour"]), "texture": texture})


def same_rig(a: Rig, b: Rig) -> bool:
    """Whether two rigs make the same faces but for rounding."""
    if a.sliders != b.sliders or a.neutral.faces != b.neutral.faces:
        return False
    times, near = np.linspace(0, 1, 17), _ROUNDING * (extent_of(a) or 1.0)
    first, second = a.fields.matrix(np.float64), b.fields.matrix(np.float64)
    if first.shape != second.shape or not np.allclose(first, second, rtol=0, atol=near):
        return False
    return all(
        np.allclose(own.factors(times), other.factors(times), rtol=0, atol=_ROUNDING)
        for own, other in zip(a.fields.morphs, b.fields.morphs, strict=True)
    )
