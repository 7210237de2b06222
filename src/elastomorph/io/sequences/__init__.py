"""Motion in files: numbered meshes, an archive, or a performance written as a take."""

from elastomorph.io.sequences.meshes import read_sequence, write_sequence

__all__ = ["read_sequence", "write_sequence"]
