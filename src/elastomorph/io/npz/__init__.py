"""NumPy archives (.npz): meshes, recorded motion, rigs and markers, complete and bit for bit."""

from elastomorph.io.npz.mesh import read_npz, read_npz_sequence, write_npz, write_npz_sequence

__all__ = ["read_npz", "read_npz_sequence", "write_npz", "write_npz_sequence"]
