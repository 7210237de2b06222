"""Motion in files: numbered meshes, archives, caches, and performances written as takes."""

from elastomorph.io.sequences.meshes import write_sequence
from elastomorph.io.sequences.points import read_markers
from elastomorph.io.sequences.recordings import read_recording, read_sequence

__all__ = ["read_markers", "read_recording", "read_sequence", "write_sequence"]
