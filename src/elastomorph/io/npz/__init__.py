"""NumPy archives (.npz): meshes, recorded motion and rigs, complete and bit for bit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from elastomorph._lazy import lazy_names

if TYPE_CHECKING:
    from elastomorph.io.npz.mesh import read_npz, read_npz_sequence, write_npz, write_npz_sequence

__all__ = ["read_npz", "read_npz_sequence", "write_npz", "write_npz_sequence"]

__getattr__ = lazy_names(__name__, {"mesh": (*__all__,)})
