"""Files: meshes, rigs and recorded motion, one module a format, found by suffix."""

from __future__ import annotations

from typing import TYPE_CHECKING

from elastomorph._lazy import lazy_names

if TYPE_CHECKING:
    from elastomorph.io.registry import read, write
    from elastomorph.io.rig_folder import read_rig
    from elastomorph.io.sequences import read_markers, read_sequence, write_sequence

__all__ = ["read", "read_markers", "read_rig", "read_sequence", "write", "write_sequence"]

__getattr__ = lazy_names(
    __name__,
    {
        "registry": ("read", "write"),
        "rig_folder": ("read_rig",),
        "sequences": ("read_markers", "read_sequence", "write_sequence"),
    },
)
