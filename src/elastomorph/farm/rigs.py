"""Rigs as data sets keep them: packed, known again, told apart."""

from __future__ import annotations

import hashlib
import io

import numpy as np

from elastomorph.io.npz.members import open_npz, pack_arrays
from elastomorph.io.npz.rig import rig_arrays, rig_of_members
from elastomorph.io.temporaries import temporary_folder
from elastomorph.rig.build import extent_of
from elastomorph.rig.rig import Rig

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
    """The bytes of the rig's archive (.npz)."""
    file = io.BytesIO()
    pack_arrays(file, rig_arrays(rig))
    return file.getvalue()


def unpacked(content: bytes) -> Rig:
    """The rig of an archive's bytes."""
    with temporary_folder() as folder:
        path = folder / "rig.npz"
        path.write_bytes(content)
        with open_npz(path) as members:
            return rig_of_members(members)


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
